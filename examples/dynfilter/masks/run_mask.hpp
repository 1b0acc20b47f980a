// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter::masks {

/// The pixels of one object in one image, as runs per row: about 1 kB for a person.
/// A whole clip of them fits into memory.
class RunMask {
 public:
  RunMask() = default;
  /// `mask`: CV_8UC1, nonzero inside. `offset`: where its first pixel is in the image.
  explicit RunMask(const cv::Mat& mask, cv::Point offset = {});

  bool empty() const { return runs_.empty(); }
  const cv::Rect& box() const { return box_; }
  /// Number of pixels.
  int area() const { return area_; }

  bool contains(cv::Point pixel) const;
  /// Number of pixels that both have.
  int overlap(const RunMask& other) const;
  /// Shared pixels by those of either; 0 if both are empty.
  double intersection_over_union(const RunMask& other) const;

  /// Sets the pixels of a CV_8UC1 image. Those outside of it are left out.
  void paint(cv::Mat& image, std::uint8_t value = 255) const;

  /// Scaled about the middle of its box, then shifted, and cut at the image's border.
  RunMask moved(cv::Point2f by_px, float scale, cv::Size image) const;

 private:
  struct Run {
    std::int16_t y, from, to;  ///< `to`: behind the last pixel
  };

  cv::Rect box_;
  int area_ = 0;
  std::vector<Run> runs_;  ///< by row, then from left to right
};

}  // namespace dynfilter::masks
