// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>

namespace dynfilter::odometry {

/// Decides which features are on moving objects, at the three call points of SLAM front ends.
/// A result has one flag per feature of the view (1: reject) or is empty (reject none).
/// It is valid until the next call.
/// Features rejected at one call point are absent from later views.
class FeatureJudge {
 public:
  using Flags = Span<const std::uint8_t>;
  virtual ~FeatureJudge() = default;

  virtual Flags before_pose(
      const FrameView& view) = 0;  ///< after extraction; the pose is a prediction or none
  virtual Flags after_pose(const FrameView& view) = 0;   ///< with a first pose and map points
  virtual Flags at_keyframe(const FrameView& view) = 0;  ///< before new map points are created
  /// How far each feature of the last view may have slid along its edge. Empty: not known.
  virtual Span<const MatchSpread> spread() const { return {}; }
  /// Called without a map, after before_pose. True if this frame must not be the first keyframe.
  virtual bool wait_for_keyframe() const { return false; }
  virtual void pose_refined(std::int64_t /*frame_id*/, const Pose& /*T_world_camera*/) {
  }                          ///< end of the frame
  virtual void lost() {}     ///< on loss of tracking, relocalisation or a new map: poses so far are void
  virtual void reset() = 0;  ///< at a time jump
};

}  // namespace dynfilter::odometry
