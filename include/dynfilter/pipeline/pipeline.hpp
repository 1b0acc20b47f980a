// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>
#include <memory>

namespace dynfilter {

class FrameObserver;  // pipeline/frame_observer.hpp
class Stage;

/// Deletes a stage where its type is not known.
struct StageDeleter {
  StageDeleter() = default;
  template <class S>
  StageDeleter(const std::default_delete<S>&) noexcept {}  // NOLINT: from any unique_ptr of a stage
  void operator()(Stage* stage) const noexcept;
};
using StagePtr = std::unique_ptr<Stage, StageDeleter>;

/// All parts of a pipeline. pipeline/compose.hpp creates them in C++, pipeline/pipeline_yaml.hpp from YAML.
struct PipelineConfig {
  std::string name = "pipeline";
  std::string yaml;  ///< the text that it was read from; "" if made in code
  PipelineParams params;
  CorrespondenceParams correspondence;
  FloorParams floor;
  InitialisationParams initialisation;
  StagePtr before_pose, after_pose, at_keyframe;  ///< null: no stage at this call point
};

/// What the host's tracker needs in this call, whatever the pipeline's own floor is.
struct HostLimits {
  int min_features = 0;  ///< fewer features are never left; more than the frame has: all are kept
};

/// What the host's tracker made of a frame. What it does not say stays empty.
struct HostTracking {
  Span<const cv::KeyPoint> keypoints;      ///< as the pipeline saw them, without those that it rejected
  Span<const std::int64_t> map_point_ids;  ///< of each of them; -1: none
  std::size_t inliers = 0, outliers = 0;   ///< matches that agree with its map, and that do not
};

/// Judges the features of one camera stream. Not thread-safe, verdicts on map points excepted.
/// The steady state allocates nothing that scales with the image.
class Pipeline {
 public:
  /// Throws ConfigError for a parameter out of range, and for an unknown DYNFILTER_SIMD (core/cpu.hpp).
  explicit Pipeline(PipelineConfig config);
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;
  ~Pipeline();

  /// Features are extracted, the pose is at most predicted. The verdict is valid until the next call.
  const Verdict& before_pose(const FrameView& frame, const HostLimits& limits = {}) {
    return process(frame, CallPoint::BeforePose, limits);
  }
  /// Call when a first pose is estimated and map points are matched.
  const Verdict& after_pose(const FrameView& frame, const HostLimits& limits = {}) {
    return process(frame, CallPoint::AfterPose, limits);
  }
  /// Call when the frame becomes a keyframe. Verdicts are then also per map point.
  const Verdict& at_keyframe(const FrameView& frame, const HostLimits& limits = {}) {
    return process(frame, CallPoint::AtKeyframe, limits);
  }
  /// The same with the call point as a value.
  const Verdict& process(const FrameView& frame, CallPoint call_point, const HostLimits& limits = {});

  /// Does what needs no features of the next frame, in a thread while the host extracts them. No other call
  /// may run meanwhile. Verdicts stay the same, also if another image or stamp comes next.
  void prepare(const cv::Mat& grey, double timestamp_s);

  /// Discards all earlier frames and map points. Call it at a new scene or map.
  void reset();
  void lost();  ///< the host lost its pose: discards the poses of earlier frames, and keeps the rest

  /// Sets the refined pose of an earlier frame, if it is still kept. `tracking` gives verdicts on map points
  /// and checks the pipeline by the host's inliers (pipeline/self_check.hpp).
  void update_pose(std::int64_t frame_id, const Pose& T_world_camera, PoseProvenance provenance,
                   const HostTracking& tracking = {});
  /// By the verdicts of all frames (pipeline/map_point_history.hpp). From any thread, as the next one.
  MapPointVerdict map_point(std::int64_t map_point_id) const;
  std::vector<std::int64_t> moved_map_points() const;  ///< those that are Dynamic, sorted

  /// Records or watches from now on; null ends it.
  void set_observer(std::shared_ptr<FrameObserver> observer);

  const std::string& name() const;  ///< the name in YAML, or that of the file
  Input inputs() const;             ///< what the last frame brought, without what cannot be used of it
  /// The tree of stages (pipeline/stage.hpp). Null: nothing happens at this call point.
  const Stage* stages(CallPoint point) const;
  Needs needs() const;  ///< of all stages together

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/pipeline-inl.hpp>
#endif
