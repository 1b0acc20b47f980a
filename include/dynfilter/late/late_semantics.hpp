// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/late/box_tracker.hpp>
#include <dynfilter/late/carried_box.hpp>
#include <dynfilter/late/carried_mask.hpp>
#include <dynfilter/late/motion_trail.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace dynfilter {

/// Carries late boxes and masks to the current frame, frame by frame along the motion trail.
/// A newer result is first carried from its own frame through all later frames.
/// After that it moves one step per frame until the next result arrives.
class LateSemantics {
 public:
  MotionTrail& trail() { return trail_; }
  const MotionTrail& trail() const { return trail_; }

  /// Boxes of frame `input.frame_id` carried to frame `now_id`, including recently missed ones.
  /// Null if the trail does not connect the two frames.
  const std::vector<CarriedBox>* boxes(const DetectionInput& input, std::int64_t now_id) {
    if (boxes_at_ && *boxes_at_ != now_id) {
      if (trail_.path(*boxes_at_, now_id, path_))
        for (const TrailFrame* frame : path_) boxes_.carry(*frame);
      else
        boxes_.reset(), boxes_of_.reset();
    }
    if (boxes_of_ != input.frame_id) {
      if (!trail_.path(input.frame_id, now_id, path_)) return nullptr;
      boxes_.take(input.detections, input.frame_id, path_);
      boxes_of_ = input.frame_id;
    }
    boxes_at_ = now_id;
    return &boxes_.boxes();
  }

  /// The same for the mask.
  CarriedMask* mask(const MaskInput& input, std::int64_t now_id) {
    if (mask_of_ == input.frame_id && mask_at_ == now_id) return &mask_;
    if (mask_of_ == input.frame_id && trail_.path(*mask_at_, now_id, path_)) {
      for (const TrailFrame* frame : path_) mask_.carry(*frame);
    } else {
      mask_of_.reset();
      const TrailFrame* seen = trail_.find(input.frame_id);
      if (seen == nullptr || !trail_.path(input.frame_id, now_id, path_)) return nullptr;
      mask_.start(input.labels, *seen);
      for (const TrailFrame* frame : path_) mask_.carry(*frame);
      mask_of_ = input.frame_id;
    }
    mask_at_ = now_id;
    return &mask_;
  }

  void reset() {
    trail_.reset();
    boxes_.reset();
    boxes_of_.reset(), boxes_at_.reset(), mask_of_.reset(), mask_at_.reset();
  }

 private:
  MotionTrail trail_;
  BoxTracker boxes_;
  CarriedMask mask_;
  std::optional<std::int64_t> boxes_of_, boxes_at_, mask_of_, mask_at_;
  std::vector<const TrailFrame*> path_;
};

}  // namespace dynfilter
