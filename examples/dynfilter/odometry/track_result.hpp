// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <optional>

namespace dynfilter::odometry {

/// NoMap: too few features with depth so far to start from, or the judge asks to wait.
enum class TrackState { NoMap, Tracked, Lost };

constexpr const char* to_string(TrackState state) {
  return state == TrackState::Tracked ? "tracked" : state == TrackState::Lost ? "lost" : "no_map";
}

/// Where the time of one frame went [ms].
struct StageTimes {
  double extraction = 0;  ///< features, undistortion, depth
  double judge = 0;       ///< all calls of the toolkit
  double tracking = 0;    ///< matching, pose
  double mapping = 0;     ///< keyframe and bundle adjustment

  double total() const { return extraction + judge + tracking + mapping; }
};

/// What happened to one frame.
struct TrackResult {
  std::int64_t frame_id = 0;
  double timestamp_s = 0;
  TrackState state = TrackState::NoMap;
  std::optional<Pose> T_world_camera;  ///< as known now; world: the first camera. Unset unless tracked
  int features = 0;                    ///< extracted
  int rejected = 0;                    ///< by the toolkit, at all call points together
  int tracked_points = 0;              ///< map points that agree with the pose
  bool keyframe = false;
  bool relocalised = false;
  bool time_jump = false;
  StageTimes ms;
};

/// What comes along with a frame for the toolkit. Non-owning.
struct SemanticInputs {
  std::optional<DetectionInput> detections;  ///< unset: none came
  std::optional<MaskInput> mask;
};

/// At which point a feature was rejected.
enum class RejectedAt : std::uint8_t { Nowhere, BeforePose, AfterPose, AtKeyframe };

}  // namespace dynfilter::odometry
