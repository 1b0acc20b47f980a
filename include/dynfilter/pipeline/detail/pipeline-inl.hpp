// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/pipeline.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/floor.hpp>
#include <dynfilter/pipeline/frame_observer.hpp>
#include <dynfilter/pipeline/initialisation.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <dynfilter/pipeline/map_point_history.hpp>
#include <dynfilter/pipeline/self_check.hpp>
#include <dynfilter/pipeline/stage.hpp>
#include <optional>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE void StageDeleter::operator()(Stage* stage) const noexcept {
  delete stage;
}

class Pipeline::Impl {
 public:
  explicit Impl(PipelineConfig config)
      : config_(std::move(config)),
        evidence_(config_.correspondence),
        floor_(config_.floor),
        initialisation_(config_.initialisation) {
    check_parameters(config_.params, "pipeline");
    check_parameters(config_.floor, "floor");
    check_parameters(config_.initialisation, "initialisation");
    evidence_.set_clock(&now_ms);
    evidence_.set_history(needs().history_frames);
    evidence_.set_semantics((needs().optional & kSemantic) != Input::None);
    if (const Stage* root = stage_at(CallPoint::BeforePose))
      root->for_each([this](const Stage& stage, int) {
        if ((stage.needs().required & kSemantic) != Input::None) semantic_paths_.push_back(stage.path());
      });
  }

  const Verdict& process(const FrameView& frame, CallPoint call_point, const HostLimits& limits) {
    if (observer_) observer_->frame(frame, call_point, limits);
    judge(frame, call_point, limits);
    if (observer_) observer_->judged(verdict_);
    return verdict_;
  }

  void judge(const FrameView& frame, CallPoint call_point, const HostLimits& limits) {
    const auto start = StageReports::Clock::now();
    begin(frame, call_point);
    if (Stage* root = stage_at(call_point)) {
      StageReports reports(verdict_.report.stages, deadline_after(start));
      if (frame.id == first_id_ && config_.params.first_frame_suspects == FirstFrameSuspects::Reject)
        reports.collect_suspicions(frame.size());
      root->judge(evidence_, reports, judgement_);
      reports.finish();
      note_budget(reports);
      take_verdict();
      take_spread();
      if (reports.collects_suspicions()) reject_suspects(reports);
      floor_.apply(evidence_.frame(), limits.min_features, verdict_);
      initialisation_.apply(verdict_);
    }
    learn(frame, call_point);
    finish(call_point);
    verdict_.report.total_ms =
        std::chrono::duration<double, std::milli>(StageReports::Clock::now() - start).count();
  }

  void reset() {
    evidence_.reset();
    for (const CallPoint point : kCallPoints)
      if (Stage* root = stage_at(point)) root->reset();
    initialisation_.reset();
    map_points_.reset();
    self_check_.reset();
    doubts_itself_ = false;
    last_id_.reset();
  }

  void lost() {
    evidence_.forget_poses();
    self_check_.reset();
    doubts_itself_ = false;
  }

  void update_pose(std::int64_t frame_id, const Pose& T_world_camera, PoseProvenance provenance,
                   const HostTracking& tracking) {
    evidence_.update_pose(frame_id, T_world_camera, provenance);
    map_points_.assign(frame_id, tracking.keypoints, tracking.map_point_ids);
    doubts_itself_ = self_check_.doubts(evidence_, frame_id, tracking) || doubts_itself_;
  }

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

  Stage* stage_at(CallPoint point) const {
    return (point == CallPoint::BeforePose  ? config_.before_pose
            : point == CallPoint::AfterPose ? config_.after_pose
                                            : config_.at_keyframe)
        .get();
  }
  const PipelineConfig& config() const { return config_; }
  FrameEvidence& evidence() { return evidence_; }
  FrameObserver* observer() const { return observer_.get(); }
  void set_observer(std::shared_ptr<FrameObserver> observer) {
    observer_ = std::move(observer);
    if (observer_) observer_->begin(config_);
  }
  const MapPointHistory& map_points() const { return map_points_; }

 private:
  static constexpr Input kSemantic = Input::Detections | Input::Mask;
  static constexpr std::array<CallPoint, 3> kCallPoints{CallPoint::BeforePose, CallPoint::AfterPose,
                                                        CallPoint::AtKeyframe};

  static double now_ms() {
    return std::chrono::duration<double, std::milli>(StageReports::Clock::now().time_since_epoch()).count();
  }

