// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/correspondence/small_window.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::detail {

/// The pixel loops of SmallPatch: with AVX2 a row of the patch is one vector (kLanes 16), else two (8).
/// Results are identical, because all sums are of integers.
template <int kLanes>
struct SmallPatchKernels {
  /// Fills `patch` with the window whose top left pixel is (x, y). Reads one pixel more each way, 16 columns.
  static void cut(const cv::Mat& image, int x, int y, int window_px, SmallPatch& patch) {
    patch.x = patch.y = patch.xx = patch.xy = patch.yy = 0;
    const bool inside = x >= 0 && y >= 0 && x + SmallPatch::kColumns <= image.cols &&
                        y + window_px <= image.rows && window_px == SmallPatch::kColumns;
    compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
      for (int first = 0; first < SmallPatch::kColumns; first += kLanes)
        inside ? cut_columns<true>(image, x, y, first, window_px, patch)
               : cut_columns<false>(image, x, y, first, window_px, patch);
    });
  }

  static SmallPatchMismatch mismatch(const cv::Mat& image, const SmallCorner& corner, int window_px,
                                     const SmallPatch& patch) {
    SmallPatchMismatch result;
    compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
      Pairs by_x{}, by_y{};
      for (int first = 0; first < SmallPatch::kColumns; first += kLanes) {
        Values all_of{};
        each_row(image, corner, first, window_px, [&](const Values& value, int at) DYNFILTER_AS_CALLER {
          const Values off = value - Values::load(patch.grey + at);
          all_of += off;
          by_x += pair_products<kLanes>(off, Values::load(patch.dx + at));
          by_y += pair_products<kLanes>(off, Values::load(patch.dy + at));
        });
        result.sum += sum_of(all_of & columns(first, 0, window_px));  // gradients are 0 beyond the window
      }
      result.x = sum(by_x), result.y = sum(by_y);
    });
    return result;
  }

  static SmallPatchLikeness likeness(const cv::Mat& image, const SmallCorner& corner, int window_px,
                                     const SmallPatch& patch) {
    SmallPatchLikeness result;
    compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
      Pairs patch2{}, image2{}, product{};
      for (int first = 0; first < SmallPatch::kColumns; first += kLanes) {
        const Values in_window = columns(first, 0, window_px);
        Values of_patch{}, of_image{};
        each_row(image, corner, first, window_px, [&](const Values& value, int at) DYNFILTER_AS_CALLER {
          const Values a = Values::load(patch.grey + at), b = value & in_window;
          of_patch += a, of_image += b;
          patch2 += pair_products<kLanes>(a, a), image2 += pair_products<kLanes>(b, b);
          product += pair_products<kLanes>(a, b);
        });
        result.patch += sum_of(of_patch), result.image += sum_of(of_image);
      }
      result.patch2 = sum(patch2), result.image2 = sum(image2), result.product = sum(product);
    });
    return result;
  }

  /// At the whole pixel (x, y).
  static SmallPatchDifference difference(const cv::Mat& image, int x, int y, int window_px,
                                         const SmallPatch& patch) {
    SmallPatchDifference result;
    compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
      const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
      Pairs square{};
      for (int first = 0; first < SmallPatch::kColumns; first += kLanes) {
        const Values in_window = columns(first, 0, window_px);
        const unsigned char* row = pixel(image, x + first, y);
        Values all_of{};
        for (int at = first; at < window_px * SmallPatch::kColumns; at += SmallPatch::kColumns, row += step) {
          const Values off =
              ((load_bytes<kLanes>(row) << kGreyBits) & in_window) - Values::load(patch.grey + at);
          all_of += off;
          square += pair_products<kLanes>(off, off);
        }
        result.sum += sum_of(all_of);
      }
      result.square = sum(square);
    });
    return result;
  }

 private:
  using Values = Shorts<kLanes>;
  using Pairs = PairSums<kLanes>;
  static constexpr int kGreyBits = 3;
  static_assert(SmallPatch::kGreyScale == 1 << kGreyBits);

  /// One row of the image: right - left neighbour, (1 3 1) along the row, and the row itself.
  struct ImageRow {
    Values step, smooth, middle;
    DYNFILTER_AS_CALLER explicit ImageRow(const unsigned char* at) : middle(load_bytes<kLanes>(at)) {
      const Values left = load_bytes<kLanes>(at - 1), right = load_bytes<kLanes>(at + 1);
      step = right - left;
      smooth = left + right + middle * all<kLanes>(3);
    }
  };

  /// `kInside`: all of 16 columns is, so nothing has to be left out.
  template <bool kInside>
  DYNFILTER_AS_CALLER static void cut_columns(const cv::Mat& image, int x, int y, int first, int window_px,
                                              SmallPatch& patch) {
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    const Values in_window = columns(first, 0, window_px);
    const Values in_image = columns(first, -x, image.cols - x) & in_window;
    const unsigned char* row = pixel(image, x + first, y);
    Values sum_x{}, sum_y{};
    Pairs xx{}, xy{}, yy{};
    const auto add_row = [&](ImageRow& upper, const ImageRow& here, int r) DYNFILTER_AS_CALLER {
      const ImageRow lower(row += step);
      Values dx = upper.step + lower.step + here.step * all<kLanes>(3), dy = lower.smooth - upper.smooth,
             grey = here.middle << kGreyBits;
      if constexpr (!kInside) {
        const bool in_rows = static_cast<unsigned>(y + r) < static_cast<unsigned>(image.rows);
        const Values mask = in_rows ? in_image : Values{};
        dx = dx & mask, dy = dy & mask, grey = grey & in_window;
      }
      const int at = r * SmallPatch::kColumns + first;
      grey.store(patch.grey + at);
      dx.store(patch.dx + at);
      dy.store(patch.dy + at);
      sum_x += dx, sum_y += dy;
      xx += pair_products<kLanes>(dx, dx), xy += pair_products<kLanes>(dx, dy);
      yy += pair_products<kLanes>(dy, dy);
      upper = lower;
    };
    ImageRow even(row - step), odd(row);  // the lower row takes the upper one's place: none is copied
    for (int r = 0; r < window_px; r += 2) {
      add_row(even, odd, r);
      if (r + 1 < window_px) add_row(odd, even, r + 1);
    }
    patch.x += sum_of(sum_x), patch.y += sum_of(sum_y);
    patch.xx += sum(xx), patch.xy += sum(xy), patch.yy += sum(yy);
  }

  /// Calls use(values, index in the patch) for each row of the image from column `first`.
  template <class Use>
  DYNFILTER_AS_CALLER static void each_row(const cv::Mat& image, const SmallCorner& corner, int first,
                                           int window_px, const Use& use) {
    const Values u = all<kLanes>(corner.u), v = all<kLanes>(corner.v);
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    const unsigned char* row = pixel(image, corner.x + first, corner.y);
    const auto next_row = [&](const Values& upper, Values& lower, int at) DYNFILTER_AS_CALLER {
      lower = between_columns(row += step, u);
      use((upper >> 4) + high_product<kLanes>(lower - upper, v), at);
    };
    Values even = between_columns(row, u), odd;
    const int end = window_px * SmallPatch::kColumns;
    for (int at = first; at < end; at += 2 * SmallPatch::kColumns) {
      next_row(even, odd, at);
      if (at + SmallPatch::kColumns < end) next_row(odd, even, at + SmallPatch::kColumns);
    }
  }
  /// Grey values interpolated between two neighbouring columns, times 128.
  DYNFILTER_AS_CALLER static Values between_columns(const unsigned char* row, const Values& u) {
    const Values left = load_bytes<kLanes>(row);
    return (left << 7) + (load_bytes<kLanes>(row + 1) - left) * u;
  }
  /// All bits set where column first_lane + lane is in [first, last).
  DYNFILTER_AS_CALLER static Values columns(int first_lane, int first, int last) {
    return within<kLanes>(Values::load(kColumn + first_lane), first, last);
  }
  DYNFILTER_AS_CALLER static std::int32_t sum_of(const Values& v) {
    return sum(pair_products<kLanes>(v, all<kLanes>(1)));
  }
  static constexpr std::int16_t kColumn[SmallPatch::kColumns] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                                 8, 9, 10, 11, 12, 13, 14, 15};
};

}  // namespace dynfilter::detail
