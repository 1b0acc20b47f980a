// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/late/box_tracker.hpp>
#include <dynfilter/late/carried_box.hpp>
#include <dynfilter/late/carried_mask.hpp>
#include <dynfilter/late/motion_history.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// Carries late boxes and masks to the current frame, frame by frame along the motion history.
/// A newer result is first carried from its own frame through all later frames.
/// After that it moves one step per frame until the next result arrives.
class LateSemantics {
 public:
  MotionHistory& motions() { return motions_; }  ///< the motion that results are carried along
  const MotionHistory& motions() const { return motions_; }

  /// Boxes of frame `input.frame_id` carried to frame `now_id`, including recently missed ones.
  /// Null if the motion history does not connect the two frames.
  const std::vector<CarriedBox>* boxes(const DetectionInput& input, std::int64_t now_id);

  /// The same for the mask.
  CarriedMask* mask(const MaskInput& input, std::int64_t now_id);

  void reset() {
    motions_.reset();
    boxes_.reset();
    boxes_of_.reset(), boxes_at_.reset(), mask_of_.reset(), mask_at_.reset();
  }

 private:
  MotionHistory motions_;
  BoxTracker boxes_;
  CarriedMask mask_;
  std::optional<std::int64_t> boxes_of_, boxes_at_, mask_of_, mask_at_;
  std::vector<const MotionFrame*> path_;
};

inline const std::vector<CarriedBox>* LateSemantics::boxes(const DetectionInput& input, std::int64_t now_id) {
  if (boxes_at_ && *boxes_at_ != now_id) {
    if (motions_.path(*boxes_at_, now_id, path_))
      for (const MotionFrame* frame : path_) boxes_.carry(*frame);
    else
      boxes_.reset(), boxes_of_.reset();
  }
  if (boxes_of_ != input.frame_id) {
    if (!motions_.path(input.frame_id, now_id, path_)) return nullptr;
    boxes_.take(input.detections, input.frame_id, path_);
    boxes_of_ = input.frame_id;
  }
  boxes_at_ = now_id;
  return &boxes_.boxes();
}

inline CarriedMask* LateSemantics::mask(const MaskInput& input, std::int64_t now_id) {
  if (mask_of_ == input.frame_id && mask_at_ == now_id) return &mask_;
  if (mask_of_ == input.frame_id && motions_.path(*mask_at_, now_id, path_)) {
    for (const MotionFrame* frame : path_) mask_.carry(*frame);
  } else {
    mask_of_.reset();
    const MotionFrame* seen = motions_.find(input.frame_id);
    if (seen == nullptr || !motions_.path(input.frame_id, now_id, path_)) return nullptr;
    mask_.start(input.labels, *seen);
    for (const MotionFrame* frame : path_) mask_.carry(*frame);
    mask_of_ = input.frame_id;
  }
  mask_at_ = now_id;
  return &mask_;
}

}  // namespace dynfilter
