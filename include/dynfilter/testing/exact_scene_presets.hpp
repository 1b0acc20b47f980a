// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
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

/// In the order of the enumeration.
inline const std::vector<Preset>& all_presets() {
  static const std::vector<Preset> presets{Preset::General,        Preset::Rigid,    Preset::Planar,
                                           Preset::PureRotation,   Preset::NoMotion, Preset::SmallBaseline,
                                           Preset::AlongEpipolar,  Preset::Majority, Preset::SeveralMovers,
                                           Preset::DelayedMajority};
  return presets;
}

/// Its name: `along_epipolar`.
inline std::string to_string(Preset preset) {
  static const char* const names[] = {"general",        "rigid",           "planar",         "pure_rotation",
                                      "no_motion",      "small_baseline",  "along_epipolar", "majority",
                                      "several_movers", "delayed_majority"};
  return names[static_cast<int>(preset)];
}

namespace detail {

inline ExactScene majority(int still_until) {
  const auto mover = [=](double x_m, const Eigen::Vector3d& step_m) {
    return MovingBox(210)
        .at({x_m, 0, 2.6})
        .half_size({0.45, 0.7, 0.2})
        .moving(step_m)
        .still_until(still_until);
  };
  return ExactScene()
      .points(180)
      .mover(mover(-0.6, {0.035, 0, 0.015}))
      .mover(mover(0.7, {0.03, 0.01, -0.02}));
}

inline ExactScene several_movers() {
  return ExactScene()
      .mover(MovingBox(40).at({-0.9, 0.1, 2.6}).moving({0.04, 0, 0}))
      .mover(MovingBox(40).at({0.9, -0.1, 3.0}).moving({-0.03, 0, -0.03}))
      .mover(MovingBox(40).at({0, -0.6, 2.4}).half_size({0.2, 0.2, 0.2}).moving({0, 0.035, 0}))
      .mover(
          MovingBox(40).at({0.1, 0.5, 2.2}).half_size({0.25, 0.2, 0.2}).turning({0, 0, 0.12}).named("chair"));
}

}  // namespace detail

/// The scene of a preset. It can be modified: `preset(Preset::Planar).pixel_noise(0.5)`.
inline ExactScene preset(Preset preset) {
  const MovingBox mover = MovingBox(60).at({-0.3, -0.35, 2.5}).moving({0.02, 0.033, 0.01});
  switch (preset) {
    case Preset::General:
      return ExactScene().mover(mover);
    case Preset::Rigid:
      return ExactScene().points(360);
    case Preset::Planar:
      return ExactScene().planar().mover(mover);
    case Preset::PureRotation:
      return ExactScene().camera_motion(CameraStep::PureRotation).mover(mover);
    case Preset::NoMotion:
      return ExactScene().camera_motion(CameraStep::None).mover(mover);
    case Preset::SmallBaseline:
      return ExactScene().camera_motion(CameraStep::SmallBaseline).mover(mover);
    case Preset::AlongEpipolar:
      return ExactScene()
          .camera_motion(CameraStep::Sideways)
          .mover(MovingBox(60).at({-0.3, 0.1, 2.5}).moving({0.07, 0, 0}));
    case Preset::Majority:
      return detail::majority(0);
    case Preset::SeveralMovers:
      return detail::several_movers();
    case Preset::DelayedMajority:
      return detail::majority(15);
  }
  return ExactScene();
}

}  // namespace dynfilter::testing
