// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <dynfilter/context/carried_box.hpp>
#include <dynfilter/core/span.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace dynfilter {

/// Boxes with a life beyond one result of the detector. Each new result's boxes and the old ones, both
/// carried to the same frame, are paired by overlap, best first, within a class; a pair is one track. An old
/// box without partner, a missed detection perhaps, is carried on for a while if at least two results had
/// shown it.
class BoxTracker {
 public:
  static constexpr double kMinOverlap = 0.3;  // of intersection over union
  static constexpr int kMaxBridged = 30;      // frames since it was found

  const std::vector<CarriedBox>& boxes() const { return boxes_; }

  /// To the next frame.
  void carry(const TrailFrame& to) {
    for (CarriedBox& box : boxes_) carrier_.carry(to, box);
  }

  /// The boxes of a newer result, found on `found_id` and carried along `path` to the frame where the old
  /// ones are.
  void take(Span<const Detection> detections, std::int64_t found_id,
            const std::vector<const TrailFrame*>& path) {
    new_.clear();
    for (const Detection& detection : detections) {
      new_.push_back(CarriedBox::from(detection, found_id));
      for (const TrailFrame* frame : path) carrier_.carry(*frame, new_.back());
    }
    pair_up();
    for (CarriedBox& box : new_)
      if (box.detection.track_id < 0) box.detection.track_id = next_id_++;
    for (CarriedBox& old : boxes_)
      if (old.hits >= 2 && found_id - old.found_id <= kMaxBridged) new_.push_back(std::move(old));
    std::swap(boxes_, new_);
  }

  void reset() { boxes_.clear(); }

 private:
  static double overlap(const cv::Rect2f& a, const cv::Rect2f& b) {
    const double both = static_cast<double>((a & b).area());
    const double either = static_cast<double>(a.area()) + static_cast<double>(b.area()) - both;
    return both > 0 && either > 0 ? both / either : 0;
  }

  /// The partners leave boxes_; their tracks go on in new_.
  void pair_up() {
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
      }
    boxes_.resize(left);
  }

  BoxCarrier carrier_;
  std::vector<CarriedBox> boxes_, new_;
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs_;
  std::vector<std::uint8_t> paired_new_, paired_old_;
  int next_id_ = 0;
};

}  // namespace dynfilter
