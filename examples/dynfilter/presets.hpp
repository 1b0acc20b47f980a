// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace dynfilter::command {

/// Where presets lie: beside the installed program (<prefix>/share/dynfilter/pipelines), and in the source
/// tree.
inline std::vector<std::filesystem::path> preset_folders() {
  std::vector<std::filesystem::path> folders;
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) folders.push_back(program.parent_path() / DYNFILTER_PIPELINES_FROM_BIN);
  folders.emplace_back(DYNFILTER_PIPELINES_SOURCE);
  return folders;
}

inline std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const auto& folder : preset_folders()) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
    }
    if (!names.empty()) break;
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// A pipeline's file by a preset's name or by its path. Throws ConfigError that lists the presets.
inline std::filesystem::path find_pipeline(const std::string& name) {
  std::error_code error;
  const bool is_path = name.find('/') != std::string::npos || std::filesystem::path(name).has_extension();
  for (const auto& folder : preset_folders()) {
    const std::filesystem::path preset = folder / (name + ".yaml");
    if (!is_path && std::filesystem::is_regular_file(preset, error)) return preset;
  }
  if (std::filesystem::is_regular_file(name, error)) return name;
  if (is_path) throw ConfigError(name, "no such pipeline file");
  std::string known;
  for (const std::string& preset : preset_names()) known += (known.empty() ? "" : ", ") + preset;
  throw ConfigError(name, "neither a file nor a preset; presets: " + known);
}

}  // namespace dynfilter::command
