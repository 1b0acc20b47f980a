// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/avx2.hpp>
#include <dynfilter/correspondence/patch_kernels.hpp>

#if defined(DYNFILTER_X86)
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

namespace dynfilter::detail {

/// PatchKernels with AVX2, two rows of eight pixels at a time.
/// Results are identical: integer sums do not depend on order,
/// and floats are added in the same order.
struct PatchKernelsAvx2 {
  static bool available() { return uses_avx2(); }

  DYNFILTER_AVX2 static void cut(const cv::Mat& image, const Corner& corner, int window_px, Patch& patch) {
    const int size = window_px + 2, rows = size + size % 2;
    const __m256i u = _mm256_set1_epi16(corner.u), v = _mm256_set1_epi16(corner.v);
    for (int x = 0; x < Patch::padded(size); x += 8) {
      Rows pixels(image, corner, x, size, u);
      for (int y = 0; y < size; y += 2) avx2::store(patch.around + x * rows + y * 8, pixels.next(v));
    }
    patch.rows = window_px + window_px % 2;
    gradients(window_px, {corner.x + 1, corner.y + 1}, image.size(), patch);
  }

  DYNFILTER_AVX2 static cv::Point2f mismatch(const cv::Mat& image, const Corner& corner, int window_px,
                                             const Patch& patch) {
    constexpr int kRows = 16;  // see PatchKernels
    const __m256i u = _mm256_set1_epi16(corner.u), v = _mm256_set1_epi16(corner.v);
    __m128 sum_x = _mm_setzero_ps(), sum_y = _mm_setzero_ps();
    for (int x = 0; x < Patch::padded(window_px); x += 8) {
      Rows rows(image, corner, x, window_px, u);
      for (int y0 = 0; y0 < window_px; y0 += kRows) {
        __m256i part_x = _mm256_setzero_si256(), part_y = part_x;
        for (int y = y0; y < std::min(y0 + kRows, window_px); y += 2) {
          const int at = patch.at(x, y);
          const __m256i off = _mm256_sub_epi16(rows.next(v), avx2::load(patch.grey + at));
          part_x = _mm256_add_epi32(part_x, _mm256_madd_epi16(off, avx2::load(patch.dx + at)));
          part_y = _mm256_add_epi32(part_y, _mm256_madd_epi16(off, avx2::load(patch.dy + at)));
        }
        sum_x = _mm_add_ps(sum_x, _mm_cvtepi32_ps(both_rows(part_x)));
        sum_y = _mm_add_ps(sum_y, _mm_cvtepi32_ps(both_rows(part_y)));
      }
    }
    return {sum(sum_x) * Patch::kScale, sum(sum_y) * Patch::kScale};
  }

 private:
  /// Rows 1 and 2, from `a` with rows 0 and 1 and `b` with rows 2 and 3.
  DYNFILTER_AVX2 static __m256i between(const __m256i& a, const __m256i& b) {
    return _mm256_permute2x128_si256(a, b, 0x21);
  }
  DYNFILTER_AVX2 static __m128i both_rows(const __m256i& v) {
    return _mm_add_epi32(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
  }
  DYNFILTER_AVX2 static float sum(const __m128& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

  /// Interpolated rows of a band of eight columns, from the top, two at a time.
  /// Reads only `count` rows and the row below them.
  struct Rows {
    DYNFILTER_AVX2 Rows(const cv::Mat& image, const Corner& corner, int x, int count, const __m256i& across)
        : u_(across),
          step_(static_cast<std::ptrdiff_t>(image.step[0])),
          pixels_(corner.in(image) + x),
          last_(pixels_ + step_ * count),
          pair_(read()) {}

    /// The next two rows, interpolated between image rows, times 32.
    DYNFILTER_AVX2 __m256i next(const __m256i& v) {
      const __m256i upper = pair_;
      pair_ = read();
      const __m256i lower = between(upper, pair_);
      return _mm256_add_epi16(_mm256_srai_epi16(upper, 1),
                              _mm256_mulhi_epi16(_mm256_sub_epi16(lower, upper), v));
    }

   private:
    /// Two rows, interpolated between image columns, times 64.
    DYNFILTER_AVX2 __m256i read() {
      const unsigned char* const upper = std::min(pixels_, last_);
      const unsigned char* const lower = std::min(pixels_ + step_, last_);
      pixels_ += 2 * step_;
      const __m256i left = bytes(upper, lower), right = bytes(upper + 1, lower + 1);
      return _mm256_add_epi16(_mm256_slli_epi16(left, 6),
                              _mm256_mulhi_epi16(_mm256_slli_epi16(_mm256_sub_epi16(right, left), 7), u_));
    }
    DYNFILTER_AVX2 static __m256i bytes(const unsigned char* upper, const unsigned char* lower) {
      const __m128i first = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(upper));
      const __m128i second = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(lower));
      return _mm256_cvtepu8_epi16(_mm_unpacklo_epi64(first, second));
    }

    __m256i u_;
    std::ptrdiff_t step_;
    const unsigned char *pixels_, *last_;
    __m256i pair_;
  };

