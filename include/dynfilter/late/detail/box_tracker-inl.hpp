// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/late/box_tracker.hpp>

#include <algorithm>
#include <dynfilter/core/frame_ids.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/limits.hpp>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE void BoxTracker::carry(const MotionFrame& to) {
  for (CarriedBox& box : boxes_) carrier_.carry(to, box);
}

DYNFILTER_INLINE void BoxTracker::take(Span<const Detection> detections, std::int64_t found_id,
                                       const std::vector<const MotionFrame*>& path) {
  new_.clear();
  for (const Detection& detection : detections) {
    new_.push_back(CarriedBox::from(detection, found_id));
    own_mask(new_.back().detection.mask);
    for (const MotionFrame* frame : path) carrier_.carry(*frame, new_.back());
  }
  pair_up();
  for (CarriedBox& box : new_)
    if (box.detection.track_id < 0) box.detection.track_id = next_id_++;
  for (CarriedBox& old : boxes_)
    if (old.hits >= 2 && id_gap(found_id, old.found_id) <= kMaxBridged && new_.size() < limits::kMaxBoxes)
      new_.push_back(std::move(old));
    else
      recycle_mask(old);
  std::swap(boxes_, new_);
  spare_masks_.resize(std::min(spare_masks_.size(), boxes_.size()));
}

inline void BoxTracker::own_mask(cv::Mat& mask) {
  if (mask.empty()) return;
  cv::Mat copy;
  if (!spare_masks_.empty()) {
    copy = std::move(spare_masks_.back());
    spare_masks_.pop_back();
  }
  keep_copy(mask, copy);
  mask = std::move(copy);
}

inline void BoxTracker::recycle_mask(CarriedBox& box) {
  if (!box.detection.mask.empty()) spare_masks_.push_back(std::move(box.detection.mask));
}

inline double BoxTracker::overlap(const cv::Rect2f& a, const cv::Rect2f& b) {
  const double both = static_cast<double>((a & b).area());
  const double either = static_cast<double>(a.area()) + static_cast<double>(b.area()) - both;
  return both > 0 && either > 0 ? both / either : 0;
}

inline void BoxTracker::pair_up() {
  pairs_.clear();
  for (std::size_t n = 0; n < new_.size(); ++n)
    for (std::size_t o = 0; o < boxes_.size(); ++o) {
      const Detection &a = new_[n].detection, &b = boxes_[o].detection;
      const double share = a.class_name == b.class_name ? overlap(a.box, b.box) : 0;
      if (share >= kMinOverlap) pairs_.emplace_back(-share, n, o);
    }
  std::sort(pairs_.begin(), pairs_.end());
  paired_new_.assign(new_.size(), 0);
  paired_old_.assign(boxes_.size(), 0);
  for (const auto& [share, n, o] : pairs_) {
    if (paired_new_[n] != 0 || paired_old_[o] != 0) continue;
    paired_new_[n] = paired_old_[o] = 1;
    new_[n].hits = boxes_[o].hits + 1;
    if (new_[n].detection.track_id < 0) new_[n].detection.track_id = boxes_[o].detection.track_id;
  }
  std::size_t left = 0;
  for (std::size_t o = 0; o < boxes_.size(); ++o)
    if (paired_old_[o] == 0) {
      if (left != o) boxes_[left] = std::move(boxes_[o]);
      ++left;
    } else {
      recycle_mask(boxes_[o]);
    }
  boxes_.resize(left);
}

}  // namespace dynfilter
