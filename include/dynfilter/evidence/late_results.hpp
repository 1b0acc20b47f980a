// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/frame_matches.hpp>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <dynfilter/late/carried_box.hpp>
#include <dynfilter/late/carried_mask.hpp>
#include <dynfilter/late/late_semantics.hpp>
#include <dynfilter/late/motion_history.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// Boxes and masks of older frames, carried to the current one. Records the motion that they are carried
/// along, once results have come late.
class LateResults {
 public:
  /// Refers to both, which must outlive it.
  LateResults(CurrentFrame& current, FrameMatches& matches) : current_(current), matches_(matches) {}

  /// True if a stage reads boxes or masks. Otherwise nothing is recorded.
  void set_used(bool used) { used_ = used; }

  /// `first_call`: this is the first call point of the frame.
  void begin(bool first_call);
  void end() {
    if (used_ && may_come_late()) record_step();
  }
  void reset() { carrier_.reset(); }

  const std::vector<Detection>* boxes(int max_age_frames);  ///< see Evidence::carried_boxes()
  const cv::Mat* labels();                                  ///< see Evidence::carried_labels()

 private:
  /// The k-th mask of `carried_`.
  const cv::Mat& instance(const CarriedBox& box, cv::Size image_px, std::size_t k);
  /// Records the motion since the last frame, once per frame.
  void record_step();
  /// This frame's subsampled depth image. The motion history takes over its memory.
  cv::Mat& sparse_depth();
  bool is_late() const;
  /// False while results arrive on time: the motion history is not needed.
  /// Before the first late result, the motion history must not cause extra flow.
  bool may_come_late() const;

  CurrentFrame& current_;
  FrameMatches& matches_;
  LateSemantics carrier_;
  std::vector<Detection> carried_;
  std::vector<cv::Mat> instances_;  ///< memory of their masks
  cv::Mat sparse_depth_m_;
  bool used_ = false, seen_ = false, sparse_depth_ready_ = false;
};

inline void LateResults::begin(bool first_call) {
  sparse_depth_ready_ = false;
  if (first_call && used_) sparse_depth();  // while the depth image is in the cache
}

inline const std::vector<Detection>* LateResults::boxes(int max_age_frames) {
  const FrameView& frame = current_.frame();
  record_step();
  const std::vector<CarriedBox>* boxes = carrier_.boxes(*frame.detections, frame.id);
  if (boxes == nullptr) return nullptr;
  carried_.clear();
  const MotionFrame& now = *carrier_.motions().find(frame.id);
  std::size_t instances = 0;
  for (const CarriedBox& box : *boxes) {
    if (id_gap(frame.id, box.found_id) > max_age_frames) continue;
    carried_.push_back(box.detection);
    if (!box.detection.mask.empty()) carried_.back().mask = instance(box, now.image_px, instances++);
  }
  return &carried_;
}

inline const cv::Mat& LateResults::instance(const CarriedBox& box, cv::Size image_px, std::size_t k) {
  if (k == instances_.size()) instances_.emplace_back();
  if (!has_sole_owner(instances_[k])) instances_[k].release();
  carried_instance(box, image_px, instances_[k]);
  return instances_[k];
}

inline const cv::Mat* LateResults::labels() {
  record_step();
  CarriedMask* mask = carrier_.mask(*current_.frame().mask, current_.frame().id);
  return mask == nullptr ? nullptr : &mask->labels();
}

inline void LateResults::record_step() {
  const FrameView& frame = current_.frame();
  seen_ = seen_ || is_late();
  if (carrier_.motions().find(frame.id) != nullptr) return;
  const Match& last = matches_.step_match();
  carrier_.motions().add(frame.id, last, current_.pixels(), current_.depths_m(), sparse_depth(),
                         image_size(current_.frame()));
}

inline cv::Mat& LateResults::sparse_depth() {
  const FrameView& frame = current_.frame();
  if (!sparse_depth_ready_) MotionHistory::sparse_depth(frame.depth, frame.depth_unit_m, sparse_depth_m_);
  sparse_depth_ready_ = true;
  return sparse_depth_m_;
}

inline bool LateResults::is_late() const {
  const FrameView& frame = current_.frame();
  const auto older = [&](std::int64_t id) { return id >= 0 && id != frame.id; };
  return (frame.detections && older(frame.detections->frame_id)) ||
         (frame.mask && older(frame.mask->frame_id));
}

inline bool LateResults::may_come_late() const {
  if (is_late()) return true;
  if (current_.frame().detections || current_.frame().mask) return false;
  return seen_ || matches_.has_step();
}

}  // namespace dynfilter
