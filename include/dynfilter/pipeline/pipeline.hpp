// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>
#include <memory>
#include <string>

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

/// Judges the features of one camera stream. Not thread-safe. In steady state it allocates no image.
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

  /// Discards all earlier frames. Call it on loss of tracking, after relocalisation or at a new scene.
  void reset();

  /// Sets the refined pose of an earlier frame. Ignored if the frame is no longer kept.
  void update_pose(std::int64_t frame_id, const Pose& T_world_camera, PoseProvenance provenance);

  /// Records or watches from now on; null ends it.
  void set_observer(std::shared_ptr<FrameObserver> observer);

  const std::string& name() const;  ///< the name in YAML, or that of the file
  /// What the last frame brought, without what cannot be used of it.
  Input inputs() const;
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
