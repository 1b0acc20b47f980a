// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>

#include "masks/run_mask.hpp"

namespace dynfilter::masks {

/// Histogram of an object's colours, of sum 1. Empty for an empty mask.
cv::Mat look_of(const cv::Mat& colour, const RunMask& mask);

/// Bhattacharyya distance, 0 to 1; 1 if one of them is empty.
double look_distance(const cv::Mat& a, const cv::Mat& b);

/// Moves what is remembered of an object a little towards what is seen now.
void blend_look(cv::Mat& remembered, const cv::Mat& seen);

}  // namespace dynfilter::masks
