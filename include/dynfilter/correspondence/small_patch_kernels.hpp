// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/correspondence/short_vector.hpp>
#include <dynfilter/correspondence/small_window.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::detail {

/// The pixel loops of SmallPatch, eight pixels of a row at a time.
/// Uses instructions that every x86-64 and ARMv8 processor has.
struct SmallPatchKernels {
  /// Fills `patch` with the window whose top left pixel is (x, y). Reads one pixel more on every side, and 16
  /// columns.
  static void cut(const cv::Mat& image, int x, int y, int window_px, SmallPatch& patch) {
    patch.x = patch.y = patch.xx = patch.xy = patch.yy = patch.sum = patch.square = 0;
    for (int half = 0; half < SmallPatch::kColumns; half += 8) {
      Sums sums;
      cut_half(image, x, y, half, window_px, patch, sums);
      patch.x += sum(sums.x), patch.y += sum(sums.y);
      patch.xx += sum(sums.xx), patch.xy += sum(sums.xy), patch.yy += sum(sums.yy);
      patch.sum += sum(sums.grey), patch.square += sum(sums.square);
    }
  }

  static SmallPatchMismatch mismatch(const cv::Mat& image, const SmallCorner& corner, int window_px,
                                     const SmallPatch& patch) {
    Int32x4 by_x{}, by_y{};
    const std::int32_t all_of =
        each_row(image, corner, window_px, patch, [&](const Int16x8& off, const Int16x8& /*grey*/, int at) {
          by_x += pair_products(off, load(patch.dx + at));
          by_y += pair_products(off, load(patch.dy + at));
        });
    return {sum(by_x), sum(by_y), all_of};
  }

  static SmallPatchLikeness likeness(const cv::Mat& image, const SmallCorner& corner, int window_px,
                                     const SmallPatch& patch) {
    Int32x4 square{}, product{};
    const std::int32_t all_of =
        each_row(image, corner, window_px, patch, [&](const Int16x8& off, const Int16x8& grey, int /*at*/) {
          square += pair_products(off, off);
          product += pair_products(off, grey);
        });
    return {all_of, sum(square), sum(product)};
  }

  /// At the whole pixel (x, y).
  static SmallPatchDifference difference(const cv::Mat& image, int x, int y, int window_px,
                                         const SmallPatch& patch) {
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    Int16x8 all_of{};
    Int32x4 square{};
    SmallPatchDifference result;
    for (int half = 0; half < SmallPatch::kColumns; half += 8) {
      const Int16x8 in_window = columns(half, 0, window_px);
      const unsigned char* row = pixel(image, x + half, y);
      all_of = Int16x8{};
      for (int at = half; at < window_px * SmallPatch::kColumns; at += SmallPatch::kColumns, row += step) {
        const Int16x8 value = (load_bytes(row) * all(SmallPatch::kGreyScale)) & in_window;
        const Int16x8 off = value - load(patch.grey + at);
        all_of += off;
        square += pair_products(off, off);
      }
      result.sum += sum(all_of);
    }
    result.square = sum(square);
    return result;
  }

 private:
  struct Sums {
    Int16x8 x{}, y{}, grey{};
    Int32x4 xx{}, xy{}, yy{}, square{};
  };
  /// One row of the image: right - left neighbour, (1 3 1) along the row, and the row itself.
  struct Row {
    Int16x8 step, smooth, middle;
    explicit Row(const unsigned char* at) : middle(load_bytes(at)) {
      const Int16x8 left = load_bytes(at - 1), right = load_bytes(at + 1);
      step = right - left;
      smooth = left + right + middle * all(3);
    }
  };

  static void cut_half(const cv::Mat& image, int x, int y, int half, int window_px, SmallPatch& patch,
                       Sums& sums) {
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    const Int16x8 in_window = columns(half, 0, window_px);
    const Int16x8 in_image = columns(half, -x, image.cols - x) & in_window;
    const unsigned char* row = pixel(image, x + half, y);
    Row upper(row - step), here(row);
    for (int r = 0; r < window_px; ++r) {
      row += step;
      const Row lower(row);
      const bool inside = y + r >= 0 && y + r < image.rows;
      const Int16x8 mask = inside ? in_image : Int16x8{};
      const Int16x8 dx = (upper.step + lower.step + here.step * all(3)) & mask;
      const Int16x8 dy = (lower.smooth - upper.smooth) & mask;
      const Int16x8 grey = (here.middle * all(SmallPatch::kGreyScale)) & in_window;
      const int at = r * SmallPatch::kColumns + half;
      store(patch.grey + at, grey);
      store(patch.dx + at, dx);
      store(patch.dy + at, dy);
      sums.x += dx, sums.y += dy, sums.grey += grey;
      sums.xx += pair_products(dx, dx), sums.xy += pair_products(dx, dy), sums.yy += pair_products(dy, dy);
      sums.square += pair_products(grey, grey);
      upper = here, here = lower;
    }
  }

  /// Calls use(image - patch, patch, index) for eight pixels at a time. Returns the sum of image - patch.
  template <class Use>
  static std::int32_t each_row(const cv::Mat& image, const SmallCorner& corner, int window_px,
                               const SmallPatch& patch, const Use& use) {
    std::int32_t all_of = 0;
    const Int16x8 u = all(corner.u), v = all(corner.v);
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    for (int half = 0; half < SmallPatch::kColumns; half += 8) {
      const Int16x8 in_window = columns(half, 0, window_px);
      const unsigned char* row = pixel(image, corner.x + half, corner.y);
      Int16x8 upper = between_columns(row, u), in_column{};
      for (int r = 0; r < window_px; ++r) {
        row += step;
        const Int16x8 lower = between_columns(row, u);
        const int at = r * SmallPatch::kColumns + half;
        const Int16x8 grey = load(patch.grey + at);
        const Int16x8 value = (upper >> 4) + high_product(lower - upper, v);
        const Int16x8 off = (value & in_window) - grey;
        in_column += off;
        use(off, grey, at);
        upper = lower;
      }
      all_of += sum(in_column);
    }
    return all_of;
  }
  /// Eight grey values interpolated between two neighbouring columns, times 128.
  static Int16x8 between_columns(const unsigned char* row, const Int16x8& u) {
    const Int16x8 left = load_bytes(row);
    return left * all(128) + (load_bytes(row + 1) - left) * u;
  }
  /// All bits set where column first_lane + lane is in [first, last).
  static Int16x8 columns(int first_lane, int first, int last) {
    const Int16x8 column = Int16x8{0, 1, 2, 3, 4, 5, 6, 7} + all(first_lane);
    return (column >= all(first)) & (column < all(last));
  }
  static std::int32_t sum(const Int16x8& v) { return sum(pair_products(v, all(1))); }
  static std::int32_t sum(const Int32x4& v) { return v[0] + v[1] + v[2] + v[3]; }
};

}  // namespace dynfilter::detail
