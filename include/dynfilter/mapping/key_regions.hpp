// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter::mapping {

/// The pixels of static key objects (RTS-SLAM, Algorithm 2, lines 5 to 10). These are the boxes or instance
/// masks of the listed classes, without moving pixels. Classes are numbered from 1 in list order.
class KeyRegions {
 public:
  /// Class names, numbered from 1.
  explicit KeyRegions(std::vector<std::string> classes = {}) : classes_(std::move(classes)) {}

  /// Whether one of them is of a key class.
  bool any(Span<const Detection> detections) const {
    return std::any_of(detections.begin(), detections.end(),
                       [&](const Detection& d) { return label_of(d) > 0; });
  }
  /// Number of a detection's class; 0: not a key class.
  int label_of(const Detection& detection) const {
    const auto at = std::find(classes_.begin(), classes_.end(), detection.class_name);
    return at == classes_.end() ? 0
                                : static_cast<int>(std::min<std::ptrdiff_t>(at - classes_.begin(), 254)) + 1;
  }

  /// `usable`: CV_8UC1, not 0: belongs in the map. Where boxes overlap, the higher score wins.
  void mark(Span<const Detection> detections, const cv::Mat& usable);

  const cv::Mat& inside() const { return inside_; }  ///< CV_8UC1: class numbers, 0 outside
  /// CV_8UC1: usable and outside all key regions.
  const cv::Mat& outside() const { return outside_; }
  cv::Rect area() const { return area_; }  ///< bounds of all key regions

 private:
  void mark_one(const Detection& d);

  std::vector<std::string> classes_;
  cv::Mat inside_, outside_own_, outside_;
  cv::Rect area_;
};

inline void KeyRegions::mark(Span<const Detection> detections, const cv::Mat& usable) {
  inside_.create(usable.size(), CV_8UC1);
  inside_.setTo(0);
  area_ = cv::Rect();
  std::vector<const Detection*> known;
  for (const Detection& d : detections)
    if (label_of(d) > 0) known.push_back(&d);
  if (known.empty()) {
    outside_ = usable;
    return;
  }
  std::stable_sort(known.begin(), known.end(),
                   [](const Detection* a, const Detection* b) { return a->score < b->score; });
  for (const Detection* d : known) mark_one(*d);
  outside_own_.create(usable.size(), CV_8UC1);
  usable.copyTo(outside_own_);
  outside_own_.setTo(0, inside_);
  inside_.setTo(0, usable == 0);
  outside_ = outside_own_;
}

inline void KeyRegions::mark_one(const Detection& d) {
  const cv::Rect region = pixels_of(d.box, inside_.size());
  if (region.empty()) return;
  const bool masked = d.mask.type() == CV_8UC1 && d.mask.size() == inside_.size();
  masked ? inside_(region).setTo(label_of(d), d.mask(region)) : inside_(region).setTo(label_of(d));
  area_ = area_.empty() ? region : (area_ | region);
}

}  // namespace dynfilter::mapping
