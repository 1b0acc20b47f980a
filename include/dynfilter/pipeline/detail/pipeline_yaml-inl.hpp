// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/pipeline_yaml.hpp>

#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/pipeline/combinator_table.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>
#include <dynfilter/pipeline/stage_reader.hpp>
#include <vector>

namespace dynfilter {

namespace detail {

DYNFILTER_INLINE StagePtr read_call_point(const YamlNode& node, const Registry& registry) {
  // An empty list means a call point without stages.
  if (node.is_none() || (node.is_sequence() && node.items().empty())) return nullptr;
  return StageReader(registry, combinator_table()).stage(node);
}

DYNFILTER_INLINE const AnyField* pipeline_field(const std::string& key) {
  for (const AnyField& field : PipelineParams::fields().all())
    if (key == field.name) return &field;
  return nullptr;
}

DYNFILTER_INLINE std::vector<std::string> pipeline_keys() {
  std::vector<std::string> keys{"name", "about"};
  for (const AnyField& field : PipelineParams::fields().all()) keys.emplace_back(field.name);
  for (const char* key :
       {"correspondence", "floor", "initialisation", "before_pose", "after_pose", "at_keyframe"})
    keys.emplace_back(key);
  return keys;
}

}  // namespace detail

DYNFILTER_INLINE PipelineConfig read_pipeline(const YamlNode& node, const Registry& registry) {
  PipelineConfig config;
  for (const auto& [key, value] : node.entries()) {
    if (key == "name")
      config.name = value.text();
    else if (key == "about")
      value.text();
    else if (const detail::AnyField* field = detail::pipeline_field(key)) {
      field->read(&config.params, value);
    } else if (key == "correspondence")
      config.correspondence = read_parameters<CorrespondenceParams>(value);
    else if (key == "floor")
      config.floor = read_parameters<FloorParams>(value);
    else if (key == "initialisation")
      config.initialisation = read_parameters<InitialisationParams>(value);
    else if (key == "before_pose")
      config.before_pose = detail::read_call_point(value, registry);
    else if (key == "after_pose")
      config.after_pose = detail::read_call_point(value, registry);
    else if (key == "at_keyframe")
      config.at_keyframe = detail::read_call_point(value, registry);
    else
      node.fail(unknown_name("key", key, detail::pipeline_keys()));
  }
  return config;
}

DYNFILTER_INLINE PipelineConfig read_pipeline(const YamlDocument& document, const Registry& registry) {
  const auto node = document.root().find("pipeline");
  if (!node) throw ConfigError(document.source(), "expected the key `pipeline`");
  try {
    PipelineConfig config = read_pipeline(*node, registry);
    config.yaml = document.text();
    return config;
  } catch (const ConfigError& error) {
    if (document.source().empty()) throw;
    throw ConfigError(document.source(), error.what());
  }
}

DYNFILTER_INLINE PipelineConfig pipeline_from_file(const std::string& path, const Registry& registry) {
  return read_pipeline(YamlDocument::from_file(path), registry);
}
DYNFILTER_INLINE PipelineConfig pipeline_from_text(const std::string& text, const Registry& registry) {
  return read_pipeline(YamlDocument::from_text(text), registry);
}

}  // namespace dynfilter
