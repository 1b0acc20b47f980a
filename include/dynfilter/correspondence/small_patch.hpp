// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

namespace dynfilter::detail {

/// Template patch of at most 16 columns, which one vector of 16 values holds. It is cut at whole pixels, so
/// nothing is interpolated. All sums fit 32 bits, so results do not depend on the width of vectors.
/// Sums of values, gradients or differences down one column fit 16 bits.
struct SmallPatch {
  static constexpr int kMaxWindow = 16;
  static constexpr int kColumns = 16;
  static constexpr int kGreyScale = 8;       ///< grey values have 3 fractional bits
  static constexpr int kGradientScale = 10;  ///< gain of the gradient filter: (1 3 1) across, right - left

  alignas(32) std::int16_t grey[kMaxWindow * kColumns];
  /// Gradients. 0 outside the window and outside the image, whose border only mirrors it.
  alignas(32) std::int16_t dx[kMaxWindow * kColumns];
  alignas(32) std::int16_t dy[kMaxWindow * kColumns];
  std::int32_t x = 0, y = 0, xx = 0, xy = 0, yy = 0;  ///< sums of gradients and of their products
  std::int32_t sum = 0, square = 0;                   ///< of grey values
};

/// What differs between a patch and the image at a place: sums over the window.
struct SmallPatchMismatch {
  std::int32_t x = 0, y = 0;  ///< of (image - patch) times the gradients
  std::int32_t sum = 0;       ///< of image - patch
};

/// The same at a whole pixel: sums of image - patch and of its square.
struct SmallPatchDifference {
  std::int32_t sum = 0, square = 0;
};

/// 1 - NCC of the two needs these sums, too.
struct SmallPatchLikeness {
  std::int32_t sum = 0, square = 0;  ///< of image - patch
  std::int32_t product = 0;          ///< of (image - patch) times patch
};

/// Whole pixels, and weights of the next pixel: across in 1/128, down in 1/4096.
struct SmallCorner {
  static constexpr float kAcross = 128, kDown = 4096;

  int x, y;
  std::int16_t u, v;

  explicit SmallCorner(const cv::Point2f& at) : x(cvFloor(at.x)), y(cvFloor(at.y)) {
    u = static_cast<std::int16_t>(cvRound((at.x - static_cast<float>(x)) * kAcross));
    v = static_cast<std::int16_t>(cvRound((at.y - static_cast<float>(y)) * kDown));
  }
};

inline const unsigned char* pixel(const cv::Mat& image, int x, int y) {
  return image.data + static_cast<std::ptrdiff_t>(image.step[0]) * y + x;
}

}  // namespace dynfilter::detail
