// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/presets.hpp>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace dynfilter::command {

inline constexpr PresetKind kPipelines = kPipelinePresets;
inline constexpr PresetKind kDetectors{"detector", "detectors"};

/// Beside the installed program (<prefix>/share/dynfilter), then the folder that its build names.
inline PresetFolders command_folders(const PresetKind& kind) {
  PresetFolders folders;
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error)
    folders.installed.push_back(
        (program.parent_path() / DYNFILTER_DATA_FROM_BIN / kind.folder).lexically_normal());
#ifdef DYNFILTER_PRESETS_SOURCE
  folders.installed.push_back(std::filesystem::path(DYNFILTER_PRESETS_SOURCE) / kind.folder);
#endif
  return folders;
}

inline std::vector<std::string> preset_names(const PresetKind& kind) {
  return dynfilter::preset_names(command_folders(kind), kind);
}
/// A file by a preset's name or by its path. Throws ConfigError that lists the presets.
inline std::filesystem::path find_preset(const std::string& name, const PresetKind& kind) {
  return dynfilter::find_preset(name, command_folders(kind), kind);
}
inline std::filesystem::path find_pipeline(const std::string& name) {
  return find_preset(name, kPipelines);
}

}  // namespace dynfilter::command
