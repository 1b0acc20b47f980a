// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/mapping/key_regions.hpp>

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::mapping {

DYNFILTER_INLINE bool KeyRegions::any(Span<const Detection> detections) const {
  return std::any_of(detections.begin(), detections.end(),
                     [&](const Detection& d) { return label_of(d) > 0; });
}

DYNFILTER_INLINE int KeyRegions::label_of(const Detection& detection) const {
  const auto at = std::find(classes_.begin(), classes_.end(), detection.class_name);
  return at == classes_.end() ? 0
                              : static_cast<int>(std::min<std::ptrdiff_t>(at - classes_.begin(), 254)) + 1;
}

DYNFILTER_INLINE void KeyRegions::mark(Span<const Detection> detections, const cv::Mat& usable) {
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
