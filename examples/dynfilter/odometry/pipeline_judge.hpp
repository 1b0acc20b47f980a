// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/pipeline/pipeline.hpp>
#include <functional>
#include <utility>
#include <vector>

#include "feature_judge.hpp"

namespace dynfilter::odometry {

/// The toolkit as judge: a pipeline's three call points. This is all that a front end needs to write.
class PipelineJudge final : public FeatureJudge {
 public:
  /// Sees every verdict with the frame that it is about, e.g. for overlays and figures.
  using Observer = std::function<void(const FrameView&, const Verdict&)>;

  explicit PipelineJudge(Pipeline& pipeline, Observer observer = {})
      : pipeline_(pipeline), observer_(std::move(observer)) {}

  Flags before_pose(const FrameView& view) override {
    correspondence_ms_ = filters_ms_ = 0;
    return flags(view, pipeline_.before_pose(view));
  }
  Flags after_pose(const FrameView& view) override { return flags(view, pipeline_.after_pose(view)); }
  Flags at_keyframe(const FrameView& view) override { return flags(view, pipeline_.at_keyframe(view)); }
  void pose_refined(std::int64_t frame_id, const Pose& T_world_camera) override {
    pipeline_.update_pose(frame_id, T_world_camera, PoseProvenance::Refined);
  }
  void reset() override { pipeline_.reset(); }

  /// Of the frame that was shown last, all call points together.
  double correspondence_ms() const { return correspondence_ms_; }
  double filters_ms() const { return filters_ms_; }

 private:
  Flags flags(const FrameView& view, const Verdict& verdict) {
    rejected_.resize(verdict.size());
    for (std::size_t i = 0; i < verdict.size(); ++i) rejected_[i] = verdict.keep(i) ? 0 : 1;
    correspondence_ms_ += verdict.report.correspondence_ms;
    filters_ms_ += verdict.report.total_ms - verdict.report.correspondence_ms;
    if (observer_) observer_(view, verdict);
    return rejected_;
  }

  Pipeline& pipeline_;
  Observer observer_;
  std::vector<std::uint8_t> rejected_;
  double correspondence_ms_ = 0, filters_ms_ = 0;
};

}  // namespace dynfilter::odometry
