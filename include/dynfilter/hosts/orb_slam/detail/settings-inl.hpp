// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/orb_slam/settings.hpp>

#include <algorithm>
#include <cctype>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <dynfilter/plugin/loader.hpp>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

namespace dynfilter {

DYNFILTER_INLINE PipelineConfig configured_pipeline(OrbSlamSettings& settings) {
  PipelineConfig config = std::move(settings.pipeline);
  if (!settings.params.keep_first_frame) config.params.first_frame_suspects = FirstFrameSuspects::Reject;
  return config;
}

namespace orb_slam {

namespace detail {

DYNFILTER_INLINE std::string find_pipeline(const std::string& name, const std::string& settings_file,
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

/// The keys `prefix...` of a flat file over `p`. `text_key` after the prefix is not a parameter: its text is
/// returned.
template <class P>
std::string read_prefixed(const YamlNode& root, const std::string& prefix, const std::string& text_key,
                          P& p) {
  std::string text;
  for (const auto& [key, value] : root.entries(prefix)) {
    const std::string name = key.substr(prefix.size());
    const dynfilter::detail::AnyFields& table = P::fields().all();
    const auto field =
        std::find_if(table.begin(), table.end(), [&](const auto& f) { return f.info.name == name; });
    if (name == text_key) {
      text = value.text();
    } else if (field == table.end()) {
      std::vector<std::string> known{prefix + text_key};
      for (const auto& f : table) known.push_back(prefix + f.info.name);
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

/// `root` must be valid as long as the pipeline is read.
inline void read_pipeline_of(const YamlNode& root, const std::string& name, const std::string& file,
                             const Registry& registry, OrbSlamSettings& settings) {
  const std::string key = "DynFilter.pipeline";
  if (const auto node = root.find("pipeline")) {
    if (!name.empty()) root.fail("both `pipeline` and `" + key + "` are given: expected one of them");
    settings.pipeline = read_pipeline(*node, registry);
    settings.pipeline_file = file;
    return;
  }
  settings.pipeline_file = find_pipeline(name.empty() ? "dynfilter" : name, file, key);
  if (std::filesystem::path(settings.pipeline_file).stem() == "oracle" && registry.find("oracle") == nullptr)
    throw ConfigError(key,
                      "`oracle` knows the labels of a synthetic sequence: only the command `dynfilter` "
                      "can run it");
  settings.pipeline = pipeline_from_file(settings.pipeline_file, registry);
}

}  // namespace detail

}  // namespace orb_slam

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
    orb_slam::detail::read_pipeline_of(root, name, file, filters, settings);
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

}  // namespace dynfilter
