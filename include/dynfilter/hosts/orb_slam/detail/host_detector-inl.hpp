// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/orb_slam/host_detector.hpp>

#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <dynfilter/semantic/async_runner.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <filesystem>
#include <system_error>

namespace dynfilter {

DYNFILTER_INLINE Input semantic_inputs(const OrbSlamParams& params) {
  const auto if_named = [](const std::string& name, Input input) {
    return name.empty() ? Input::None : input;
  };
  return if_named(params.boxes, Input::Detections) | if_named(params.masks, Input::Mask) |
         if_named(params.detector, Input::Detections | Input::Mask);
}

namespace orb_slam {

namespace detail {

/// A detector's YAML file beside the settings file, by its path, or an installed one.
inline std::filesystem::path find_detector(const std::string& name, const std::filesystem::path& folder) {
  constexpr PresetKind kDetectors{"detector", "detectors"};
  PresetFolders folders;
  folders.first.push_back(folder);
  for (const std::filesystem::path& pipelines : dynfilter::detail::built_in_presets(kPipelinePresets))
    folders.installed.push_back(pipelines.parent_path() / kDetectors.folder);
  return find_preset(name, folders, kDetectors);
}

/// Boxes and masks of files come with their frames; a detector runs as `detector_mode` says.
inline RunnerParams runner_params(const OrbSlamParams& params, bool files) {
  RunnerParams runner;
  runner.mode = RunnerMode::Sync;
  if (files) return runner;
  try {
    return parse_runner_mode(params.detector_mode);
  } catch (const ConfigError& error) {
    throw ConfigError("DynFilter.detector_mode", error.what());
  }
}

inline std::string single_quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? "''" : std::string(1, c);
  return result + "'";
}

/// `boxes` and `masks` are those of a detector of type `files`.
inline YamlDocument files_detector(const OrbSlamParams& params) {
  std::string text = "%YAML:1.0\ndetector:\n  type: files\n";
  const auto add = [&](const char* key, const std::string& value) {
    if (!value.empty()) text += std::string("  ") + key + ": " + single_quoted(value) + "\n";
  };
  add("detections", params.boxes);
  add("masks", params.masks);
  return YamlDocument::from_text(text);
}

inline std::unique_ptr<SemanticProvider> make_provider(const OrbSlamParams& params,
                                                       const std::filesystem::path& folder,
                                                       const ProviderRegistry& providers) {
  if (params.detector.empty())
    return read_detector(files_detector(params), providers, ProviderFiles{{folder, "."}}).make();
  std::filesystem::path networks = folder / params.network_dir;  // an absolute one stays
  std::error_code error;
  if (!std::filesystem::is_directory(networks, error)) networks = params.network_dir;
  return detector_from_file(find_detector(params.detector, folder), providers, networks).make();
}

DYNFILTER_INLINE std::unique_ptr<SemanticRunner> make_semantics(const OrbSlamParams& params,
                                                                const std::string& settings_file,
                                                                const ProviderRegistry& providers) {
  const bool files = !params.boxes.empty() || !params.masks.empty();
  if (!files && params.detector.empty()) return nullptr;
  if (files && !params.detector.empty())
    throw ConfigError("DynFilter.detector", "given beside DynFilter.boxes or DynFilter.masks: expected one");
  const RunnerParams runner = runner_params(params, files);
  std::filesystem::path folder = std::filesystem::path(settings_file).parent_path();
  if (folder.empty()) folder = ".";
  const char* key = !files ? "detector" : params.boxes.empty() ? "masks" : "boxes";
  if (providers.names().empty())
    throw ConfigError(std::string("DynFilter.") + key,
                      "this host has no detectors: link dynfilter::detectors and hand in host_providers() of "
                      "<dynfilter/detectors/host_providers.hpp>");
  try {
    return make_runner(make_provider(params, folder, providers), runner);
  } catch (const Error& error) {
    const bool lacks_dnn = std::string(error.what()).find("got `dnn`") != std::string::npos;
    const char* hint = lacks_dnn ? " (`dnn`: link dynfilter::dnn, or use a detector of type `process`)" : "";
    throw ConfigError(std::string("DynFilter.") + key, std::string(error.what()) + hint);
  }
}

}  // namespace detail

}  // namespace orb_slam

}  // namespace dynfilter
