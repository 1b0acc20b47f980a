// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/core/detection.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Merges the instance masks of detections to one label image.
/// CV_8UC1, 0: no object, else class id + 1, at most 255; 1 for an unknown class.
/// Where masks overlap, the higher score wins. Masks of another size are skipped.
cv::Mat merged_masks(const std::vector<Detection>& detections, cv::Size image);

inline cv::Mat merged_masks(const std::vector<Detection>& detections, cv::Size image) {
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
