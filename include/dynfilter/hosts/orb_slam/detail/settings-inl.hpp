// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/orb_slam/settings.hpp>

#include <algorithm>
#include <cctype>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <dynfilter/pipeline/frame_observer.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/plugin/loader.hpp>
#include <dynfilter/semantic/async_runner.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <filesystem>
#include <system_error>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE HostSensor host_sensor(int sensor) {
  const int kind = sensor >= 0 ? sensor % 3 : 0;
  return kind == 0 ? HostSensor::Monocular : kind == 1 ? HostSensor::Stereo : HostSensor::RgbD;
}

DYNFILTER_INLINE const FieldTable<OrbSlamParams>& OrbSlamParams::fields() {
  using P = OrbSlamParams;
  static const FieldTable<P> table{
      flag("enabled", &P::enabled, "false: the host runs without dynfilter"),
      choice("on_error", &P::on_error, {{"stop", OnError::Stop}, {"off", OnError::Off}},
             "if the settings are wrong: end the host, or run it without rejection"),
      flag("keep_first_frame", &P::keep_first_frame,
           "true: keep features on boxes and masks in the first frame"),
      integer("min_features_before_map", &P::min_features_before_map, "features", {-1, 100000},
              "kept before the map exists; -1: 550, mono 250"),
      integer("min_features", &P::min_features, "features", {0, 100000}, "kept after that"),
      words("plugins", &P::plugins, "modules to load, with filters and detectors"),
      text("boxes", &P::boxes, "file of boxes by timestamp"),
      text("masks", &P::masks, "folder of masks: PNG files named by their timestamps"),
      text("detector", &P::detector, "makes boxes or masks: a preset or a YAML file"),
      text("network_dir", &P::network_dir, "folder of the detector's network files"),
      text("detector_mode", &P::detector_mode,
           "async: in a thread; sync: the tracker waits; late:N, rate:HZ: tests"),
      text("record", &P::record, "flight recorder: the file that gets each frame and verdict"),
  };
  return table;
}

DYNFILTER_INLINE int OrbSlamParams::floor_before_map(HostSensor sensor) const {
  if (min_features_before_map >= 0) return min_features_before_map;
  return sensor == HostSensor::Monocular ? 250 : 550;
}

DYNFILTER_INLINE PipelineConfig configured_pipeline(OrbSlamSettings& settings) {
  PipelineConfig config = std::move(settings.pipeline);
  if (!settings.params.keep_first_frame) config.params.first_frame_suspects = FirstFrameSuspects::Reject;
  return config;
}

DYNFILTER_INLINE void start_recording(const OrbSlamParams& params, Pipeline& pipeline) {
  if (!params.enabled || params.record.empty()) return;
  try {
    pipeline.set_observer(open_recording(params.record));
  } catch (const IoError& error) {
    throw ConfigError("DynFilter.record", error.what());
  }
}

