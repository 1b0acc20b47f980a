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
  MotionHistory& motions() { return motions_; }
  const MotionHistory& motions() const { return motions_; }

  /// Boxes of frame `input.frame_id` carried to frame `now_id`, including recently missed ones.
  /// Null if the motion history does not connect the two frames.
  const std::vector<CarriedBox>* boxes(const DetectionInput& input, std::int64_t now_id);

  /// The same for the mask.
  CarriedMask* mask(const MaskInput& input, std::int64_t now_id);

  void reset();

 private:
  MotionHistory motions_;
  BoxTracker boxes_;
  CarriedMask mask_;
  std::optional<std::int64_t> boxes_of_, boxes_at_, mask_of_, mask_at_;
  std::vector<const MotionFrame*> path_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/late/detail/late_semantics-inl.hpp>
#endif
