// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dynfilter/core/pose.hpp>
#include <functional>
#include <string>
#include <utility>

namespace dynfilter::synth {

/// Where something is at frame k, in the world [m].
using Motion = std::function<Pose(int frame)>;

/// Starts at the origin (x right, y down, z ahead) and makes the same step every frame: metres, and radians
/// about an axis through itself.
inline Motion steady_motion(const Eigen::Vector3d& step_m, const Eigen::Vector3d& turn_rad = {0, 0, 0}) {
  return [=](int frame) {
    const double angle = turn_rad.norm() * frame;
    const Eigen::Vector3d axis =
        angle != 0 ? Eigen::Vector3d(turn_rad.normalized()) : Eigen::Vector3d::UnitZ();
    return Pose::from(Eigen::AngleAxisd(angle, axis).toRotationMatrix(), step_m * frame);
  };
}

/// What a camera does every frame.
enum class CameraStep {
  None,
  General,        ///< 3 cm and half a degree a frame
  Sideways,       ///< 3 cm a frame, no rotation
  Forward,        ///< 4 cm a frame, no rotation
  PureRotation,   ///< 0.7 degrees a frame
  SmallBaseline,  ///< 3 mm and 0.2 degrees a frame
};

inline Motion steady_motion(CameraStep step) {
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

/// A box of points that moves as a whole:
/// `MovingBox(60).at({0.3, 0, 2.5}).moving({0.05, 0, 0}).still_until(10)`.
class MovingBox {
 public:
  explicit MovingBox(int points = 60) : points_(std::max(0, points)) {}

  /// Centre at frame 0, in the world [m] (the camera of frame 0 is its origin, unless it is moved).
  MovingBox& at(const Eigen::Vector3d& centre_m) { return centre_m_ = centre_m, *this; }
  /// Half the box's width, height and depth [m].
  MovingBox& half_size(const Eigen::Vector3d& half_size_m) { return half_size_m_ = half_size_m, *this; }
  /// Metres a frame, in the world.
  MovingBox& moving(const Eigen::Vector3d& step_m) { return step_m_ = step_m, *this; }
  /// Radians a frame, about an axis through its centre.
  MovingBox& turning(const Eigen::Vector3d& turn_rad) { return turn_rad_ = turn_rad, *this; }
  /// The last frame at which it has not moved yet.
  MovingBox& still_until(int frame) { return still_until_ = frame, *this; }
  /// Any motion: replaces all of the above but the size.
  MovingBox& following(Motion motion) { return motion_ = std::move(motion), *this; }
  /// What a detector calls it.
  MovingBox& named(std::string class_name) { return class_name_ = std::move(class_name), *this; }

  int points() const { return points_; }
  const Eigen::Vector3d& half_size_m() const { return half_size_m_; }
  const std::string& class_name() const { return class_name_; }

  /// Its own frame of reference, with the centre as origin, in the world.
  Eigen::Isometry3d T_world_object(int frame) const {
    if (motion_) return motion_(frame).isometry();
    Eigen::Isometry3d T = steady_motion(step_m_, turn_rad_)(std::max(0, frame - still_until_)).isometry();
    T.translation() += centre_m_;
    return T;
  }

 private:
  int points_;
  Eigen::Vector3d centre_m_{0.3, 0, 2.5}, half_size_m_{0.25, 0.5, 0.15}, step_m_{0, 0, 0}, turn_rad_{0, 0, 0};
  int still_until_ = 0;
  Motion motion_;
  std::string class_name_ = "person";
};

}  // namespace dynfilter::synth
