// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/geometry/depth_noise.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

/// Depths of single pixels, whatever their type. DepthSampler gives those of features.
class DepthImage {
 public:
  DepthImage() = default;
  /// `depth`: CV_32FC1 or CV_16UC1, not copied. Any other type has no depth anywhere.
  DepthImage(const cv::Mat& depth, double unit_m) : unit_m_(static_cast<float>(unit_m)) {
    if (depth.type() == CV_32FC1 || depth.type() == CV_16UC1) depth_ = depth;
  }

  bool empty() const { return depth_.empty(); }  ///< whether it has no pixels
  int cols() const { return depth_.cols; }       ///< width [px]
  int rows() const { return depth_.rows; }       ///< height [px]
  /// At a pixel [m]; 0 outside. May be invalid (valid_depth()).
  float at(int x, int y) const {
    if (x < 0 || y < 0 || x >= depth_.cols || y >= depth_.rows) return 0;
    return (depth_.type() == CV_16UC1 ? static_cast<float>(depth_.ptr<std::uint16_t>(y)[x])
                                      : depth_.ptr<float>(y)[x]) *
           unit_m_;
  }

 private:
  cv::Mat depth_;
  float unit_m_ = 1;
};

}  // namespace dynfilter
