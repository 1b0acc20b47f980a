// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cctype>
#include <dynfilter/core/near_miss.hpp>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/core/registry.hpp>
#include <dynfilter/core/yaml.hpp>
#include <dynfilter/filters/builtin.hpp>
#include <dynfilter/pipeline/yaml.hpp>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace dynfilter {

enum class HostSensor { Monocular, Stereo, RgbD };

/// System::eSensor of both versions as a number: 0 one camera, 1 two, 2 RGB-D; 3 to 5 the same with inertia.
inline HostSensor host_sensor(int sensor) {
  const int kind = sensor >= 0 ? sensor % 3 : 0;
  return kind == 0 ? HostSensor::Monocular : kind == 1 ? HostSensor::Stereo : HostSensor::RgbD;
}

/// How a verdict is handed to an ORB-SLAM host. In its settings file each has `DynFilter.` before it.
struct OrbSlamParams {
  bool enabled = true;
  bool keep_first_frame = true;
  int min_features_before_map = -1;
  int min_features = 100;
  int covisible_keyframes = 5;

  static const FieldTable<OrbSlamParams>& fields() {
    using P = OrbSlamParams;
    static const FieldTable<P> table{
        flag("enabled", &P::enabled, "false: the host runs as if nothing had been added"),
        flag("keep_first_frame", &P::keep_first_frame,
             "keep all features of the first frame, and of the first after a reset"),
        integer("min_features_before_map", &P::min_features_before_map, "features", {-1, 100000},
                "keep at least so many until the map exists; -1: 550 with depth or two cameras (the host "
                "begins with more than 500), 250 with one (it asks for 100 matches)"),
        integer("min_features", &P::min_features, "features", {0, 100000},
                "keep at least so many later (the host asks for 30 matches, 50 after a relocalisation)"),
        integer("covisible_keyframes", &P::covisible_keyframes, "keyframes", {0, 1000},
                "how many are looked at when a keyframe is made"),
    };
    return table;
  }

  int floor_before_map(HostSensor sensor) const {
    if (min_features_before_map >= 0) return min_features_before_map;
    return sensor == HostSensor::Monocular ? 250 : 550;
  }
};

struct OrbSlamSettings {
  OrbSlamParams params;
  PipelineConfig pipeline;
};

namespace orb_slam::detail {

/// Where installed pipelines lie, "" when the build did not say.
inline std::string pipelines_folder() {
#ifdef DYNFILTER_PIPELINES_DIR
  return DYNFILTER_PIPELINES_DIR;
#else
  return "";
#endif
}

/// The names of the installed pipelines that a host can run: not `oracle`, which knows the labels of a
/// synthetic sequence.
inline std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(pipelines_folder(), error)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() == ".yaml" && name != "oracle") names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// A file, beside the settings file or as given, or an installed pipeline, with `.yaml` or without.
inline std::string find_pipeline(const std::string& name, const std::string& settings_file,
                                 const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path installed = pipelines_folder();
  for (const fs::path& candidate : {fs::path(settings_file).parent_path() / name, fs::path(name),
                                    installed / (name + ".yaml"), installed / name})
    if (fs::is_regular_file(candidate, error)) return candidate.string();
  const std::vector<std::string> known = preset_names();
  throw ConfigError(path, "no pipeline `" + name + "`" + did_you_mean(fs::path(name).stem().string(), known) +
                              ": expected a file beside the settings file, a path" +
                              (known.empty() ? std::string(" (no presets are installed)")
                                             : ", or one of " + dynfilter::detail::joined(known)));
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
    throw ConfigError("", "unknown key `" + key + "`: " + hint);
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

/// The keys `prefix...` of a flat file over `p`. `text_key` after the prefix is not a parameter: its text is
/// returned.
template <class P>
std::string read_prefixed(const YamlNode& root, const std::string& prefix, const std::string& text_key,
                          P& p) {
  std::string text;
  for (const auto& [key, value] : root.entries(prefix)) {
    const std::string name = key.substr(prefix.size());
    const auto& table = P::fields();
    const auto field =
        std::find_if(table.begin(), table.end(), [&](const auto& f) { return f.info.name == name; });
    if (name == text_key) {
      text = value.text();
    } else if (field == table.end()) {
      std::vector<std::string> known{prefix + text_key};
      for (const auto& f : table) known.push_back(prefix + f.info.name);
      throw ConfigError("", "unknown key `" + key + "`" + did_you_mean(key, known) +
                                "; known keys: " + dynfilter::detail::joined(known));
    } else {
      field->read(p, value);
      field->check(p, value.path());
    }
  }
  return text;
}

}  // namespace orb_slam::detail

/// Reads a host's own settings file: the `DynFilter.` keys, and the pipeline from its `pipeline` node, or
/// from the file or the installed pipeline that `DynFilter.pipeline` names, else the default for the sensor.
/// Whatever else the file holds is the host's, keys that repeat included; only keys that nearly are ours are
/// errors. Throws ConfigError.
inline OrbSlamSettings read_orb_slam_settings(const std::string& file, HostSensor sensor,
                                              const Registry& registry = builtin_filters()) {
  const YamlDocument document = YamlDocument::from_file(file);
  OrbSlamSettings settings;
  try {
    const YamlNode root = document.root();
    orb_slam::detail::refuse_near_misses(root, "DynFilter.");
    std::string name = orb_slam::detail::read_prefixed(root, "DynFilter.", "pipeline", settings.params);
    if (root.find("pipeline")) {
      if (!name.empty())
        root.fail("both `pipeline` and `DynFilter.pipeline` are given: expected one of them");
      settings.pipeline = read_pipeline(*root.find("pipeline"), registry);
      return settings;
    }
    if (name == "oracle" && registry.find(name) == nullptr)
      throw ConfigError("DynFilter.pipeline",
                        "`oracle` knows the labels of a synthetic sequence: only the "
                        "command `dynfilter` can run it");
    if (name.empty()) name = sensor == HostSensor::RgbD ? "dynfilter" : "dynfilter_mono";
    settings.pipeline =
        pipeline_from_file(orb_slam::detail::find_pipeline(name, file, "DynFilter.pipeline"), registry);
    return settings;
  } catch (const ConfigError& error) {
    throw ConfigError(file, error.what());
  }
}

}  // namespace dynfilter
