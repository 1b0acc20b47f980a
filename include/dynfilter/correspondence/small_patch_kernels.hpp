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
    patch.x = patch.y = patch.xx = patch.xy = patch.yy = patch.sum = patch.square = 0;
    compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
      for (int first = 0; first < SmallPatch::kColumns; first += kLanes)
        cut_columns(image, x, y, first, window_px, patch);
    });
  }

  static SmallPatchMismatch mismatch(const cv::Mat& image, const SmallCorner& corner, int window_px,
                                     const SmallPatch& patch) {
    SmallPatchMismatch result;
    compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
      Pairs by_x{}, by_y{};
      result.sum = each_row(image, corner, window_px, patch,
                            [&](const Values& off, const Values& /*grey*/, int at) DYNFILTER_AS_CALLER {
                              by_x += pair_products<kLanes>(off, Values::load(patch.dx + at));
                              by_y += pair_products<kLanes>(off, Values::load(patch.dy + at));
                            });
      result.x = sum(by_x), result.y = sum(by_y);
    });
    return result;
  }

  static SmallPatchLikeness likeness(const cv::Mat& image, const SmallCorner& corner, int window_px,
                                     const SmallPatch& patch) {
    SmallPatchLikeness result;
    compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
      Pairs square{}, product{};
      result.sum = each_row(image, corner, window_px, patch,
                            [&](const Values& off, const Values& grey, int /*at*/) DYNFILTER_AS_CALLER {
                              square += pair_products<kLanes>(off, off);
                              product += pair_products<kLanes>(off, grey);
                            });
      result.square = sum(square), result.product = sum(product);
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

  DYNFILTER_AS_CALLER static void cut_columns(const cv::Mat& image, int x, int y, int first, int window_px,
                                              SmallPatch& patch) {
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    const Values in_window = columns(first, 0, window_px);
    const Values in_image = columns(first, -x, image.cols - x) & in_window;
    const unsigned char* row = pixel(image, x + first, y);
    Values sum_x{}, sum_y{}, sum_grey{};
    Pairs xx{}, xy{}, yy{}, square{};
    ImageRow upper(row - step), here(row);
    for (int r = 0; r < window_px; ++r) {
      row += step;
      const ImageRow lower(row);
      const bool inside = y + r >= 0 && y + r < image.rows;
      const Values mask = inside ? in_image : Values{};
      const Values dx = (upper.step + lower.step + here.step * all<kLanes>(3)) & mask;
      const Values dy = (lower.smooth - upper.smooth) & mask;
      const Values grey = (here.middle << kGreyBits) & in_window;
      const int at = r * SmallPatch::kColumns + first;
      grey.store(patch.grey + at);
      dx.store(patch.dx + at);
      dy.store(patch.dy + at);
      sum_x += dx, sum_y += dy, sum_grey += grey;
      xx += pair_products<kLanes>(dx, dx), xy += pair_products<kLanes>(dx, dy);
      yy += pair_products<kLanes>(dy, dy), square += pair_products<kLanes>(grey, grey);
      upper = here, here = lower;
    }
    patch.x += sum_of(sum_x), patch.y += sum_of(sum_y), patch.sum += sum_of(sum_grey);
    patch.xx += sum(xx), patch.xy += sum(xy), patch.yy += sum(yy), patch.square += sum(square);
  }

  /// Calls use(image - patch, patch, index) for kLanes pixels at a time. Returns the sum of image - patch.
  template <class Use>
  DYNFILTER_AS_CALLER static std::int32_t each_row(const cv::Mat& image, const SmallCorner& corner,
                                                   int window_px, const SmallPatch& patch, const Use& use) {
    std::int32_t all_of = 0;
    const Values u = all<kLanes>(corner.u), v = all<kLanes>(corner.v);
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    for (int first = 0; first < SmallPatch::kColumns; first += kLanes) {
      const Values in_window = columns(first, 0, window_px);
      const unsigned char* row = pixel(image, corner.x + first, corner.y);
      Values upper = between_columns(row, u), in_column{};
      for (int r = 0; r < window_px; ++r) {
        row += step;
        const Values lower = between_columns(row, u);
        const int at = r * SmallPatch::kColumns + first;
        const Values grey = Values::load(patch.grey + at);
        const Values value = (upper >> 4) + high_product<kLanes>(lower - upper, v);
        const Values off = (value & in_window) - grey;
        in_column += off;
        use(off, grey, at);
        upper = lower;
      }
      all_of += sum_of(in_column);
    }
    return all_of;
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
