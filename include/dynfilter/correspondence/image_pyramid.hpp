// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>
#include <vector>

namespace dynfilter::detail {

/// A loop's body for cv::parallel_for_, which copies and allocates a std::function otherwise.
/// It refers to `work`.
template <class Work>
class RangeBody : public cv::ParallelLoopBody {
 public:
  explicit RangeBody(const Work& work) : work_(work) {}
  void operator()(const cv::Range& range) const override { work_(range); }

 private:
  const Work& work_;
};

/// Calls work(begin, end) on ranges that cover [0, count), on at most `threads` of OpenCV's threads.
template <class Work>
void in_ranges(int count, int threads, const Work& work) {
  if (threads <= 1) return work(0, count);
  const auto part = [&](const cv::Range& range) { work(range.start, range.end); };
  cv::parallel_for_({0, count}, RangeBody(part), threads);
}

}  // namespace dynfilter::detail

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

inline ImagePyramid::ImagePyramid(ImagePyramid&& other) noexcept {
  swap(other);
}

inline ImagePyramid& ImagePyramid::operator=(ImagePyramid&& other) noexcept {
  swap(other);
  return *this;
}

inline void ImagePyramid::build(const cv::Mat& grey, int window_px, int levels, bool derivatives) {
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

inline void ImagePyramid::swap(ImagePyramid& other) noexcept {
  std::swap(levels_, other.levels_);
  std::swap(size_, other.size_);
  std::swap(window_px_, other.window_px_);
}

}  // namespace dynfilter
