// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/stage.hpp>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "odometry/feature_judge.hpp"
#include "overlay.hpp"
#include "stage_totals.hpp"

namespace dynfilter::command {

/// Verdict of the pipeline on one frame over all call points, per extracted feature.
struct FrameVerdict {
  std::vector<MarkedFeature> features;
  std::vector<std::string> notes;                          ///< of the frame
  std::vector<std::string> stage_notes;                    ///< "stage: note" of skipped or failed stages
  std::vector<std::pair<CallPoint, StageReport>> reports;  ///< of all stages, in order
  double correspondence_ms = 0, filters_ms = 0;

  std::size_t count(Vote vote) const {
    return static_cast<std::size_t>(std::count_if(
        features.begin(), features.end(), [&](const MarkedFeature& f) { return f.decision == vote; }));
  }
  /// Of the kept features; 1 without any.
  double mean_weight() const {
    double sum = 0;
    std::size_t kept = 0;
    for (const MarkedFeature& f : features)
      if (f.decision != Vote::Dynamic) sum += static_cast<double>(f.weight), ++kept;
    return kept > 0 ? sum / static_cast<double>(kept) : 1;
  }
  std::size_t restored() const {
    return static_cast<std::size_t>(
        std::count_if(features.begin(), features.end(), [](const MarkedFeature& f) { return f.restored; }));
  }
};

/// The pipeline as the odometry's judge. Records the frame for files and pictures.
class PipelineJudge final : public odometry::FeatureJudge {
 public:
  explicit PipelineJudge(PipelineConfig config) : pipeline_(std::move(config)), totals_(pipeline_) {
    // In the order of the file, so that a stage has the same symbol in every picture.
    for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
      if (const Stage* root = pipeline_.stages(point))
        root->for_each([&](const Stage& stage, int) { name_leaf(stage); });
    }
  }

  Flags before_pose(const FrameView& view) override {
    begin(view);
    return judge(view, CallPoint::BeforePose);
  }
  Flags after_pose(const FrameView& view) override { return judge(view, CallPoint::AfterPose); }
  Flags at_keyframe(const FrameView& view) override { return judge(view, CallPoint::AtKeyframe); }
  void pose_refined(std::int64_t frame_id, const Pose& T_world_camera) override {
    pipeline_.update_pose(frame_id, T_world_camera, PoseProvenance::Refined);
  }
  void lost() override { pipeline_.lost(); }
  void reset() override { pipeline_.reset(); }

  /// A call of a recording, as its host made it. Between two calls of a frame a host may thin it by the
  /// verdict. Or it hands in the same features again, or others, which are then those of the record.
  const Verdict& judge_recorded(const FrameView& view, CallPoint point, const HostLimits& limits,
                                bool new_frame) {
    if (new_frame || (view.size() != alive_.size() && view.size() != record_.features.size())) begin(view);
    if (view.size() != alive_.size()) all_alive();
    return process(view, point, limits);
  }
  Pipeline& pipeline() { return pipeline_; }
  bool wait_for_keyframe() const override { return wait_; }
  Span<const MatchSpread> spread() const override { return spread_; }

  const FrameVerdict& record() const { return record_; }
  const Pipeline& pipeline() const { return pipeline_; }
  /// Totals of each stage over all frames so far.
  const StageTotals& totals() const { return totals_; }
  /// Stage of each bit of MarkedFeature::reasons, so far.
  const std::vector<std::string>& stages() const { return stages_; }
  /// The same as text: "semantic_box+epipolar".
  std::string reason(const MarkedFeature& feature) const {
    std::string text;
    for (std::size_t k = 0; k < stages_.size() && k < 64; ++k) {
      if ((feature.reasons >> k & 1U) != 0) text += (text.empty() ? "" : "+") + stages_[k];
    }
    return text;
  }

