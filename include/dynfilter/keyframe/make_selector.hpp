// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/keyframe/pose_change.hpp>
#include <dynfilter/keyframe/selector.hpp>
#include <dynfilter/keyframe/vertex_cover_selector.hpp>
#include <memory>
#include <string>

namespace dynfilter {

/// Creates a selector by name with its default parameters.
/// Throws ConfigError with the known names.
std::unique_ptr<KeyframeSelector> make_keyframe_selector(const std::string& name);

/// The same with the parameters of a YAML map, or the defaults without one. Throws as above.
std::unique_ptr<KeyframeSelector> make_keyframe_selector(const std::string& name, const YamlNode& node);

inline std::unique_ptr<KeyframeSelector> make_keyframe_selector(const std::string& name) {
  if (name == PoseChangeSelector::kName) return std::make_unique<PoseChangeSelector>();
  if (name == VertexCoverSelector::kName) return std::make_unique<VertexCoverSelector>();
  throw ConfigError(
      "", unknown_name("keyframe selector", name, {PoseChangeSelector::kName, VertexCoverSelector::kName}));
}

inline std::unique_ptr<KeyframeSelector> make_keyframe_selector(const std::string& name,
                                                                const YamlNode& node) {
  if (node.is_none()) return make_keyframe_selector(name);
  if (name == PoseChangeSelector::kName)
    return std::make_unique<PoseChangeSelector>(read_parameters<PoseChangeParams>(node));
  if (name == VertexCoverSelector::kName)
    return std::make_unique<VertexCoverSelector>(read_parameters<VertexCoverParams>(node));
  return make_keyframe_selector(name);
}

}  // namespace dynfilter
