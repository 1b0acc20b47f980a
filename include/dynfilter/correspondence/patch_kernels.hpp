// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/simd.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::detail {

/// The template patch of Lucas-Kanade. Holds grey values with 5 fractional bits, and 32 times their gradient.
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

/// The three pixel loops of Lucas-Kanade, eight pixels of a row at a time (kLanes 8) or of two rows with AVX2
/// (16). Results are identical: integer sums do not depend on order, and floats are added in the same order.
template <int kLanes>
struct PatchKernels {
  /// Fills `patch` from the image. `corner` is one pixel left of and above the window.
  static void cut(const cv::Mat& image, const Corner& corner, int window_px, Patch& patch) {
    compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
      const int size = window_px + 2, rows = size + size % 2;
      const Values u = all<kLanes>(corner.u), v = all<kLanes>(corner.v);
      for (int x = 0; x < Patch::padded(size); x += 8) {
        Rows pixels(image, corner, x, size, u);
        for (int y = 0; y < size; y += kRows) pixels.next(v).store(patch.around + x * rows + y * 8);
      }
      patch.rows = window_px + window_px % 2;
      gradients(window_px, {corner.x + 1, corner.y + 1}, image.size(), patch);
    });
  }

  /// Sums of (target - patch) times the patch's gradients.
  static cv::Point2f mismatch(const cv::Mat& image, const Corner& corner, int window_px, const Patch& patch) {
    constexpr int kRowsAtOnce = 16;  // products are below 2^27, so 16 of them fit 32 bits
    cv::Point2f result;
    compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
      const Values u = all<kLanes>(corner.u), v = all<kLanes>(corner.v);
      Float4 sum_x{}, sum_y{};
      for (int x = 0; x < Patch::padded(window_px); x += 8) {
        Rows rows(image, corner, x, window_px, u);
        for (int y0 = 0; y0 < window_px; y0 += kRowsAtOnce) {
          PairSums<kLanes> part_x{}, part_y{};
          for (int y = y0; y < std::min(y0 + kRowsAtOnce, window_px); y += kRows) {
            const int at = patch.at(x, y);
            const Values off = rows.next(v) - Values::load(patch.grey + at);
            part_x += pair_products<kLanes>(off, Values::load(patch.dx + at));
            part_y += pair_products<kLanes>(off, Values::load(patch.dy + at));
          }
          sum_x += __builtin_convertvector(in_four(part_x), Float4);
          sum_y += __builtin_convertvector(in_four(part_y), Float4);
        }
      }
      result = {sum(sum_x) * Patch::kScale, sum(sum_y) * Patch::kScale};
    });
    return result;
  }

 private:
  using Values = Shorts<kLanes>;
  static constexpr int kRows = kLanes / 8;

  DYNFILTER_AS_CALLER static float sum(const Float4& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

  /// Interpolated rows of a band of eight columns, from the top, kRows at a time.
  /// Reads only `count` rows and the row below them.
  struct Rows {
    DYNFILTER_AS_CALLER Rows(const cv::Mat& image, const Corner& corner, int x, int count,
                             const Values& across)
        : u_(across),
          step_(static_cast<std::ptrdiff_t>(image.step[0])),
          pixels_(corner.in(image) + x),
          last_(pixels_ + step_ * count),
          rows_(read()) {}

    /// The next rows, interpolated between image rows, times 32.
    DYNFILTER_AS_CALLER Values next(const Values& v) {
      const Values upper = rows_;
      rows_ = read();
      return (upper >> 1) + high_product<kLanes>(next_row<kLanes>(upper, rows_) - upper, v);
    }

   private:
    /// Rows interpolated between image columns, times 64.
    DYNFILTER_AS_CALLER Values read() {
      const unsigned char* const upper = std::min(pixels_, last_);
      const unsigned char* const lower = std::min(pixels_ + step_, last_);
      pixels_ += kRows * step_;
      const Values left = load_rows<kLanes>(upper, lower), right = load_rows<kLanes>(upper + 1, lower + 1);
      return (left << 6) + high_product<kLanes>((right - left) << 7, u_);
    }

    Values u_;
    std::ptrdiff_t step_;
    const unsigned char *pixels_, *last_;
    Values rows_;
  };

  /// Contribution of rows to Scharr's operator (3 10 3), and their middle values.
  struct Filtered {
    Values step[Patch::kMaxBands], smooth[Patch::kMaxBands], centre[Patch::kMaxBands];

    /// `row` points to the first band. The next band starts `band` values later.
    DYNFILTER_AS_CALLER void set(const std::int16_t* row, int band, int bands, int bands_around) {
      Values here = Values::load(row), left = rounded(here);
      for (int b = 0; b < bands; ++b) {
        if (b + 1 < bands_around) row += band;  // otherwise these columns are masked
        const Values next = Values::load(row), after = rounded(next);
        const Values middle = next_columns<1, kLanes>(left, after),
                     right = next_columns<2, kLanes>(left, after);
        step[b] = right - left;
        smooth[b] = (left + right) * all<kLanes>(3) + middle * all<kLanes>(10);
        centre[b] = next_columns<1, kLanes>(here, next);
        here = next, left = after;
      }
    }
    /// 3 fractional bits, so that 16 bits suffice.
    DYNFILTER_AS_CALLER static Values rounded(const Values& v) { return (v + all<kLanes>(2)) >> 2; }
  };

  /// Gradients outside the image are set to 0, because the border only mirrors the image.
  /// Those pixels then have no weight.
  DYNFILTER_AS_CALLER static void gradients(int window_px, const cv::Point& corner, const cv::Size& image,
                                            Patch& patch) {
    constexpr int kHeld = 2 / kRows + 1;  // of three rows, or of four
    const int size = window_px + 2, band = 8 * (size + size % 2);
    const int bands = Patch::padded(window_px) / 8, bands_around = Patch::padded(size) / 8;
    const int last_row = std::min(window_px, image.height - corner.y);
    const int last_column = std::min(window_px, image.width - corner.x);
    Values inside_columns[Patch::kMaxBands];
    for (int b = 0; b < bands; ++b) inside_columns[b] = lanes_within(kColumn, 8 * b, -corner.x, last_column);
    Sums sums;
    Filtered rows[static_cast<std::size_t>(kHeld)];
    for (int k = 0; k + 1 < kHeld; ++k) rows[k].set(patch.around + k * 8, band, bands, bands_around);
    for (int y = 0, k = 0; y < window_px; y += kRows, ++k) {
      const Filtered &upper = rows[k % kHeld], &middle = rows[(k + 1) % kHeld];
      Filtered& lower = rows[(k + kHeld - 1) % kHeld];
      lower.set(patch.around + (y + 2) * 8, band, bands, bands_around);
      const Values inside_rows = lanes_within(kRow, y, -corner.y, last_row);
      for (int b = 0; b < bands; ++b) {
        const int at = patch.at(8 * b, y);
        const Values inside = inside_rows & inside_columns[b];
        const Values across = (upper.step[b] + lower.step[b]) * all<kLanes>(3) +
                              next_row<kLanes>(upper.step[b], middle.step[b]) * all<kLanes>(10);
        const Values dx = ((across + all<kLanes>(4)) >> 3) & inside;
        const Values dy = ((lower.smooth[b] - upper.smooth[b] + all<kLanes>(4)) >> 3) & inside;
        next_row<kLanes>(upper.centre[b], middle.centre[b]).store(patch.grey + at);
        dx.store(patch.dx + at);
        dy.store(patch.dy + at);
        sums.keep(b, dx, dy);
      }
      sums.add(bands);
    }
    patch.xx = sum(sums.xx) * Patch::kScale;
    patch.xy = sum(sums.xy) * Patch::kScale;
    patch.yy = sum(sums.yy) * Patch::kScale;
  }

  /// Sums of products of gradients, added row by row.
  struct Sums {
    Float4 xx{}, xy{}, yy{};

    DYNFILTER_AS_CALLER void keep(int band, const Values& dx, const Values& dy) {
      pair_products<kLanes>(dx, dx).store(kept_[0][band]);
      pair_products<kLanes>(dx, dy).store(kept_[1][band]);
      pair_products<kLanes>(dy, dy).store(kept_[2][band]);
    }
    DYNFILTER_AS_CALLER void add(int bands) {
      for (int row = 0; row < kRows; ++row)
        for (int b = 0; b < bands; ++b) {
          xx += kept(0, b, row);
          xy += kept(1, b, row);
          yy += kept(2, b, row);
        }
    }

   private:
    DYNFILTER_AS_CALLER Float4 kept(int k, int band, int row) const {
      Int4 four;
      load_lane(&kept_[k][band][4 * row], four);
      return __builtin_convertvector(four, Float4);
    }
    std::int32_t kept_[3][Patch::kMaxBands][static_cast<std::size_t>(4 * kRows)];
  };

  static constexpr std::int16_t kColumn[16] = {0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7};
  static constexpr std::int16_t kRow[16] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1};
  /// All bits set where the lane's column or row, from `start` on, is in [first, last).
  DYNFILTER_AS_CALLER static Values lanes_within(const std::int16_t* lanes, int start, int first, int last) {
    return within<kLanes>(Values::load(lanes) + all<kLanes>(start), first, last);
  }
};

}  // namespace dynfilter::detail