  /// An empty verdict; its memory is that of the last one.
  void begin(const FrameView& frame, CallPoint call_point) {
    begin_report(frame.id, call_point);
    if (time_jumped(frame)) {
      reset();
      verdict_.report.notes.emplace_back("time jump: history forgotten");
    }
    if (doubts_itself_) {
      reset();
      ++verdict_.report.doubts;
      verdict_.report.notes.emplace_back(
          "self-check: much is rejected that follows the host's own motion: history forgotten");
    }
    if (!last_id_) first_id_ = frame.id;
    last_id_ = frame.id;
    last_timestamp_s_ = frame.timestamp_s;
    evidence_.begin(frame, call_point);
    for (const std::string& note : evidence_.input_notes()) verdict_.report.notes.push_back(note);
    if (evidence_.prepared_in_vain())
      verdict_.report.notes.emplace_back("prepare() had another image or stamp: not used");
    const std::size_t n = frame.size();
    verdict_.report.features = n;
    verdict_.decision.assign(n, Vote::Unknown);
    verdict_.suspicion.assign(n, Votes::kNoIdea);
    verdict_.prior.assign(n, 0);
    verdict_.restored.assign(n, 0);
    verdict_.reasons.assign(n, 0);
    verdict_.spread.clear();
    verdict_.map_points.clear();
  }

  /// Texts and lists have the memory of the last call at the same call point.
  void begin_report(std::int64_t frame_id, CallPoint call_point) {
    FrameReport& last = verdict_.report;
    reports_of(last.call_point).swap(last.stages);
    FrameReport report;
    report.stages.swap(reports_of(call_point));
    report.notes.swap(last.notes);
    report.notes.clear();
    report.frame_id = frame_id;
    report.call_point = call_point;
    report.doubts = last.doubts;
    last = std::move(report);
    if (stage_at(call_point) == nullptr) last.stages.clear();
  }
  std::vector<StageReport>& reports_of(CallPoint point) { return reports_[static_cast<std::size_t>(point)]; }

  std::optional<StageReports::Clock::time_point> deadline_after(StageReports::Clock::time_point start) const {
    if (!(config_.params.budget_ms > 0)) return std::nullopt;
    const std::chrono::duration<double, std::milli> budget(config_.params.budget_ms);
    return start + std::chrono::duration_cast<StageReports::Clock::duration>(budget);
  }
  void note_budget(const StageReports& reports) {
    const std::optional<std::size_t> at = reports.late_at();
    const std::size_t skips = reports.late_skips();
    if (!at && skips == 0) return;
    std::string note = "over the time budget of " + number_text(config_.params.budget_ms) + " ms";
    if (at) append_text(note, " at `", verdict_.report.stages[*at].name, "`");
    if (skips > 0) append_text(note, ", ", skips, skips == 1 ? " rejector skipped" : " rejectors skipped");
    verdict_.report.notes.push_back(std::move(note));
  }

  void take_verdict() {
    for (std::size_t i = 0; i < verdict_.size(); ++i) {
      verdict_.decision[i] = judgement_.votes[i];
      verdict_.suspicion[i] = judgement_.votes.suspicion(i);
      verdict_.prior[i] = judgement_.votes.prior(i) ? 1 : 0;
      verdict_.reasons[i] = judgement_.reasons[i];
    }
  }

  void take_spread() {
    if (const std::vector<MatchSpread>* spread = evidence_.spread()) verdict_.spread = *spread;
  }

  /// The reasons are the stages that suspect it.
  void reject_suspects(const StageReports& reports) {
    std::size_t rejected = 0;
    for (std::size_t i = 0; i < verdict_.size(); ++i) {
      const std::uint64_t suspected_by = reports.suspected_by(i);
      if (verdict_.decision[i] != Vote::Unknown || suspected_by == 0) continue;
      verdict_.decision[i] = Vote::Dynamic;
      verdict_.reasons[i] = suspected_by;
      ++rejected;
    }
    if (rejected > 0)
      verdict_.report.notes.push_back("first frame: " + std::to_string(rejected) +
                                      " features on boxes or masks rejected");
  }

  void finish(CallPoint call_point) {
    verdict_.report.rejected = verdict_.size() - verdict_.kept();
    verdict_.report.correspondence_ms = evidence_.correspondence_ms();
    if (call_point == CallPoint::AtKeyframe) {
      judge_map_points();
      initialisation_.keyframe_made();
      verdict_.report.wait_for_keyframe = false;
    }
    evidence_.end(call_point == CallPoint::AtKeyframe);
  }
  void judge_map_points() {
    const Span<const std::int64_t> ids = evidence_.frame().map_point_ids;
    const bool judged_here = stage_at(CallPoint::AtKeyframe) != nullptr;
    for (std::size_t i = 0; i < ids.size(); ++i)
      if (ids[i] >= 0)
        verdict_.map_points.push_back(
            judged_here ? MapPointVerdict{ids[i], verdict_.decision[i], verdict_.suspicion[i]}
                        : map_points_.verdict(ids[i]));
  }

