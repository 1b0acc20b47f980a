// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cmath>
#include <dynfilter/context/context.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/combinators.hpp>
#include <dynfilter/pipeline/floor.hpp>
#include <dynfilter/pipeline/initialisation.hpp>
#include <memory>
#include <string>
#include <utility>

namespace dynfilter {

/// What boxes and masks do in a frame that has no earlier one to compare with.
enum class FirstFrameSuspects {
  Keep,   ///< as in any other frame: a prior suspect stays until a stage says that it moves
  Reject  ///< what a semantic stage suspects is dynamic, unless the pipeline calls it static
};

struct PipelineParams {
  double max_time_gap_s = 2.0;
  FirstFrameSuspects first_frame_suspects = FirstFrameSuspects::Keep;

  static const FieldTable<PipelineParams>& fields() {
    static const FieldTable<PipelineParams> table{
        real("max_time_gap_s", &PipelineParams::max_time_gap_s, "s", {0, 1e9},
             "longest time between two frames; a longer gap, or time going backwards, resets the pipeline"),
        choice("first_frame_suspects", &PipelineParams::first_frame_suspects,
               {{"keep", FirstFrameSuspects::Keep}, {"reject", FirstFrameSuspects::Reject}},
               "features on boxes and masks of the first frame, and of the first after a reset"),
    };
    return table;
  }
};

/// All parts of a pipeline.
/// pipeline/compose.hpp creates them in C++, pipeline/yaml.hpp from YAML.
struct PipelineConfig {
  std::string name = "pipeline";
  PipelineParams params;
  ContextParams context;
  FloorParams floor;
  InitialisationParams initialisation;
  /// Null: no stage at this call point.
  std::unique_ptr<Stage> before_pose, after_pose, at_keyframe;
};

/// Judges the features of one camera stream. Not thread-safe.
/// The steady state allocates nothing that scales with the image.
class Pipeline {
 public:
  explicit Pipeline(PipelineConfig config)
      : config_(std::move(config)),
        context_(config_.context),
        floor_(config_.floor),
        initialisation_(config_.initialisation) {
    check_parameters(config_.params, "pipeline");
    check_parameters(config_.floor, "floor");
    check_parameters(config_.initialisation, "initialisation");
    context_.set_history(needs().history_frames);
    context_.set_semantics((needs().optional & (Input::Detections | Input::Mask)) != Input::None);
  }

  /// Call when features are extracted and the pose is at most predicted.
  /// The verdict is valid until the next call.
  const Verdict& before_pose(const FrameView& frame) { return process(frame, CallPoint::BeforePose); }
  /// Call when a first pose is estimated and map points are matched.
  const Verdict& after_pose(const FrameView& frame) { return process(frame, CallPoint::AfterPose); }
  /// Call when the frame becomes a keyframe. Verdicts are then also per map point.
  const Verdict& at_keyframe(const FrameView& frame) { return process(frame, CallPoint::AtKeyframe); }

  const Verdict& process(const FrameView& frame, CallPoint call_point) {
    const auto start = std::chrono::steady_clock::now();
    verdict_ = begin(frame, call_point);
    if (Stage* root = stage_at(call_point)) {
      context_.collect_suspicions(config_.params.first_frame_suspects == FirstFrameSuspects::Reject &&
                                  frame.id == first_id_);
      root->judge(context_, verdict_.report.stages, judgement_);
      take_verdict();
      if (context_.collects_suspicions()) reject_suspects();
      floor_.apply(context_.frame(), verdict_);
      initialisation_.apply(verdict_);
    }
    finish(call_point);
    verdict_.report.total_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return verdict_;
  }

  /// Discards all earlier frames.
  /// Call it on loss of tracking, after relocalisation or at a new scene.
  void reset() {
    context_.reset();
    for (const CallPoint point : kCallPoints)
      if (Stage* root = stage_at(point)) root->reset();
    initialisation_.reset();
    last_id_.reset();
  }

  /// Sets the refined pose of an earlier frame. Ignored if the frame is no longer kept.
  void update_pose(std::int64_t frame_id, const Pose& T_world_camera, PoseProvenance provenance) {
    context_.update_pose(frame_id, T_world_camera, provenance);
  }

