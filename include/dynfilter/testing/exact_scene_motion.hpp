// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <dynfilter/core/pose.hpp>
#include <functional>
#include <string>
#include <utility>

namespace dynfilter::testing {

/// Pose in the world [m] at a frame.
using Motion = std::function<Pose(int frame)>;

/// Camera motion per frame.
enum class CameraStep {
  None,
  General,        ///< 3 cm and 0.5 degrees per frame
  Sideways,       ///< 3 cm per frame, no rotation
  Forward,        ///< 4 cm per frame, no rotation
  PureRotation,   ///< 0.7 degrees per frame
  SmallBaseline,  ///< 3 mm and 0.2 degrees per frame
};

/// A rigid box of points: `MovingBox(60).at({0.3, 0, 2.5}).moving({0.05, 0, 0}).still_until(10)`.
class MovingBox {
 public:
  explicit MovingBox(int points = 60) : points_(std::max(0, points)) {}  ///< points at random places in it

  /// Centre at frame 0, in the world [m]. The origin is the camera of frame 0 unless that is moved.
  MovingBox& at(const Eigen::Vector3d& centre_m) { return centre_m_ = centre_m, *this; }
  /// Half of the box's width, height and depth along its own axes [m].
  MovingBox& half_size(const Eigen::Vector3d& half_size_m) { return half_size_m_ = half_size_m, *this; }
  /// Motion in metres per frame, in the world.
  MovingBox& moving(const Eigen::Vector3d& step_m) { return step_m_ = step_m, *this; }
  /// Rotation in radians per frame, about an axis through its centre.
  MovingBox& turning(const Eigen::Vector3d& turn_rad) { return turn_rad_ = turn_rad, *this; }
  /// Last frame before the motion begins.
  MovingBox& still_until(int frame) { return still_until_ = frame, *this; }
  /// Any motion. Replaces all settings above except the size.
  MovingBox& following(Motion motion) { return motion_ = std::move(motion), *this; }
  /// Class name for the detector.
  MovingBox& named(std::string class_name) { return class_name_ = std::move(class_name), *this; }

  int points() const { return points_; }                               ///< number of them
  const Eigen::Vector3d& half_size_m() const { return half_size_m_; }  ///< along its own axes [m]
  const std::string& class_name() const { return class_name_; }        ///< for detections

  /// Pose of its frame of reference in the world, with the centre as origin.
  Eigen::Isometry3d T_world_object(int frame) const;

 private:
  int points_;
  Eigen::Vector3d centre_m_{0.3, 0, 2.5}, half_size_m_{0.25, 0.5, 0.15}, step_m_{0, 0, 0}, turn_rad_{0, 0, 0};
  int still_until_ = 0;
  Motion motion_;
  std::string class_name_ = "person";
};

/// Starts at the origin of the world (x right, y down, z forward) and makes the same step every frame.
/// Steps are in metres, and in radians about an axis through the object.
inline Motion steady_motion(const Eigen::Vector3d& step_m, const Eigen::Vector3d& turn_rad = {0, 0, 0}) {
  return [=](int frame) {
    const double angle = turn_rad.norm() * frame;
    const Eigen::Vector3d axis =
        angle != 0 ? Eigen::Vector3d(turn_rad.normalized()) : Eigen::Vector3d::UnitZ();
    return Pose::from(rotation_about(axis, angle), step_m * frame);
  };
}

/// Of a camera that moves like this.
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

inline Eigen::Isometry3d MovingBox::T_world_object(int frame) const {
  if (motion_) return motion_(frame).isometry();
  Eigen::Isometry3d T = steady_motion(step_m_, turn_rad_)(std::max(0, frame - still_until_)).isometry();
  T.translation() += centre_m_;
  return T;
}

}  // namespace dynfilter::testing
