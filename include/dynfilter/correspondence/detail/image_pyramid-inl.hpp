// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/correspondence/image_pyramid.hpp>

#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE ImagePyramid::ImagePyramid(ImagePyramid&& other) noexcept {
  swap(other);
}

DYNFILTER_INLINE ImagePyramid& ImagePyramid::operator=(ImagePyramid&& other) noexcept {
  swap(other);
  return *this;
}

DYNFILTER_INLINE void ImagePyramid::build(const cv::Mat& grey, int window_px, int levels, bool derivatives) {
  if (grey.empty() || grey.type() != CV_8UC1 || window_px < 3 || levels < 0) {
    clear();
    return;
  }
  window_px_ = window_px;
  size_ = grey.size();
  // Isolated: the border of a region must not contain pixels of the larger image.
  cv::buildOpticalFlowPyramid(grey, levels_, {window_px, window_px}, levels, derivatives,
                              cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED, cv::BORDER_CONSTANT, false);
}

DYNFILTER_INLINE void ImagePyramid::swap(ImagePyramid& other) noexcept {
  std::swap(levels_, other.levels_);
  std::swap(size_, other.size_);
  std::swap(window_px_, other.window_px_);
}

}  // namespace dynfilter
