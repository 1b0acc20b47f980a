// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>

namespace dynfilter::odometry {

/// Who says which features lie on something that moves, at the three points where SLAM front ends can ask.
/// Every answer has a flag per feature of the view (1: reject) or is empty (reject none), and stays valid
/// until the next call. Features rejected at one point are absent from the views that follow.
class FeatureJudge {
 public:
  using Flags = Span<const std::uint8_t>;
  virtual ~FeatureJudge() = default;

  virtual Flags before_pose(
      const FrameView& view) = 0;  ///< after extraction; the pose is a prediction or none
  virtual Flags after_pose(const FrameView& view) = 0;   ///< a first pose and map points are there
  virtual Flags at_keyframe(const FrameView& view) = 0;  ///< before new map points are made
  /// Asked while there is no map, after before_pose: is this frame no good as the first keyframe?
  virtual bool wait_for_keyframe() const { return false; }
  virtual void pose_refined(std::int64_t /*frame_id*/, const Pose& /*T_world_camera*/) {
  }                          ///< the frame is done
  virtual void reset() = 0;  ///< after a loss, a relocalisation, a time jump
};

}  // namespace dynfilter::odometry
