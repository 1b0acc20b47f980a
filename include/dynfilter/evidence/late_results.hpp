// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/frame_matches.hpp>
#include <dynfilter/late/carried_box.hpp>
#include <dynfilter/late/carried_mask.hpp>
#include <dynfilter/late/late_semantics.hpp>
#include <dynfilter/late/motion_trail.hpp>
#include <vector>

namespace dynfilter {

/// Boxes and masks of older frames, carried to the current one. Records the motion that they are carried
/// along, once results have come late.
class LateResults {
 public:
  LateResults(CurrentFrame& current, FrameMatches& matches) : current_(current), matches_(matches) {}

  /// True if a stage reads boxes or masks. Otherwise nothing is recorded.
  void set_used(bool used) { used_ = used; }

  /// `first_call`: this is the first call point of the frame.
  void begin(bool first_call) {
    thin_depth_ready_ = false;
    if (first_call && used_) thin_depth();  // while the depth image is in the cache
  }
  void end() {
    if (used_ && may_come_late()) record_step();
  }
  void reset() { carrier_.reset(); }

  const std::vector<Detection>* boxes(int max_age_frames) {
    const FrameView& frame = current_.frame();
    record_step();
    const std::vector<CarriedBox>* boxes = carrier_.boxes(*frame.detections, frame.id);
    if (boxes == nullptr) return nullptr;
    carried_.clear();
    const TrailFrame& now = *carrier_.trail().find(frame.id);
    for (const CarriedBox& box : *boxes) {
      if (frame.id - box.found_id > max_age_frames) continue;
      carried_.push_back(box.detection);
      if (!box.detection.mask.empty()) carried_.back().mask = carried_instance(box, now.image_px);
    }
    return &carried_;
  }
  const cv::Mat* labels() {
    record_step();
    CarriedMask* mask = carrier_.mask(*current_.frame().mask, current_.frame().id);
    return mask == nullptr ? nullptr : &mask->labels();
  }

 private:
  /// Records the motion since the last frame, once per frame.
  void record_step() {
    const FrameView& frame = current_.frame();
    seen_ = seen_ || is_late();
    if (carrier_.trail().find(frame.id) != nullptr) return;
    const Match& last = matches_.step_match();
    carrier_.trail().add(frame.id, last, current_.pixels(), current_.depths_m(), thin_depth(),
                         current_.image_size_px());
  }
  /// This frame's subsampled depth image. The trail takes over its memory.
  cv::Mat& thin_depth() {
    const FrameView& frame = current_.frame();
    if (!thin_depth_ready_) MotionTrail::thin_depth(frame.depth, frame.depth_unit_m, thin_depth_m_);
    thin_depth_ready_ = true;
    return thin_depth_m_;
  }
  bool is_late() const {
    const FrameView& frame = current_.frame();
    const auto older = [&](std::int64_t id) { return id >= 0 && id != frame.id; };
    return (frame.detections && older(frame.detections->frame_id)) ||
           (frame.mask && older(frame.mask->frame_id));
  }
  /// False while results arrive on time: the trail is not needed.
  /// Before the first late result, the trail must not cause extra flow.
  bool may_come_late() const {
    if (is_late()) return true;
    if (current_.frame().detections || current_.frame().mask) return false;
    return seen_ || matches_.has_step();
  }

  CurrentFrame& current_;
  FrameMatches& matches_;
  LateSemantics carrier_;
  std::vector<Detection> carried_;
  cv::Mat thin_depth_m_;
  bool used_ = false, seen_ = false, thin_depth_ready_ = false;
};

}  // namespace dynfilter