  /// Contribution of two rows to Scharr's operator, and their middle values.
  struct Filtered {
    __m256i step[Patch::kMaxBands], smooth[Patch::kMaxBands], centre[Patch::kMaxBands];

    /// `pair` points to two rows of the first band. The next band starts `band` values later.
    DYNFILTER_AVX2 void set(const std::int16_t* pair, int band, int bands, int bands_around) {
      const __m256i three = _mm256_set1_epi16(3), ten = _mm256_set1_epi16(10);
      __m256i here = avx2::load(pair), left = rounded(here);
      for (int b = 0; b < bands; ++b) {
        if (b + 1 < bands_around) pair += band;  // otherwise these columns are masked
        const __m256i next = avx2::load(pair), after = rounded(next);
        const __m256i middle = _mm256_alignr_epi8(after, left, 2), right = _mm256_alignr_epi8(after, left, 4);
        step[b] = _mm256_sub_epi16(right, left);
        smooth[b] = _mm256_add_epi16(_mm256_mullo_epi16(_mm256_add_epi16(left, right), three),
                                     _mm256_mullo_epi16(middle, ten));
        centre[b] = _mm256_alignr_epi8(next, here, 2);
        here = next, left = after;
      }
    }
    DYNFILTER_AVX2 static __m256i rounded(const __m256i& v) {
      return _mm256_srai_epi16(_mm256_add_epi16(v, _mm256_set1_epi16(2)), 2);
    }
  };

  DYNFILTER_AVX2 static void gradients(int window_px, const cv::Point& corner, const cv::Size& image,
                                       Patch& patch) {
    const int size = window_px + 2, band = 8 * (size + size % 2);
    const int bands = Patch::padded(window_px) / 8, bands_around = Patch::padded(size) / 8;
    const int last_row = std::min(window_px, image.height - corner.y);
    const int last_column = std::min(window_px, image.width - corner.x);
    __m256i inside_columns[Patch::kMaxBands];
    for (int b = 0; b < bands; ++b) inside_columns[b] = columns_within(8 * b, -corner.x, last_column);
    Sums sums;
    Filtered rows[2];
    rows[0].set(patch.around, band, bands, bands_around);
    for (int y = 0; y < window_px; y += 2) {
      const Filtered& upper = rows[y / 2 % 2];
      Filtered& lower = rows[(y / 2 + 1) % 2];
      lower.set(patch.around + (y + 2) * 8, band, bands, bands_around);
      const __m256i inside_rows = rows_within(y, -corner.y, last_row);
      for (int b = 0; b < bands; ++b) {
        const int at = patch.at(8 * b, y);
        const __m256i inside = _mm256_and_si256(inside_rows, inside_columns[b]);
        const __m256i dx = _mm256_and_si256(scaled(across(upper.step[b], lower.step[b])), inside);
        const __m256i dy =
            _mm256_and_si256(scaled(_mm256_sub_epi16(lower.smooth[b], upper.smooth[b])), inside);
        avx2::store(patch.grey + at, between(upper.centre[b], lower.centre[b]));
        avx2::store(patch.dx + at, dx);
        avx2::store(patch.dy + at, dy);
        sums.keep(b, dx, dy);
      }
      sums.add(bands);
    }
    patch.xx = sum(sums.xx) * Patch::kScale;
    patch.xy = sum(sums.xy) * Patch::kScale;
    patch.yy = sum(sums.yy) * Patch::kScale;
  }
  DYNFILTER_AVX2 static __m256i across(const __m256i& upper, const __m256i& lower) {
    return _mm256_add_epi16(_mm256_mullo_epi16(_mm256_add_epi16(upper, lower), _mm256_set1_epi16(3)),
                            _mm256_mullo_epi16(between(upper, lower), _mm256_set1_epi16(10)));
  }
  DYNFILTER_AVX2 static __m256i scaled(const __m256i& gradient) {
    return _mm256_srai_epi16(_mm256_add_epi16(gradient, _mm256_set1_epi16(4)), 3);
  }

