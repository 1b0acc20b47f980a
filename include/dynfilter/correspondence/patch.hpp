// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

namespace dynfilter::detail {

/// The template patch of Lucas-Kanade.
/// Holds grey values with 5 fractional bits, and 32 times their gradient.
/// Data is stored in bands of eight columns.
/// The rows of a band are contiguous, and two rows fill a vector of sixteen.
struct Patch {
  static constexpr int kMaxWindow = 63;
  static constexpr int kMaxBands = (kMaxWindow + 7) / 8;
  static constexpr int kMaxStride = 72;  // 65 columns, padded to whole vectors

  /// Number of columns, padded to whole vectors.
  static constexpr int padded(int columns) { return (columns + 7) / 8 * 8; }
  /// Index of row y in the band that starts at column x.
  int at(int x, int y) const { return x * rows + y * 8; }

  int rows = 0;  ///< rows of a band, an even number
  alignas(32) std::int16_t grey[kMaxBands * 8 * (kMaxWindow + 1)];
  alignas(32) std::int16_t dx[kMaxBands * 8 * (kMaxWindow + 1)];
  alignas(32) std::int16_t dy[kMaxBands * 8 * (kMaxWindow + 1)];
  /// Grey values row by row, with one extra pixel on every side.
  alignas(32) std::int16_t around[(kMaxWindow + 3) * kMaxStride + 16];
  float xx = 0, xy = 0, yy = 0;  ///< sums of products of gradients

  static constexpr float kScale = 1.0F / (1 << 20);  ///< scale of those sums
};

/// Top left corner of a patch: integer pixels, and weights of the next pixel in 1/32768.
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
