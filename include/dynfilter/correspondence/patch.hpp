// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

namespace dynfilter::detail {

/// The patch that Lucas-Kanade looks for: grey values with 5 fractional bits, and 32 times their gradient. In
/// bands of eight columns, so that the rows of a band follow each other in memory, two to a vector of
/// sixteen.
struct Patch {
  static constexpr int kMaxWindow = 63;
  static constexpr int kMaxBands = (kMaxWindow + 7) / 8;
  static constexpr int kMaxStride = 72;  // of 65 columns, in whole vectors

  /// Columns in whole vectors.
  static constexpr int padded(int columns) { return (columns + 7) / 8 * 8; }
  /// Where row y of the band from column x on begins.
  int at(int x, int y) const { return x * rows + y * 8; }

  int rows = 0;  ///< of a band, an even number
  alignas(32) std::int16_t grey[kMaxBands * 8 * (kMaxWindow + 1)];
  alignas(32) std::int16_t dx[kMaxBands * 8 * (kMaxWindow + 1)];
  alignas(32) std::int16_t dy[kMaxBands * 8 * (kMaxWindow + 1)];
  /// By rows, with one more pixel on every side.
  alignas(32) std::int16_t around[(kMaxWindow + 3) * kMaxStride + 16];
  float xx = 0, xy = 0, yy = 0;  ///< sums of products of gradients

  static constexpr float kScale = 1.0F / (1 << 20);  ///< of those sums
};

/// Where a patch begins: whole pixels and weights of the next pixel in 1/32768.
struct Corner {
  int x, y;
  std::int16_t u, v;

  explicit Corner(const cv::Point2f& at) : x(cvFloor(at.x)), y(cvFloor(at.y)) {
    u = static_cast<std::int16_t>(cvRound((at.x - static_cast<float>(x)) * 32767.0F));
    v = static_cast<std::int16_t>(cvRound((at.y - static_cast<float>(y)) * 32767.0F));
  }
  bool readable(const cv::Mat& image, int border_px, int size_px) const {
    return x >= -border_px && y >= -border_px && x + Patch::padded(size_px) + 1 <= image.cols + border_px &&
           y + size_px + 1 <= image.rows + border_px;
  }
  const unsigned char* in(const cv::Mat& image) const {
    return image.data + static_cast<std::ptrdiff_t>(image.step[0]) * y + x;
  }
};

}  // namespace dynfilter::detail
