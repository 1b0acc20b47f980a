// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/registry.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace dynfilter {

/// Files that are found by a short name: `NAME.yaml` in one of the folders searched.
struct PresetKind {
  const char* what;    ///< for messages: "pipeline"
  const char* folder;  ///< below share/dynfilter and below a folder of DYNFILTER_PRESETS
};
inline constexpr PresetKind kPipelinePresets{"pipeline", "pipelines"};

/// Folders to search besides those of the environment variable DYNFILTER_PRESETS and the built-in one. The
/// order is: `first`, DYNFILTER_PRESETS, `installed`, built in.
struct PresetFolders {
  std::vector<std::filesystem::path> first;      ///< the caller's own, each holds the files themselves
  std::vector<std::filesystem::path> installed;  ///< found from the place of a program or a library
};

/// The folders that are searched for a name, in this order; some may not exist.
std::vector<std::filesystem::path> preset_folders(const PresetFolders& folders = {},
                                                  const PresetKind& kind = kPipelinePresets);

/// The names in all these folders, sorted.
std::vector<std::string> preset_names(const PresetFolders& folders = {},
                                      const PresetKind& kind = kPipelinePresets);

/// The file of a preset's name, with `.yaml` or without, or of a path. A relative path is looked for in
/// `folders.first`, then in the working directory. A bare name prefers the presets over a file of that name
/// in the working directory. Throws ConfigError that lists the names known.
std::filesystem::path find_preset(const std::string& name, const PresetFolders& folders = {},
                                  const PresetKind& kind = kPipelinePresets);

/// A pipeline by a preset's name ("dynfilter"), by the path of a file, or from YAML text.
/// A line break or a `{` marks YAML text. Throws ConfigError.
PipelineConfig load_pipeline(const std::string& source, const Registry& registry,
                             const PresetFolders& folders = {});

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/presets-inl.hpp>
#endif