 private:
  void name_leaf(const Stage& stage) {
    if (dynamic_cast<const FilterStage*>(&stage) != nullptr) bit_of(stage.name());
  }

  bool idle() const {
    return !pipeline_.stages(CallPoint::BeforePose) && !pipeline_.stages(CallPoint::AfterPose) &&
           !pipeline_.stages(CallPoint::AtKeyframe);
  }

  Flags judge(const FrameView& view, CallPoint point) {
    if (idle()) return {};
    if (point == CallPoint::AfterPose && !pipeline_.stages(point)) {
      pipeline_.update_pose(view.id, view.T_world_camera, view.pose_provenance);
      return {};
    }
    process(view, point, {});
    return flags_;
  }

  void begin(const FrameView& view) {
    record_ = FrameVerdict();
    for (const cv::KeyPoint& keypoint : view.keypoints)
      record_.features.push_back({keypoint.pt, Vote::Unknown, false, 0});
    all_alive();
  }
  void all_alive() {
    alive_.resize(record_.features.size());
    std::iota(alive_.begin(), alive_.end(), std::size_t{0});
  }

  const Verdict& process(const FrameView& view, CallPoint point, const HostLimits& limits) {
    const Verdict& verdict = pipeline_.process(view, point, limits);
    record_.correspondence_ms += verdict.report.correspondence_ms;
    record_.filters_ms += verdict.report.total_ms - verdict.report.correspondence_ms;
    wait_ = verdict.report.wait_for_keyframe;
    flags_.assign(view.size(), 0);
    spread_ = verdict.spread;
    if (pipeline_.stages(point)) take(verdict);
    return verdict;
  }

  void take(const Verdict& verdict) {
    note(verdict.report);
    totals_.add(verdict.report);
    std::size_t left = 0;
    for (std::size_t i = 0; i < verdict.size(); ++i) {
      MarkedFeature& feature = record_.features[alive_[i]];
      if (verdict.decision[i] != Vote::Unknown || verdict.restored[i]) feature.decision = verdict.decision[i];
      feature.restored = feature.restored || verdict.restored[i];
      feature.reasons |= named_reasons(verdict, i);
      feature.weight = verdict.weight(i);
      if (i < verdict.spread.size() && verdict.spread[i].along >= MatchSpread::kFar)
        feature.edge = verdict.spread[i].edge;
      flags_[i] = verdict.keep(i) ? 0 : 1;
      if (verdict.keep(i)) alive_[left++] = alive_[i];
    }
    alive_.resize(left);
  }

  void note(const FrameReport& report) {
    for (const StageReport& stage : report.stages) {
      record_.reports.emplace_back(report.call_point, stage);
      if (stage.skipped || stage.failed) record_.stage_notes.push_back(stage.name + ": " + stage.note);
    }
    record_.notes.insert(record_.notes.end(), report.notes.begin(), report.notes.end());
  }

  // Stages with the same name, inside and outside a region, share one reason bit.
  std::uint64_t named_reasons(const Verdict& verdict, std::size_t i) {
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < verdict.report.stages.size() && k < 64; ++k) {
      if ((verdict.reasons[i] >> k & 1U) != 0)
        bits |= std::uint64_t{1} << bit_of(verdict.report.stages[k].name);
    }
    return bits;
  }
  std::size_t bit_of(const std::string& name) {
    const auto found = std::find(stages_.begin(), stages_.end(), name);
    if (found != stages_.end()) return static_cast<std::size_t>(found - stages_.begin());
    if (stages_.size() < 64) stages_.push_back(name);
    return stages_.size() - 1;
  }

  Pipeline pipeline_;
  StageTotals totals_;
  FrameVerdict record_;
  std::vector<std::size_t> alive_;  ///< view index -> extracted feature
  std::vector<MatchSpread> spread_;
  std::vector<std::uint8_t> flags_;
  bool wait_ = false;
  std::vector<std::string> stages_;
};

}  // namespace dynfilter::command