  /// Sums of products of gradients, added row by row like in PatchKernels.
  struct Sums {
    __m128 xx = __m128{}, xy = __m128{}, yy = __m128{};

    DYNFILTER_AVX2 void keep(int band, const __m256i& dx, const __m256i& dy) {
      kept_[0][band] = _mm256_cvtepi32_ps(_mm256_madd_epi16(dx, dx));
      kept_[1][band] = _mm256_cvtepi32_ps(_mm256_madd_epi16(dx, dy));
      kept_[2][band] = _mm256_cvtepi32_ps(_mm256_madd_epi16(dy, dy));
    }
    DYNFILTER_AVX2 void add(int bands) {
      for (int b = 0; b < bands; ++b) {
        xx = _mm_add_ps(xx, _mm256_castps256_ps128(kept_[0][b]));
        xy = _mm_add_ps(xy, _mm256_castps256_ps128(kept_[1][b]));
        yy = _mm_add_ps(yy, _mm256_castps256_ps128(kept_[2][b]));
      }
      for (int b = 0; b < bands; ++b) {
        xx = _mm_add_ps(xx, _mm256_extractf128_ps(kept_[0][b], 1));
        xy = _mm_add_ps(xy, _mm256_extractf128_ps(kept_[1][b], 1));
        yy = _mm_add_ps(yy, _mm256_extractf128_ps(kept_[2][b], 1));
      }
    }

   private:
    __m256 kept_[3][Patch::kMaxBands];
  };

  /// All bits set in the rows y and y + 1 that are in [first, last).
  DYNFILTER_AVX2 static __m256i rows_within(int y, int first, int last) {
    const auto row = [&](int k) { return _mm_set1_epi16(k >= first && k < last ? -1 : 0); };
    return _mm256_inserti128_si256(_mm256_castsi128_si256(row(y)), row(y + 1), 1);
  }
  /// All bits set where column x + lane is in [first, last), in both rows.
  DYNFILTER_AVX2 static __m256i columns_within(int x, int first, int last) {
    const __m128i column = _mm_add_epi16(_mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7), short_of(x));
    return _mm256_broadcastsi128_si256(
        _mm_andnot_si128(_mm_cmpgt_epi16(short_of(first), column), _mm_cmpgt_epi16(short_of(last), column)));
  }
  DYNFILTER_AVX2 static __m128i short_of(int value) {
    return _mm_set1_epi16(static_cast<std::int16_t>(value));
  }
};

}  // namespace dynfilter::detail

#else

namespace dynfilter::detail {

struct PatchKernelsAvx2 : PatchKernels {
  static bool available() { return false; }
};

}  // namespace dynfilter::detail

#endif
