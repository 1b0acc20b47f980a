// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/near_miss.hpp>
#include <dynfilter/core/parameters.hpp>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace dynfilter::command {

/// A kind of file that also has short names.
/// The files are beside the installed program (<prefix>/share/dynfilter/...)
/// and in the source tree.
struct PresetKind {
  const char *from_bin, *source, *what;
};
inline constexpr PresetKind kPipelines{DYNFILTER_PIPELINES_FROM_BIN, DYNFILTER_PIPELINES_SOURCE, "pipeline"};
inline constexpr PresetKind kDetectors{DYNFILTER_DETECTORS_FROM_BIN, DYNFILTER_DETECTORS_SOURCE, "detector"};

inline std::vector<std::filesystem::path> preset_folders(const PresetKind& kind = kPipelines) {
  std::vector<std::filesystem::path> folders;
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) folders.push_back(program.parent_path() / kind.from_bin);
  folders.emplace_back(kind.source);
  return folders;
}

inline std::vector<std::string> preset_names(const PresetKind& kind = kPipelines) {
  std::vector<std::string> names;
  for (const auto& folder : preset_folders(kind)) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
    }
    if (!names.empty()) break;
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// Finds a file by preset name or path. Throws ConfigError with the list of presets.
inline std::filesystem::path find_preset(const std::string& name, const PresetKind& kind) {
  std::error_code error;
  const bool is_path = name.find('/') != std::string::npos || std::filesystem::path(name).has_extension();
  for (const auto& folder : preset_folders(kind)) {
    const std::filesystem::path preset = folder / (name + ".yaml");
    if (!is_path && std::filesystem::is_regular_file(preset, error)) return preset;
  }
  if (std::filesystem::is_regular_file(name, error)) return name;
  const std::vector<std::string> known = preset_names(kind);
  const std::string meant = did_you_mean(std::filesystem::path(name).stem().string(), known);
  if (is_path) throw ConfigError(name, std::string("no such ") + kind.what + " file" + meant);
  throw ConfigError(name, "neither a file nor a preset" + meant + "; presets: " + detail::joined(known));
}

inline std::filesystem::path find_pipeline(const std::string& name) {
  return find_preset(name, kPipelines);
}

}  // namespace dynfilter::command
