// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// A grey image pyramid for pyramidal LK.
/// Each level has a border of one window, and derivatives if requested.
/// It owns a deep copy. Rebuilding for the same image size allocates nothing.
/// It is move-only because copies of cv::Mat share pixels.
/// To keep several frames, use several objects and std::swap.
class ImagePyramid {
 public:
  ImagePyramid() = default;
  ImagePyramid(const ImagePyramid&) = delete;
  ImagePyramid& operator=(const ImagePyramid&) = delete;
  ImagePyramid(ImagePyramid&& other) noexcept;
  ImagePyramid& operator=(ImagePyramid&& other) noexcept;

  /// `grey` is CV_8UC1 of any size; any other type leaves the pyramid empty.
  /// `levels` counts the levels above the image; small images get fewer.
  /// OpenCV's tracker needs `derivatives`.
  void build(const cv::Mat& grey, int window_px, int levels, bool derivatives = true);

  /// Makes the pyramid empty and keeps its memory for the next build.
  void clear() { size_ = cv::Size(); }

  bool empty() const { return size_.empty(); }
  cv::Size size() const { return size_; }
  int window_px() const { return window_px_; }
  /// Images as cv::calcOpticalFlowPyrLK takes them, alternating with derivatives if present.
  const std::vector<cv::Mat>& levels() const { return levels_; }
  cv::Mat image() const { return empty() ? cv::Mat() : levels_[0]; }

  /// True if flow can run between the two pyramids.
  bool fits(const ImagePyramid& other) const {
    return !empty() && size_ == other.size_ && window_px_ == other.window_px_ &&
           levels_.size() == other.levels_.size();
  }

  void swap(ImagePyramid& other) noexcept;

 private:
  std::vector<cv::Mat> levels_;
  cv::Size size_;
  int window_px_ = 0;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/correspondence/detail/image_pyramid-inl.hpp>
#endif
