// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/testing/exact_scene.hpp>
#include <string>
#include <vector>

namespace dynfilter::testing {

/// Scenes that are known to be difficult.
/// Each has 360 points, 60 of them on a mover with 4 cm per frame, unless stated otherwise.
enum class Preset {
  General,        ///< the simple case
  Rigid,          ///< only the camera moves: nothing may be rejected
  Planar,         ///< a wall
  PureRotation,   ///< no baseline
  NoMotion,       ///< static camera
  SmallBaseline,  ///< 3 mm per frame
  /// The mover has the camera's direction at higher speed: invisible to epipolar geometry.
  AlongEpipolar,
  Majority,        ///< two movers have 70 % of the points
  SeveralMovers,   ///< four with different motion, one of them rotates
  DelayedMajority  ///< Majority, static for the first 15 frames
};

const std::vector<Preset>& all_presets();

std::string to_string(Preset preset);

namespace detail {

ExactScene majority(int still_until);

}  // namespace detail

/// The scene of a preset. It can be modified: `preset(Preset::Planar).pixel_noise(0.5)`.
ExactScene preset(Preset preset);

}  // namespace dynfilter::testing

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/testing/detail/exact_scene_presets-inl.hpp>
#endif
