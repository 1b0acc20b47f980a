// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/correspondence/patch_spread.hpp>
#include <limits>
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

/// 1 - NCC needs these sums of the grey values of a patch and of the image, and of their products.
struct SmallPatchLikeness {
  std::int32_t patch = 0, image = 0, patch2 = 0, image2 = 0, product = 0;
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

/// Lucas-Kanade for one point on one level: a patch of one image, and its position in another.
/// The patch is cut at the whole pixel nearest to the point, and the remainder is added to the result.
/// Gradients are the patch's, so one Hessian serves all steps (inverse compositional; Baker and Matthews,
/// IJCV 2004). The mean of the differences is subtracted, so a step of the exposure is no motion.
/// Both images have a readable border of `window_px` pixels.
template <class Kernels>
class SmallWindow {
 public:
  explicit SmallWindow(int window_px)
      : window_px_(window_px), count_(window_px * window_px), per_pixel_(1.0 / count_) {}

  /// False if the patch is not readable, or NaN.
  bool cut(const cv::Mat& image, const cv::Point2f& at) {
    const float half = static_cast<float>(window_px_ - 1) / 2;
    const cv::Point2f ideal = at - cv::Point2f(half, half);
    if (!readable(image, ideal)) return false;
    const cv::Point corner(cvRound(ideal.x), cvRound(ideal.y));
    Kernels::cut(image, corner.x, corner.y, window_px_, patch_);
    to_corner_ = cv::Point2f(corner) - at;
    return true;
  }

  /// False if the patch has less texture. `min_eigenvalue` is OpenCV's. Call it before refine().
  bool textured(double min_eigenvalue) {
    const double x = patch_.x, y = patch_.y, mean_x = x * per_pixel_, mean_y = y * per_pixel_;
    const double xx = patch_.xx - x * mean_x, xy = patch_.xy - x * mean_y, yy = patch_.yy - y * mean_y;
    const double determinant = xx * yy - xy * xy, trace = xx + yy;
    const double least = min_eigenvalue * kEigenvalueScale * count_;
    // Both eigenvalues of M are at least `least` if M - least I has no negative one.
    if (trace < 2 * least || determinant < least * (trace - least) || determinant <= 0) return false;
    const double scale = kStepScale / determinant;
    xx_ = xx * scale, xy_ = xy * scale, yy_ = yy * scale;
    return true;
  }
  /// Of a match of the patch. After textured().
  MatchSpread spread() const { return PatchSpread::of(xx_, xy_, yy_); }

  /// Mean square of image - patch, without the mean, at the nearest whole pixel. Infinite if not readable.
  /// A quarter of the cost of a step: enough to choose between places that are pixels apart.
  float difference(const cv::Mat& image, const cv::Point2f& at) const {
    const cv::Point2f corner = at + to_corner_;
    if (!readable(image, corner)) return std::numeric_limits<float>::infinity();
    const SmallPatchDifference off =
        Kernels::difference(image, cvRound(corner.x), cvRound(corner.y), window_px_, patch_);
    const auto per_pixel = static_cast<float>(per_pixel_), mean = static_cast<float>(off.sum) * per_pixel;
    return static_cast<float>(off.square) * per_pixel - mean * mean;
  }

  /// Moves `at` until a step is shorter than `epsilon_px`. False if it leaves the image.
  bool refine(const cv::Mat& image, int max_iterations, float epsilon_px, cv::Point2f& at) const {
    cv::Point2f corner = at + to_corner_, previous;
    for (int k = 0; k < max_iterations; ++k) {
      if (!readable(image, corner)) return false;
      const cv::Point2f step = step_at(image, corner);
      corner += step;
      if (step.dot(step) <= epsilon_px * epsilon_px) break;
      if (k > 0 && std::abs(step.x + previous.x) < kOscillationPx &&
          std::abs(step.y + previous.y) < kOscillationPx) {
        corner -= step * 0.5F;
        break;
      }
      previous = step;
    }
    at = corner - to_corner_;
    return readable(image, corner);
  }

  /// 1 - NCC of the patch and the image; 1 without texture or if not readable.
  double residual(const cv::Mat& image, const cv::Point2f& at) const {
    const cv::Point2f corner = at + to_corner_;
    if (!readable(image, corner)) return 1;
    const SmallPatchLikeness of = Kernels::likeness(image, SmallCorner(corner), window_px_, patch_);
    const double n = count_, a = of.patch, b = of.image;
    const double variances = (n * of.patch2 - a * a) * (n * of.image2 - b * b);
    return variances > 0 ? 1 - (n * of.product - a * b) / std::sqrt(variances) : 1;
  }

 private:
  static constexpr float kOscillationPx = 0.01F;  ///< of a step and the one before, in opposite directions
  /// OpenCV's eigenvalue is of the mean of squared gradients, divided by 1024.
  static constexpr double kEigenvalueScale = 1024.0 * SmallPatch::kGradientScale * SmallPatch::kGradientScale;
  static constexpr double kStepScale =
      static_cast<double>(SmallPatch::kGradientScale) / SmallPatch::kGreyScale;

  cv::Point2f step_at(const cv::Mat& image, const cv::Point2f& corner) const {
    const SmallPatchMismatch off = Kernels::mismatch(image, SmallCorner(corner), window_px_, patch_);
    const double mean = off.sum * per_pixel_;
    const double x = off.x - patch_.x * mean, y = off.y - patch_.y * mean;
    return {static_cast<float>(xy_ * y - yy_ * x), static_cast<float>(xy_ * x - xx_ * y)};
  }

  /// True if a patch whose corner is here, rounded or between pixels, is within the border. False for NaN.
  bool readable(const cv::Mat& image, const cv::Point2f& corner) const {
    const auto border = static_cast<float>(window_px_);
    return corner.x >= 2 - border && corner.y >= 2 - border &&
           corner.x <= static_cast<float>(image.cols + window_px_ - SmallPatch::kColumns - 2) &&
           corner.y <= static_cast<float>(image.rows - 2);
  }

  int window_px_, count_;
  double per_pixel_;
  SmallPatch patch_{};
  cv::Point2f to_corner_;  ///< from the point to the patch's corner
  double xx_ = 0, xy_ = 0, yy_ = 0;
};

}  // namespace dynfilter::detail
