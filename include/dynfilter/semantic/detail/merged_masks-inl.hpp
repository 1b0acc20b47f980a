// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/semantic/merged_masks.hpp>

#include <algorithm>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE cv::Mat merged_masks(const std::vector<Detection>& detections, cv::Size image) {
  std::vector<const Detection*> order;
  for (const Detection& d : detections)
    if (d.mask.type() == CV_8UC1 && d.mask.size() == image) order.push_back(&d);
  std::stable_sort(order.begin(), order.end(),
                   [](const Detection* a, const Detection* b) { return a->score < b->score; });
  cv::Mat labels = cv::Mat::zeros(image, CV_8UC1);
  for (const Detection* d : order) labels.setTo(cv::Scalar(std::clamp(d->class_id, 0, 254) + 1), d->mask);
  return labels;
}

}  // namespace dynfilter
