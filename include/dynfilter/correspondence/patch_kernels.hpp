// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/correspondence/short_vector.hpp>
#include <opencv2/core.hpp>
#include <utility>

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

/// The three pixel loops of Lucas-Kanade, eight pixels of a row at a time.
/// Uses instructions that every x86-64 and ARMv8 processor has.
struct PatchKernels {
  /// Fills `patch` from the image. `corner` is one pixel left of and above the window.
  static void cut(const cv::Mat& image, const Corner& corner, int window_px, Patch& patch) {
    const int size = window_px + 2, stride = Patch::padded(size);
    const Int16x8 u = all(corner.u), v = all(corner.v);
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    for (int x = 0; x < stride; x += 8) {
      const unsigned char* row = corner.in(image) + x;
      Int16x8 upper = between_columns(row, u);
      for (int y = 0; y < size; ++y) {
        row += step;
        const Int16x8 lower = between_columns(row, u);
        store(patch.around + y * stride + x, between_rows(upper, lower, v));
        upper = lower;
      }
    }
    store(patch.around + size * stride, Int16x8{});  // read with the last row, then masked
    patch.rows = window_px + window_px % 2;
    gradients(window_px, stride, {corner.x + 1, corner.y + 1}, image.size(), patch);
  }

  /// Sums of (target - patch) times the patch's gradients.
  static cv::Point2f mismatch(const cv::Mat& image, const Corner& corner, int window_px, const Patch& patch) {
    constexpr int kRows = 16;  // products are below 2^27, so 16 of them fit 32 bits
    const Int16x8 u = all(corner.u), v = all(corner.v);
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    Float32x4 sum_x{}, sum_y{};
    for (int x = 0; x < Patch::padded(window_px); x += 8) {
      const unsigned char* row = corner.in(image) + x;
      Int16x8 upper = between_columns(row, u);
      for (int y0 = 0; y0 < window_px; y0 += kRows) {
        Int32x4 part_x{}, part_y{};
        for (int y = y0; y < std::min(y0 + kRows, window_px); ++y) {
          row += step;
          const Int16x8 lower = between_columns(row, u);
          const int at = patch.at(x, y);
          const Int16x8 off = between_rows(upper, lower, v) - load(patch.grey + at);
          part_x += pair_products(off, load(patch.dx + at));
          part_y += pair_products(off, load(patch.dy + at));
          upper = lower;
        }
        sum_x += to_float(part_x);
        sum_y += to_float(part_y);
      }
    }
    return {sum(sum_x) * Patch::kScale, sum(sum_y) * Patch::kScale};
  }

 private:
  /// Eight grey values interpolated between two neighbouring columns, times 64.
  static Int16x8 between_columns(const unsigned char* row, const Int16x8& u) {
    const Int16x8 left = load_bytes(row);
    const Int16x8 right = load_bytes(row + 1);
    return left * 64 + high_product((right - left) * 128, u);
  }
  /// Interpolates between two such rows, times 32.
  static Int16x8 between_rows(const Int16x8& upper, const Int16x8& lower, const Int16x8& v) {
    return (upper >> 1) + high_product(lower - upper, v);
  }

  /// Contribution of one row to Scharr's operator (3 10 3).
  struct Filtered {
    Int16x8 step[Patch::kMaxBands], smooth[Patch::kMaxBands];

    void set(const std::int16_t* row, int width) {
      // 3 fractional bits, so that 16 bits suffice.
      const auto rounded = [](const std::int16_t* p) { return (load(p) + all(2)) >> 2; };
      for (int x = 0; x < width; x += 8) {
        const Int16x8 left = rounded(row + x), right = rounded(row + x + 2);
        step[x / 8] = right - left;
        smooth[x / 8] = (left + right) * all(3) + rounded(row + x + 1) * all(10);
      }
    }
  };

  /// Gradients outside the image are set to 0, because the border only mirrors the image.
  /// Those pixels then have no weight.
  static void gradients(int window_px, int stride, const cv::Point& corner, const cv::Size& image,
                        Patch& patch) {
    Float32x4 xx{}, xy{}, yy{};
    const int first_row = -corner.y, last_row = image.height - corner.y;
    const int first_column = -corner.x, last_column = std::min(window_px, image.width - corner.x);
    const int width = Patch::padded(window_px);
    Filtered rows[3];
    rows[0].set(patch.around, width);
    rows[1].set(patch.around + stride, width);
    for (int y = 0; y < window_px; ++y) {
      const Filtered &upper = rows[y % 3], &middle = rows[(y + 1) % 3];
      Filtered& lower = rows[(y + 2) % 3];
      lower.set(patch.around + (y + 2) * stride, width);
      const bool row_inside = y >= first_row && y < last_row;
      for (int x = 0; x < width; x += 8) {
        const int band = x / 8, at = patch.at(x, y);
        const Int16x8 inside = row_inside ? columns(x, first_column, last_column) : Int16x8{};
        const Int16x8 across = (upper.step[band] + lower.step[band]) * all(3) + middle.step[band] * all(10);
        const Int16x8 along = lower.smooth[band] - upper.smooth[band];
        const Int16x8 dx = ((across + all(4)) >> 3) & inside, dy = ((along + all(4)) >> 3) & inside;
        store(patch.grey + at, load(patch.around + (y + 1) * stride + x + 1));
        store(patch.dx + at, dx);
        store(patch.dy + at, dy);
        xx += to_float(pair_products(dx, dx));
        xy += to_float(pair_products(dx, dy));
        yy += to_float(pair_products(dy, dy));
      }
    }
    patch.xx = sum(xx) * Patch::kScale;
    patch.xy = sum(xy) * Patch::kScale;
    patch.yy = sum(yy) * Patch::kScale;
  }

  /// All bits set where column x + lane is in [first, last).
  static Int16x8 columns(int x, int first, int last) {
    const Int16x8 column = Int16x8{0, 1, 2, 3, 4, 5, 6, 7} + all(x);
    return (column >= all(first)) & (column < all(last));
  }
};

}  // namespace dynfilter::detail
