// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>
#include <vector>

namespace dynfilter {

/// A grey image as pyramidal LK wants it: each level with a border of one window, and its derivatives if
/// asked for. It owns a deep copy, and building again for an image of the same size allocates nothing.
/// Move-only, because copies of cv::Mat share pixels; keep several for several earlier frames and std::swap
/// them.
class ImagePyramid {
 public:
  ImagePyramid() = default;
  ImagePyramid(const ImagePyramid&) = delete;
  ImagePyramid& operator=(const ImagePyramid&) = delete;
  ImagePyramid(ImagePyramid&& other) noexcept { swap(other); }
  ImagePyramid& operator=(ImagePyramid&& other) noexcept {
    swap(other);
    return *this;
  }

  /// `grey` is CV_8UC1 of any size; anything else leaves the pyramid empty. `levels` are those above the
  /// image itself, fewer for small images. OpenCV's tracker wants derivatives.
  void build(const cv::Mat& grey, int window_px, int levels, bool derivatives = true) {
    if (grey.empty() || grey.type() != CV_8UC1 || window_px < 3 || levels < 0) {
      clear();
      return;
    }
    window_px_ = window_px;
    size_ = grey.size();
    // Isolated: a region of a larger image must not look at the pixels around it.
    cv::buildOpticalFlowPyramid(grey, levels_, {window_px, window_px}, levels, derivatives,
                                cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED, cv::BORDER_CONSTANT, false);
  }

  /// Empty, but the memory is kept for the next build.
  void clear() { size_ = cv::Size(); }

  bool empty() const { return size_.empty(); }
  cv::Size size() const { return size_; }
  int window_px() const { return window_px_; }
  /// Images, in turn with derivatives if there are any, as cv::calcOpticalFlowPyrLK takes them.
  const std::vector<cv::Mat>& levels() const { return levels_; }
  cv::Mat image() const { return empty() ? cv::Mat() : levels_[0]; }

  /// Can flow run between the two?
  bool fits(const ImagePyramid& other) const {
    return !empty() && size_ == other.size_ && window_px_ == other.window_px_ &&
           levels_.size() == other.levels_.size();
  }

  void swap(ImagePyramid& other) noexcept {
    std::swap(levels_, other.levels_);
    std::swap(size_, other.size_);
    std::swap(window_px_, other.window_px_);
  }

 private:
  std::vector<cv::Mat> levels_;
  cv::Size size_;
  int window_px_ = 0;
};

}  // namespace dynfilter
