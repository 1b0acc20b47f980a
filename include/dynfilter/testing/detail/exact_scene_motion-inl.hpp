// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/testing/exact_scene_motion.hpp>

#include <dynfilter/core/inline.hpp>

namespace dynfilter::testing {

DYNFILTER_INLINE Motion steady_motion(const Eigen::Vector3d& step_m, const Eigen::Vector3d& turn_rad) {
  return [=](int frame) {
    const double angle = turn_rad.norm() * frame;
    const Eigen::Vector3d axis =
        angle != 0 ? Eigen::Vector3d(turn_rad.normalized()) : Eigen::Vector3d::UnitZ();
    return Pose::from(rotation_about(axis, angle), step_m * frame);
  };
}

DYNFILTER_INLINE Motion steady_motion(CameraStep step) {
  switch (step) {
    case CameraStep::General:
      return steady_motion({0.026, -0.008, 0.014}, {0.003, -0.008, 0.002});
    case CameraStep::Sideways:
      return steady_motion({0.03, 0, 0});
    case CameraStep::Forward:
      return steady_motion({0, 0, 0.04});
    case CameraStep::PureRotation:
      return steady_motion({0, 0, 0}, {0.004, 0.011, 0.003});
    case CameraStep::SmallBaseline:
      return steady_motion({0.0025, 0.001, 0.0013}, {0.001, 0.003, 0});
    case CameraStep::None:
      break;
  }
  return steady_motion({0, 0, 0});
}

DYNFILTER_INLINE Eigen::Isometry3d MovingBox::T_world_object(int frame) const {
  if (motion_) return motion_(frame).isometry();
  Eigen::Isometry3d T = steady_motion(step_m_, turn_rad_)(std::max(0, frame - still_until_)).isometry();
  T.translation() += centre_m_;
  return T;
}

}  // namespace dynfilter::testing
