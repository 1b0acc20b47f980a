// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/detection.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Merges the instance masks of detections to one label image.
/// CV_8UC1, 0: no object, else class id + 1, at most 255; 1 for an unknown class.
/// Where masks overlap, the higher score wins. Masks of another size are skipped.
cv::Mat merged_masks(const std::vector<Detection>& detections, cv::Size image);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/semantic/detail/merged_masks-inl.hpp>
#endif
