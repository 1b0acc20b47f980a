// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/verdict.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter::python {

/// A verdict with the features that it is about.
struct PyVerdict {
  Verdict verdict;
  std::vector<std::uint8_t> keep;
  std::vector<float> weight;
  std::vector<cv::KeyPoint> keypoints;
};

}  // namespace dynfilter::python
