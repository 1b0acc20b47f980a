// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/correspondence/short_vector.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <vector>

namespace dynfilter {

/// Pyramidal Lucas-Kanade (Bouguet 2000) with the arithmetic of OpenCV's, but without its derivative images
/// (the gradients come from the interpolated patch), with separable interpolation and without a scalar rest:
/// less than half of its time at the same accuracy. Only 128-bit instructions that every x86-64 and ARMv8
/// has.
struct LucasKanade {
  int window_px = 21;
  int levels = 3;
  int max_iterations = 30;
  double epsilon_px = 0.01;
  double min_eigenvalue = 1e-4;

  /// Is a patch, rounded up to whole vectors, covered by a border of one window around the image?
  static constexpr bool supports(int window_px) {
    return window_px <= kMaxWindow && padded(window_px + 2) + 2 - window_px / 2 <= window_px;
  }

  /// `from` and `to` are pyramids with a border of `window_px` around every level, every `stride`-th image
  /// one level. `to_px` holds the guesses and receives the results. Each point is tracked alone.
  void track(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to, std::size_t stride,
             const std::vector<cv::Point2f>& from_px, std::vector<cv::Point2f>& to_px,
             std::vector<std::uint8_t>& status) const {
    status.assign(from_px.size(), 0);
    const auto count = static_cast<int>(std::min(from.size(), to.size()) / stride);
    const int top = std::min(levels, count - 1);
    if (top < 0 || !supports(window_px)) return;
    const auto track_range = [&](const cv::Range& range) {
      Patch patch;
      for (int i = range.start; i < range.end; ++i) {
        const auto k = static_cast<std::size_t>(i);
        cv::Point2f at = to_px[k] * std::ldexp(1.0F, -top);
        for (int level = top; level >= 0; --level) {
          const auto l = static_cast<std::size_t>(level) * stride;
          if (level < top) at *= 2;
          status[k] = track_level(from[l], to[l], from_px[k] * std::ldexp(1.0F, -level), patch, at) ? 1 : 0;
        }
        to_px[k] = at;
      }
    };
    cv::parallel_for_({0, static_cast<int>(from_px.size())}, track_range,
                      static_cast<double>(from_px.size()) / 64);
  }

 private:
  using Int16x8 = detail::Int16x8;
  using Int32x4 = detail::Int32x4;
  using Float32x4 = detail::Float32x4;

  static constexpr int kMaxWindow = 63;
  static constexpr int kMaxStride = 72;  // of 65 columns, in whole vectors

  static constexpr int padded(int columns) { return (columns + 7) / 8 * 8; }

  /// The patch that is looked for: grey values with 5 fractional bits, and 32 times their gradient.
  struct Patch {
    alignas(16) std::int16_t grey[kMaxWindow * kMaxStride];
    alignas(16) std::int16_t dx[kMaxWindow * kMaxStride];
    alignas(16) std::int16_t dy[kMaxWindow * kMaxStride];
    alignas(16) std::int16_t around[(kMaxWindow + 2) * kMaxStride + 8];  // with one more pixel on every side
    float xx = 0, xy = 0, yy = 0;                                        // sums of products of gradients
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
      return x >= -border_px && y >= -border_px && x + padded(size_px) + 1 <= image.cols + border_px &&
             y + size_px + 1 <= image.rows + border_px;
    }
    const unsigned char* in(const cv::Mat& image) const {
      return image.data + static_cast<std::ptrdiff_t>(image.step[0]) * y + x;
    }
  };

  /// Eight grey values between two neighbouring columns, times 64.
  static Int16x8 between_columns(const unsigned char* row, const Int16x8& u) {
    const Int16x8 left = detail::load_bytes(row);
    const Int16x8 right = detail::load_bytes(row + 1);
    return left * 64 + detail::high_product((right - left) * 128, u);
  }
  /// Between two such rows, times 32.
  static Int16x8 between_rows(const Int16x8& upper, const Int16x8& lower, const Int16x8& v) {
    return (upper >> 1) + detail::high_product(lower - upper, v);
  }

