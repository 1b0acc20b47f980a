// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/keyframe/pose_change.hpp>
#include <dynfilter/keyframe/selector.hpp>
#include <dynfilter/keyframe/vertex_cover_selector.hpp>
#include <memory>
#include <string>

namespace dynfilter {

/// Creates a selector by name with its default parameters.
/// Throws ConfigError with the known names.
std::unique_ptr<KeyframeSelector> make_keyframe_selector(const std::string& name);

/// The same with the parameters of a YAML map, or the defaults without one.
std::unique_ptr<KeyframeSelector> make_keyframe_selector(const std::string& name, const YamlNode& node);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/keyframe/detail/make_selector-inl.hpp>
#endif