  /// For the map points of this frame, and for the check of it when the host has tracked it.
  void learn(const FrameView& frame, CallPoint call_point) {
    if (call_point != CallPoint::BeforePose)
      return map_points_.assign(frame.id, frame.keypoints, frame.map_point_ids);
    map_points_.learn(frame, evidence_, verdict_);
    std::uint64_t semantic = 0;
    const std::vector<StageReport>& stages = verdict_.report.stages;
    for (std::size_t k = 0; k < stages.size() && k < 64; ++k)
      if (std::find(semantic_paths_.begin(), semantic_paths_.end(), stages[k].path) != semantic_paths_.end())
        semantic |= std::uint64_t{1} << k;
    self_check_.keep(evidence_, verdict_, semantic);
  }

  bool time_jumped(const FrameView& frame) const {
    if (!last_id_ || *last_id_ == frame.id) return false;
    const double step_s = frame.timestamp_s - last_timestamp_s_;
    return !(step_s >= 0 && step_s <= config_.params.max_time_gap_s);
  }

  PipelineConfig config_;
  FrameEvidence evidence_;
  Floor floor_;
  Initialisation initialisation_;
  Judgement judgement_;
  MapPointHistory map_points_;
  SelfCheck self_check_;
  bool doubts_itself_ = false;               ///< the next call resets the pipeline
  std::vector<std::string> semantic_paths_;  ///< of stages that need boxes or masks
  Verdict verdict_;
  std::array<std::vector<StageReport>, kCallPoints.size()>
      reports_;  ///< of other call points than verdict_'s
  std::optional<std::int64_t> last_id_;
  std::int64_t first_id_ = -1;  ///< since the last reset
  double last_timestamp_s_ = 0;
  std::shared_ptr<FrameObserver> observer_;
};

DYNFILTER_INLINE Pipeline::Pipeline(PipelineConfig config)
    : impl_(std::make_unique<Impl>(std::move(config))) {
  if (simd_choice() == SimdChoice::Unknown)
    throw ConfigError("environment variable DYNFILTER_SIMD", "expected auto or baseline");
}
DYNFILTER_INLINE Pipeline::Pipeline(Pipeline&&) noexcept = default;
DYNFILTER_INLINE Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;
DYNFILTER_INLINE Pipeline::~Pipeline() = default;

DYNFILTER_INLINE const Verdict& Pipeline::process(const FrameView& frame, CallPoint call_point,
                                                  const HostLimits& limits) {
  return impl_->process(frame, call_point, limits);
}
DYNFILTER_INLINE void Pipeline::reset() {
  if (impl_->observer() != nullptr) impl_->observer()->reset();
  impl_->reset();
}
DYNFILTER_INLINE void Pipeline::prepare(const cv::Mat& grey, double timestamp_s) {
  impl_->evidence().prepare(grey, timestamp_s);
}
DYNFILTER_INLINE void Pipeline::lost() {
  if (impl_->observer() != nullptr) impl_->observer()->lost();
  impl_->lost();
}
DYNFILTER_INLINE void Pipeline::update_pose(std::int64_t frame_id, const Pose& T_world_camera,
                                            PoseProvenance provenance, const HostTracking& tracking) {
  if (impl_->observer() != nullptr) impl_->observer()->pose(frame_id, T_world_camera, provenance, tracking);
  impl_->update_pose(frame_id, T_world_camera, provenance, tracking);
}
DYNFILTER_INLINE MapPointVerdict Pipeline::map_point(std::int64_t map_point_id) const {
  return impl_->map_points().verdict(map_point_id);
}
DYNFILTER_INLINE std::vector<std::int64_t> Pipeline::moved_map_points() const {
  return impl_->map_points().moved();
}
DYNFILTER_INLINE void Pipeline::set_observer(std::shared_ptr<FrameObserver> observer) {
  impl_->set_observer(std::move(observer));
}
DYNFILTER_INLINE const std::string& Pipeline::name() const {
  return impl_->config().name;
}
DYNFILTER_INLINE Input Pipeline::inputs() const {
  return impl_->evidence().inputs();
}
DYNFILTER_INLINE const Stage* Pipeline::stages(CallPoint point) const {
  return impl_->stage_at(point);
}
DYNFILTER_INLINE Needs Pipeline::needs() const {
  return impl_->needs();
}

}  // namespace dynfilter