namespace orb_slam::detail {

/// A file beside the settings file or by its path, or an installed pipeline, with `.yaml` or without.
inline std::string find_pipeline(const std::string& name, const std::string& settings_file,
                                 const std::string& path) {
  PresetFolders folders;
  folders.first.push_back(std::filesystem::path(settings_file).parent_path());
  try {
    return find_preset(name, folders).string();
  } catch (const ConfigError&) {
    // The list must not have the host's own YAML files in it, nor what only the command can run.
    std::vector<std::string> known = preset_names();
    known.erase(std::remove(known.begin(), known.end(), "oracle"), known.end());
    const std::string meant = did_you_mean(std::filesystem::path(name).stem().string(), known);
    throw ConfigError(
        path,
        "no pipeline " + in_backticks(name) + meant + ": expected a file beside the settings file, a path" +
            (known.empty() ? std::string(" (no presets are installed)") : ", or one of " + joined(known)));
  }
}

/// Keys that nearly are ours would be ignored without a word, and the default would run instead.
inline void refuse_near_misses(const YamlNode& root, const std::string& prefix) {
  const auto letters = [](const std::string& text) {
    std::string result;
    for (const char c : lower_case(text))
      if (std::isalnum(static_cast<unsigned char>(c)) != 0) result += c;
    return result;
  };
  const std::string ours = letters(prefix);
  const auto refuse = [](const std::string& key, const std::string& hint) {
    throw ConfigError("", "unknown key " + in_backticks(key) + ": " + hint);
  };
  const std::string in_lines = "expected keys as `" + prefix + "pipeline: NAME`, each in a line of its own",
                    capitals = "expected `" + prefix + "...`, with these capitals and a point";
  for (const std::string& key : root.keys()) {
    const bool nearly_prefix = key.rfind(prefix, 0) != 0 && letters(key).rfind(ours, 0) == 0;
    if (nearly_prefix) refuse(key, letters(key) == ours ? in_lines : capitals);
    const bool nearly_pipeline =
        key != "pipeline" && lower_case(key.substr(0, 1)) == "p" && edit_distance(key, "pipeline") <= 2;
    if (nearly_pipeline) refuse(key, "did you mean `pipeline`?");
  }
}

/// The keys `prefix...` of a flat file over `p`. Returns the text of `text_key` after the prefix.
template <class P>
std::string read_prefixed(const YamlNode& root, const std::string& prefix, const std::string& text_key,
                          P& p) {
  std::string text;
  for (const auto& [key, value] : root.entries(prefix)) {
    const std::string name = key.substr(prefix.size());
    const dynfilter::detail::AnyFields& table = P::fields().all();
    const auto field =
        std::find_if(table.begin(), table.end(), [&](const auto& f) { return f.name == name; });
    if (name == text_key) {
      text = value.text();
    } else if (field == table.end()) {
      std::vector<std::string> known{prefix + text_key};
      for (const auto& f : table) known.push_back(prefix + f.name);
      throw ConfigError("", unknown_name("key", key, known));
    } else {
      field->read(&p, value);
    }
  }
  return text;
}

/// Beside the settings file or as given. Loading executes code of the files.
inline void load_plugins(const std::vector<std::string>& plugins, const std::string& settings_file,
                         Registry& filters, ProviderRegistry& detectors) {
  for (const std::string& plugin : plugins) {
    std::error_code error;
    const std::filesystem::path beside = std::filesystem::path(settings_file).parent_path() / plugin;
    try {
      load_plugin(std::filesystem::exists(beside, error) ? beside : std::filesystem::path(plugin), filters,
                  detectors);
    } catch (const PluginError& problem) {
      throw ConfigError("DynFilter.plugins", problem.what());
    }
  }
}

inline void read_pipeline_of(const YamlDocument& document, const std::string& name, const std::string& file,
                             const Registry& registry, OrbSlamSettings& settings) {
  const YamlNode root = document.root();
  const std::string key = "DynFilter.pipeline";
  if (const auto node = root.find("pipeline")) {
    if (!name.empty()) root.fail("both `pipeline` and `" + key + "` are given: expected one of them");
    settings.pipeline = read_pipeline(*node, registry);
    settings.pipeline.yaml = document.text();
    settings.pipeline_file = file;
    return;
  }
  settings.pipeline_file = find_pipeline(name.empty() ? "dynfilter" : name, file, key);
  if (std::filesystem::path(name).replace_extension() == "oracle" && registry.find("oracle") == nullptr)
    throw ConfigError(key,
                      "`oracle` knows the labels of a synthetic sequence: only the command `dynfilter` "
                      "can run it");
  settings.pipeline = pipeline_from_file(settings.pipeline_file, registry);
}

/// A detector's YAML file beside the settings file, by its path, or an installed one.
inline std::filesystem::path find_detector(const std::string& name, const std::filesystem::path& folder) {
  constexpr PresetKind kDetectors{"detector", "detectors"};
  PresetFolders folders;
  folders.first.push_back(folder);
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

/// The runner of `boxes` and `masks`, or of `detector`; null without any of them.
inline std::unique_ptr<SemanticRunner> make_semantics(const OrbSlamParams& params,
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

}  // namespace orb_slam::detail

DYNFILTER_INLINE OrbSlamSettings read_orb_slam_settings(const std::string& file, const Registry& registry,
                                                        const ProviderRegistry& providers) {
  const YamlDocument document = YamlDocument::from_file(file);
  OrbSlamSettings settings;
  try {
    const YamlNode root = document.root();
    orb_slam::detail::refuse_near_misses(root, "DynFilter.");
    const std::string name = orb_slam::detail::read_prefixed(root, "DynFilter.", "pipeline", settings.params);
    Registry filters = registry;
    ProviderRegistry detectors = providers;
    orb_slam::detail::load_plugins(settings.params.plugins, file, filters, detectors);
    orb_slam::detail::read_pipeline_of(document, name, file, filters, settings);
    if (settings.params.enabled)
      settings.semantics = orb_slam::detail::make_semantics(settings.params, file, detectors);
    return settings;
  } catch (const ConfigError& error) {
    throw ConfigError(file, error.what());
  }
}

DYNFILTER_INLINE OnError read_on_error(const std::string& file) noexcept {
  try {
    const YamlDocument document = YamlDocument::from_file(file);
    const auto value = document.root().find("DynFilter.on_error");
    return value && value->text() == "off" ? OnError::Off : OnError::Stop;
  } catch (...) {
    return OnError::Stop;
  }
}

DYNFILTER_INLINE Input semantic_inputs(const OrbSlamParams& params) {
  const auto if_named = [](const std::string& name, Input input) {
    return name.empty() ? Input::None : input;
  };
  return if_named(params.boxes, Input::Detections) | if_named(params.masks, Input::Mask) |
         if_named(params.detector, Input::Detections | Input::Mask);
}

}  // namespace dynfilter
