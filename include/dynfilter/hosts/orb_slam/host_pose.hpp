// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/hosts/orb_slam/traits.hpp>
#include <dynfilter/core/pose.hpp>
#include <opencv2/core.hpp>
#include <optional>

namespace dynfilter::orb_slam {

/// A host's transform as a Pose: a 4x4 cv::Mat of float or double (version 2), or anything with a 4x4
/// `matrix()` (version 3). Empty, of another size, or not rigid: none.
template <class Transform>
std::optional<Pose> to_pose(const Transform& T_a_b) {
  Eigen::Matrix4d m;
  if constexpr (traits::IsMatrix<Transform>::value) {
    const cv::Mat matrix(T_a_b);
    if (matrix.rows != 4 || matrix.cols != 4 || matrix.channels() != 1) return std::nullopt;
    cv::Mat_<double> as_double;
    matrix.convertTo(as_double, CV_64F);
    for (int row = 0; row < 4; ++row)
      for (int col = 0; col < 4; ++col) m(row, col) = as_double(row, col);
  } else {
    m = T_a_b.matrix().template cast<double>();
  }
  const Pose pose = Pose::from(m.topLeftCorner<3, 3>(), m.topRightCorner<3, 1>());
  if (!is_rigid(pose)) return std::nullopt;
  return pose;
}

/// T_camera_world of a host's frame or keyframe, if it has one.
template <class Frame>
std::optional<Pose> camera_from_world(const Frame& frame) {
  if constexpr (traits::HasMatrixPose<Frame>::value) {
    return to_pose(frame.mTcw);
  } else {
    if (!frame.HasPose()) return std::nullopt;
    return to_pose(frame.GetPose());
  }
}

/// What the host knows of the camera before it tracks a frame.
struct HostPose {
  bool has_prediction = false, has_last = false;
  Pose predicted_T_world_camera;
  std::int64_t last_frame_id = -1;
  Pose last_T_world_camera;  ///< of that frame, as estimated by now
};

/// The prediction of the host's constant-velocity model. `velocity` is the host's mVelocity (T_current_last),
/// `last` its mLastFrame; version 3 says with its mbVelocity whether there is one. Either may be missing.
template <class Velocity, class Frame>
HostPose predicted_pose(const Velocity& velocity, const Frame& last, bool has_velocity = true) {
  HostPose pose;
  const std::optional<Pose> T_last_world = camera_from_world(last);
  if (!T_last_world) return pose;
  pose.has_last = true;
  pose.last_frame_id = static_cast<std::int64_t>(last.mnId);
  pose.last_T_world_camera = inverse(*T_last_world);
  if (!has_velocity) return pose;
  if (const std::optional<Pose> T_current_last = to_pose(velocity)) {
    pose.has_prediction = true;
    pose.predicted_T_world_camera = inverse(*T_current_last * *T_last_world);
  }
  return pose;
}

}  // namespace dynfilter::orb_slam
