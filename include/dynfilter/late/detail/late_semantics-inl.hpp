// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/late/late_semantics.hpp>

#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE const std::vector<CarriedBox>* LateSemantics::boxes(const DetectionInput& input,
                                                                     std::int64_t now_id) {
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

DYNFILTER_INLINE CarriedMask* LateSemantics::mask(const MaskInput& input, std::int64_t now_id) {
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

DYNFILTER_INLINE void LateSemantics::reset() {
  motions_.reset();
  boxes_.reset();
  boxes_of_.reset(), boxes_at_.reset(), mask_of_.reset(), mask_at_.reset();
}

}  // namespace dynfilter