  bool track_level(const cv::Mat& from, const cv::Mat& to, const cv::Point2f& from_px, Patch& patch,
                   cv::Point2f& at) const {
    const float half = static_cast<float>(window_px - 1) * 0.5F;
    if (!near(from_px, from)) return false;
    const Corner corner(from_px - cv::Point2f(half + 1, half + 1));
    if (!corner.readable(from, window_px, window_px + 2)) return false;
    cut_patch(from, corner, patch);
    const float determinant = patch.xx * patch.yy - patch.xy * patch.xy;
    const float spread = patch.xx - patch.yy;
    const float least = (patch.xx + patch.yy - std::sqrt(spread * spread + 4 * patch.xy * patch.xy)) /
                        static_cast<float>(2 * window_px * window_px);
    if (!(static_cast<double>(least) >= min_eigenvalue) || determinant < 1.1920929e-7F) return false;
    const auto enough = static_cast<float>(epsilon_px);
    cv::Point2f previous;
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
      if (!near(at, to)) return false;
      const Corner target(at - cv::Point2f(half, half));
      if (!target.readable(to, window_px, window_px)) return false;
      float bx = 0, by = 0;
      mismatch(to, target, patch, bx, by);
      const cv::Point2f step((patch.xy * by - patch.yy * bx) / determinant,
                             (patch.xy * bx - patch.xx * by) / determinant);
      at += step;
      if (step.dot(step) <= enough * enough) break;
      if (iteration > 0 && std::abs(step.x + previous.x) < 0.01F && std::abs(step.y + previous.y) < 0.01F) {
        at -= step * 0.5F;  // to and fro
        break;
      }
      previous = step;
    }
    return std::isfinite(at.x) && std::isfinite(at.y);
  }

  /// Close enough to the image for whole numbers; false for NaN.
  bool near(const cv::Point2f& at, const cv::Mat& image) const {
    const auto margin = static_cast<float>(window_px);
    return at.x >= -margin && at.y >= -margin && at.x <= static_cast<float>(image.cols) + margin &&
           at.y <= static_cast<float>(image.rows) + margin;
  }

  void cut_patch(const cv::Mat& image, const Corner& corner, Patch& patch) const {
    const int size = window_px + 2, stride = padded(size);
    const Int16x8 u = detail::all(corner.u), v = detail::all(corner.v);
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    for (int x = 0; x < stride; x += 8) {
      const unsigned char* row = corner.in(image) + x;
      Int16x8 upper = between_columns(row, u);
      for (int y = 0; y < size; ++y) {
        row += step;
        const Int16x8 lower = between_columns(row, u);
        detail::store(patch.around + y * stride + x, between_rows(upper, lower, v));
        upper = lower;
      }
    }
    detail::store(patch.around + size * stride, Int16x8{});  // read with the last row, and masked
    gradients(stride, patch, {corner.x + 1, corner.y + 1}, image.size());
  }

  /// Scharr's operator (3 10 3), on values with 3 fractional bits so that 16 bits suffice. Outside the image,
  /// where the border only mirrors it, there is no gradient, so that these pixels have no say.
  void gradients(int stride, Patch& patch, const cv::Point& corner, const cv::Size& image) const {
    const Int16x8 three = detail::all(3), ten = detail::all(10), four = detail::all(4);
    const auto load = [](const std::int16_t* p) { return (detail::load(p) + detail::all(2)) >> 2; };
    Float32x4 xx{}, xy{}, yy{};
    const int first_row = -corner.y, last_row = image.height - corner.y;
    const int first_column = -corner.x, last_column = std::min(window_px, image.width - corner.x);
    const int width = padded(window_px);
    for (int y = 0; y < window_px; ++y)
      for (int x = 0; x < width; x += 8) {
        const std::int16_t* p = patch.around + y * stride + x;
        const Int16x8 a = load(p), b = load(p + 1), c = load(p + 2);
        const Int16x8 d = load(p + stride), f = load(p + stride + 2);
        const Int16x8 g = load(p + 2 * stride), h = load(p + 2 * stride + 1), i = load(p + 2 * stride + 2);
        const Int16x8 inside =
            y < first_row || y >= last_row ? Int16x8{} : columns(x, first_column, last_column);
        const Int16x8 dx = (((three * ((c - a) + (i - g)) + ten * (f - d)) + four) >> 3) & inside;
        const Int16x8 dy = (((three * ((g - a) + (i - c)) + ten * (h - b)) + four) >> 3) & inside;
        const int at = y * width + x;
        detail::store(patch.grey + at, detail::load(p + stride + 1));
        detail::store(patch.dx + at, dx);
        detail::store(patch.dy + at, dy);
        xx += detail::to_float(detail::pair_products(dx, dx));
        xy += detail::to_float(detail::pair_products(dx, dy));
        yy += detail::to_float(detail::pair_products(dy, dy));
      }
    patch.xx = detail::sum(xx) * kScale;
    patch.xy = detail::sum(xy) * kScale;
    patch.yy = detail::sum(yy) * kScale;
  }

  /// All bits set where column x + lane is in [first, last).
  static Int16x8 columns(int x, int first, int last) {
    const Int16x8 column = Int16x8{0, 1, 2, 3, 4, 5, 6, 7} + detail::all(x);
    return (column >= detail::all(first)) & (column < detail::all(last));
  }

  /// Sums of (target - patch) times the patch's gradients.
  void mismatch(const cv::Mat& image, const Corner& corner, const Patch& patch, float& bx, float& by) const {
    constexpr int kRows = 16;  // of products below 2^27, whose sums fit 32 bits
    const Int16x8 u = detail::all(corner.u), v = detail::all(corner.v);
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    const int width = padded(window_px);
    Float32x4 sum_x{}, sum_y{};
    for (int x = 0; x < width; x += 8) {
      const unsigned char* row = corner.in(image) + x;
      Int16x8 upper = between_columns(row, u);
      for (int y0 = 0; y0 < window_px; y0 += kRows) {
        Int32x4 part_x{}, part_y{};
        for (int y = y0; y < std::min(y0 + kRows, window_px); ++y) {
          row += step;
          const Int16x8 lower = between_columns(row, u);
          const int at = y * width + x;
          const Int16x8 off = between_rows(upper, lower, v) - detail::load(patch.grey + at);
          part_x += detail::pair_products(off, detail::load(patch.dx + at));
          part_y += detail::pair_products(off, detail::load(patch.dy + at));
          upper = lower;
        }
        sum_x += detail::to_float(part_x);
        sum_y += detail::to_float(part_y);
      }
    }
    bx = detail::sum(sum_x) * kScale;
    by = detail::sum(sum_y) * kScale;
  }

  static constexpr float kScale = 1.0F / (1 << 20);
};

}  // namespace dynfilter
