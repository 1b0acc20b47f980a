// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <optional>

namespace dynfilter::odometry {

/// NoMap: too few features with depth to start, or the judge delays the first keyframe.
/// Judged: poses are not estimated, by the options.
enum class TrackState { NoMap, Tracked, Lost, Judged };

constexpr const char* to_string(TrackState state) {
  switch (state) {
    case TrackState::Tracked:
      return "tracked";
    case TrackState::Lost:
      return "lost";
    case TrackState::Judged:
      return "judged";
    default:
      return "no_map";
  }
}

/// Time of one frame by step [ms].
struct StageTimes {
  double extraction = 0;  ///< features, undistortion, depth
  double judge = 0;       ///< all calls of the toolkit
  double tracking = 0;    ///< matching, pose
  double mapping = 0;     ///< keyframe and bundle adjustment

  double total() const { return extraction + judge + tracking + mapping; }
};

/// Result of one frame.
struct TrackResult {
  std::int64_t frame_id = 0;
  double timestamp_s = 0;
  TrackState state = TrackState::NoMap;
  /// Current estimate; the world is the first camera. Unset unless tracked.
  std::optional<Pose> T_world_camera;
  int features = 0;        ///< extracted
  int rejected = 0;        ///< by the toolkit, over all call points
  int tracked_points = 0;  ///< map points that agree with the pose
  bool keyframe = false;
  bool relocalised = false;
  bool time_jump = false;
  StageTimes ms;      ///< elapsed
  StageTimes cpu_ms;  ///< of all threads of the process
};

/// Semantic inputs of a frame for the toolkit. Non-owning.
struct SemanticInputs {
  std::optional<DetectionInput> detections;  ///< unset: no result
  std::optional<MaskInput> mask;
  std::optional<MotionPrior> motion_prior;  ///< since the last frame
};

/// Call point at which a feature was rejected.
enum class RejectedAt : std::uint8_t { Nowhere, BeforePose, AfterPose, AtKeyframe };

}  // namespace dynfilter::odometry
