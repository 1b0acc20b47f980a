// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/presets.hpp>

#include <dlfcn.h>
#include <algorithm>
#include <cstdlib>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <sstream>
#include <system_error>

/// A folder like share/dynfilter, of a source that only CMake's targets bring along. Null without it.
extern "C" __attribute__((weak)) const char dynfilter_presets_folder[];

namespace dynfilter {

namespace detail {

/// The folders of a kind that come with dynfilter. First the one that CMake compiles into a source of the
/// program. Then `share/dynfilter` in folders above the program, and above the library that holds this code.
DYNFILTER_INLINE std::vector<std::filesystem::path> built_in_presets(const PresetKind& kind) {
  namespace fs = std::filesystem;
  std::vector<fs::path> folders;
  std::error_code error;
  const auto add = [&](const fs::path& data) {
    if (fs::is_directory(data / kind.folder, error)) folders.push_back(data / kind.folder);
  };
  if (dynfilter_presets_folder != nullptr) add(dynfilter_presets_folder);
  Dl_info here{};
  const bool known = dladdr(reinterpret_cast<const void*>(&built_in_presets), &here) != 0;
  for (const fs::path& file : {fs::path(known && here.dli_fname != nullptr ? here.dli_fname : ""),
                               fs::path("/proc/self/exe")})  // dladdr() has a program's name as it was typed
    for (fs::path at = fs::canonical(file, error).parent_path(); at.has_relative_path();
         at = at.parent_path())
      add(at / "share/dynfilter");
  return folders;
}

/// Of DYNFILTER_PRESETS, a list with `:` between: a folder like share/dynfilter, with a folder for each kind
/// in it, or one that holds pipelines.
DYNFILTER_INLINE std::vector<std::filesystem::path> environment_presets(const PresetKind& kind) {
  const char* list = std::getenv("DYNFILTER_PRESETS");
  std::vector<std::filesystem::path> folders;
  std::istringstream words(list == nullptr ? "" : list);
  for (std::string word; std::getline(words, word, ':');) {
    if (word.empty()) continue;
    std::error_code error;
    const std::filesystem::path of_kind = std::filesystem::path(word) / kind.folder;
    if (std::filesystem::is_directory(of_kind, error))
      folders.push_back(of_kind);
    else if (std::string(kind.folder) == kPipelinePresets.folder)
      folders.emplace_back(word);
  }
  return folders;
}

}  // namespace detail

DYNFILTER_INLINE std::vector<std::filesystem::path> preset_folders(const PresetFolders& folders,
                                                                   const PresetKind& kind) {
  std::vector<std::filesystem::path> all = folders.first;
  const auto append = [&](const std::vector<std::filesystem::path>& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  append(detail::environment_presets(kind));
  append(folders.installed);
  append(detail::built_in_presets(kind));
  return all;
}

DYNFILTER_INLINE std::vector<std::string> preset_names(const PresetFolders& folders, const PresetKind& kind) {
  std::vector<std::string> names;
  for (const std::filesystem::path& folder : preset_folders(folders, kind)) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
      if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

DYNFILTER_INLINE std::filesystem::path find_preset(const std::string& name, const PresetFolders& folders,
                                                   const PresetKind& kind) {
  namespace fs = std::filesystem;
  const bool has_folder = name.find('/') != std::string::npos,
             is_path = has_folder || fs::path(name).has_extension();
  std::vector<fs::path> candidates;
  if (is_path) {
    for (const fs::path& folder : folders.first) candidates.push_back(folder / name);
    candidates.emplace_back(name);
  }
  if (!has_folder && !name.empty())
    for (const fs::path& folder : preset_folders(folders, kind))
      candidates.push_back(folder / (is_path ? name : name + ".yaml"));
  if (!is_path) candidates.emplace_back(name);
  std::error_code error;
  for (const fs::path& candidate : candidates)
    if (fs::is_regular_file(candidate, error)) return candidate.lexically_normal();

  const std::vector<std::string> known = preset_names(folders, kind);
  const std::string meant = did_you_mean(fs::path(name).stem().string(), known);
  if (is_path) throw ConfigError(name, std::string("no such ") + kind.what + " file" + meant);
  throw ConfigError(name,
                    "neither a file nor a preset" + meant +
                        (known.empty() ? "; no presets are installed: set DYNFILTER_PRESETS to their folder"
                                       : "; presets: " + joined(known)));
}

DYNFILTER_INLINE PipelineConfig load_pipeline(const std::string& source, const Registry& registry,
                                              const PresetFolders& folders) {
  const bool is_yaml_text = source.find_first_of("\n{") != std::string::npos;  // not a name, not a path
  if (is_yaml_text) return pipeline_from_text(source, registry);
  const std::filesystem::path file = find_preset(source, folders);
  if (std::filesystem::path(source).replace_extension() == "oracle" && registry.find("oracle") == nullptr)
    throw ConfigError(
        source, "`oracle` knows the labels of a synthetic sequence: only the command `dynfilter` can run it");
  return pipeline_from_file(file.string(), registry);
}

}  // namespace dynfilter
