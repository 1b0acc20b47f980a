// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/core/registry.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// A combinator, for `dynfilter filters`.
struct CombinatorCard {
  std::string name, form, summary;
};

inline std::vector<CombinatorCard> combinator_cards() {
  return {
      {"sequence", "[stage, ...]",
       "in turn: each judges what the earlier ones kept, models fitted without suspects"},
      {"any", "[stage, ...]", "dynamic if one member says so"},
      {"all", "[stage, ...]", "dynamic if every member says so"},
      {"not", "stage", "static and dynamic change places"},
      {"strict", "stage", "guilty until proven static: what the stage cannot clear is dynamic"},
      {"gate", "{ if: stage, then: stage, else: stage }",
       "`if` decides who judges a feature; `else` may be left out"},
      {"by_region", "{ inside: stage, outside: stage }",
       "prior suspects are judged by `inside`, the others by `outside`"},
  };
}

namespace detail {

/// Builds the tree of stages that a YAML node describes; every error names its path.
class StageReader {
 public:
  explicit StageReader(const Registry& registry) : registry_(registry) {}

  /// `name`, `name: parameters`, or a list (a sequence).
  std::unique_ptr<Stage> stage(const YamlNode& node) const {
    if (node.is_sequence()) return std::make_unique<SequenceStage>(node.path(), stages(node));
    if (node.is_text()) return filter(node.text(), YamlNode(cv::FileNode(), node.path()));
    const auto entries = node.entries();
    if (entries.size() != 1) node.fail("expected one stage, `name` or `name: { parameters }`");
    const auto& [name, value] = entries[0];
    if (name == "sequence") return std::make_unique<SequenceStage>(value.path(), stages(value));
    if (name == "any") return std::make_unique<AnyStage>(value.path(), stages(value));
    if (name == "all") return std::make_unique<AllStage>(value.path(), stages(value));
    if (name == "not") return std::make_unique<NotStage>(value.path(), named(value, {}, {}));
    if (name == "strict") return std::make_unique<StrictStage>(value.path(), named(value, {}, {}));
    if (name == "gate")
      return std::make_unique<GateStage>(value.path(), named(value, {"if", "then"}, {"else"}));
    if (name == "by_region")
      return std::make_unique<ByRegionStage>(value.path(), named(value, {"inside", "outside"}, {}));
    return filter(name, value);
  }

 private:
  Stages stages(const YamlNode& node) const {
    Stages result;
    for (const YamlNode& item : node.items()) result.push_back(stage(item));
    if (result.empty()) node.fail("expected at least one stage");
    return result;
  }
  /// Children under fixed keys; without keys the node itself is the one child.
  Stages named(const YamlNode& node, const std::vector<std::string>& keys,
               const std::vector<std::string>& optional) const {
    Stages result;
    if (keys.empty()) {
      result.push_back(stage(node));
      return result;
    }
    std::vector<std::string> known = keys;
    known.insert(known.end(), optional.begin(), optional.end());
    const auto entries = node.entries();
    for (const auto& [key, value] : entries)
      if (std::find(known.begin(), known.end(), key) == known.end())
        node.fail("unknown key `" + key + "`; known keys: " + joined(known));
    for (const std::string& key : known) {
      const auto it =
          std::find_if(entries.begin(), entries.end(), [&](const auto& e) { return e.first == key; });
      if (it != entries.end())
        result.push_back(stage(it->second));
      else if (std::find(keys.begin(), keys.end(), key) != keys.end())
        node.fail("expected the key `" + key + "`");
    }
    return result;
  }
  std::unique_ptr<Stage> filter(const std::string& name, const YamlNode& parameters) const {
    const Registry::Entry* entry = registry_.find(name);
    if (entry == nullptr) {
      std::vector<std::string> known = registry_.names();
      for (const CombinatorCard& card : combinator_cards()) known.push_back(card.name);
      parameters.fail("unknown filter `" + name + "`; known: " + joined(known));
    }
    return std::make_unique<FilterStage>(entry->make(parameters), parameters.path());
  }

  const Registry& registry_;
};

inline std::unique_ptr<Stage> read_call_point(const YamlNode& node, const Registry& registry) {
  // A call point without stages is written as an empty list.
  if (node.is_none() || (node.is_sequence() && node.items().empty())) return nullptr;
  return StageReader(registry).stage(node);
}

}  // namespace detail

/// Reads the map under `pipeline:`. Throws ConfigError naming the path and what was expected.
inline PipelineConfig read_pipeline(const YamlNode& node, const Registry& registry) {
  PipelineConfig config;
  for (const auto& [key, value] : node.entries()) {
    if (key == "name")
      config.name = value.text();
    else if (key == "about")
      value.text();
    else if (key == "max_time_gap_s") {
      config.params.max_time_gap_s = value.real();
      check_parameters(config.params, node.path());
    } else if (key == "correspondence")
      config.context = read_parameters<ContextParams>(value);
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
      node.fail("unknown key `" + key +
                "`; known keys: name, about, max_time_gap_s, correspondence, floor, initialisation, "
                "before_pose, after_pose, "
                "at_keyframe");
  }
  return config;
}

/// Reads a pipeline from a document that holds a `pipeline:` map among other things (an ORB-SLAM settings
/// file, say).
inline PipelineConfig read_pipeline(const YamlDocument& document, const Registry& registry) {
  const auto node = document.root().find("pipeline");
  if (!node) throw ConfigError(document.source(), "expected the key `pipeline`");
  try {
    return read_pipeline(*node, registry);
  } catch (const ConfigError& error) {
    if (document.source().empty()) throw;
    throw ConfigError(document.source(), error.what());
  }
}

inline PipelineConfig pipeline_from_file(const std::string& path, const Registry& registry) {
  return read_pipeline(YamlDocument::from_file(path), registry);
}
inline PipelineConfig pipeline_from_text(const std::string& text, const Registry& registry) {
  return read_pipeline(YamlDocument::from_text(text), registry);
}

}  // namespace dynfilter