  const std::string& name() const { return config_.name; }
  /// What the last frame brought, without what cannot be used of it.
  Input inputs() const { return context_.inputs(); }
  const Stage* stages(CallPoint point) const { return stage_at(point); }
  Needs needs() const {
    Needs all;
    for (const CallPoint point : kCallPoints) {
      const Stage* root = stage_at(point);
      if (root == nullptr) continue;
      all.optional = all.optional | root->needs().required | root->needs().optional;
      all.history_frames = std::max(all.history_frames, root->needs().history_frames);
    }
    return all;
  }

 private:
  static constexpr std::array<CallPoint, 3> kCallPoints{CallPoint::BeforePose, CallPoint::AfterPose,
                                                        CallPoint::AtKeyframe};

  Stage* stage_at(CallPoint point) const {
    return (point == CallPoint::BeforePose  ? config_.before_pose
            : point == CallPoint::AfterPose ? config_.after_pose
                                            : config_.at_keyframe)
        .get();
  }

  Verdict begin(const FrameView& frame, CallPoint call_point) {
    Verdict verdict = std::move(verdict_);  // reuses its memory
    verdict.report = FrameReport();
    verdict.report.frame_id = frame.id;
    verdict.report.call_point = call_point;
    if (time_jumped(frame)) {
      reset();
      verdict.report.notes.emplace_back("time jump: history forgotten");
    }
    if (!last_id_) first_id_ = frame.id;
    last_id_ = frame.id;
    last_timestamp_s_ = frame.timestamp_s;
    context_.begin(frame, call_point);
    for (const std::string& note : context_.input_notes()) verdict.report.notes.push_back(note);
    const std::size_t n = frame.size();
    verdict.report.features = n;
    verdict.decision.assign(n, Vote::Unknown);
    verdict.suspicion.assign(n, Votes::kNoIdea);
    verdict.prior.assign(n, 0);
    verdict.restored.assign(n, 0);
    verdict.reasons.assign(n, 0);
    verdict.map_points.clear();
    return verdict;
  }

  void take_verdict() {
    for (std::size_t i = 0; i < verdict_.size(); ++i) {
      verdict_.decision[i] = judgement_.votes[i];
      verdict_.suspicion[i] = judgement_.votes.score(i);
      verdict_.prior[i] = judgement_.votes.prior(i) ? 1 : 0;
      verdict_.reasons[i] = judgement_.reasons[i];
    }
  }

  /// The reasons are the stages that suspect it.
  void reject_suspects() {
    std::size_t rejected = 0;
    for (std::size_t i = 0; i < verdict_.size(); ++i) {
      if (verdict_.decision[i] != Vote::Unknown || context_.suspected_by(i) == 0) continue;
      verdict_.decision[i] = Vote::Dynamic;
      verdict_.reasons[i] = context_.suspected_by(i);
      ++rejected;
    }
    if (rejected > 0)
      verdict_.report.notes.push_back("first frame: " + std::to_string(rejected) +
                                      " features on boxes or masks rejected");
  }

  void finish(CallPoint call_point) {
    const FrameView& frame = context_.frame();
    verdict_.report.rejected = verdict_.size() - verdict_.kept();
    verdict_.report.correspondence_ms = context_.correspondence_ms();
    if (call_point == CallPoint::AtKeyframe)
      for (std::size_t i = 0; i < frame.map_point_ids.size(); ++i)
        if (frame.map_point_ids[i] >= 0)
          verdict_.map_points.push_back(
              {frame.map_point_ids[i], verdict_.decision[i], verdict_.suspicion[i]});
    if (call_point == CallPoint::AtKeyframe) {
      initialisation_.keyframe_made();
      verdict_.report.wait_for_keyframe = false;
    }
    context_.finish(call_point == CallPoint::AtKeyframe);
  }

  bool time_jumped(const FrameView& frame) const {
    if (!last_id_ || *last_id_ == frame.id) return false;
    const double step_s = frame.timestamp_s - last_timestamp_s_;
    return !(step_s >= 0 && step_s <= config_.params.max_time_gap_s);
  }

  PipelineConfig config_;
  Context context_;
  Floor floor_;
  Initialisation initialisation_;
  Judgement judgement_;
  Verdict verdict_;
  std::optional<std::int64_t> last_id_;
  std::int64_t first_id_ = -1;  ///< since the last reset
  double last_timestamp_s_ = 0;
};

}  // namespace dynfilter
