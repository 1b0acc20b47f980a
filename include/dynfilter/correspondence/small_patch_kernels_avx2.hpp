// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/avx2.hpp>
#include <dynfilter/correspondence/small_patch_kernels.hpp>

#if defined(DYNFILTER_X86)
#include <cstddef>
#include <cstdint>
#include <dynfilter/correspondence/small_window.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::detail {

/// SmallPatchKernels with AVX2: a row of the patch is one vector. Results are identical, because all sums are
/// of integers.
struct SmallPatchKernelsAvx2 {
  static bool available() { return uses_avx2(); }

  DYNFILTER_AVX2 static void cut(const cv::Mat& image, int x, int y, int window_px, SmallPatch& patch) {
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    const __m256i in_window = columns(0, window_px);
    const __m256i in_image = _mm256_and_si256(columns(-x, image.cols - x), in_window);
    const __m256i none = _mm256_setzero_si256();
    __m256i sum_x = none, sum_y = none, xx = none, xy = none, yy = none, sum_grey = none, square = none;
    const unsigned char* row = pixel(image, x, y);
    Row upper(row - step), here(row);
    for (int r = 0; r < window_px; ++r) {
      row += step;
      const Row lower(row);
      const __m256i mask = y + r >= 0 && y + r < image.rows ? in_image : none;
      const __m256i dx = _mm256_and_si256(
          _mm256_add_epi16(_mm256_add_epi16(upper.step, lower.step), thrice(here.step)), mask);
      const __m256i dy = _mm256_and_si256(_mm256_sub_epi16(lower.smooth, upper.smooth), mask);
      const __m256i grey = _mm256_and_si256(_mm256_slli_epi16(here.middle, 3), in_window);
      const int at = r * SmallPatch::kColumns;
      avx2::store(patch.grey + at, grey);
      avx2::store(patch.dx + at, dx);
      avx2::store(patch.dy + at, dy);
      sum_x = _mm256_add_epi16(sum_x, dx);
      sum_y = _mm256_add_epi16(sum_y, dy);
      xx = _mm256_add_epi32(xx, _mm256_madd_epi16(dx, dx));
      xy = _mm256_add_epi32(xy, _mm256_madd_epi16(dx, dy));
      yy = _mm256_add_epi32(yy, _mm256_madd_epi16(dy, dy));
      sum_grey = _mm256_add_epi16(sum_grey, grey);
      square = _mm256_add_epi32(square, _mm256_madd_epi16(grey, grey));
      upper = here, here = lower;
    }
    const __m128i first = sums(in_pairs(sum_x), in_pairs(sum_y), in_pairs(sum_grey), square);
    const __m128i second = sums(xx, xy, yy, none);
    patch.x = _mm_cvtsi128_si32(first), patch.y = _mm_extract_epi32(first, 1);
    patch.sum = _mm_extract_epi32(first, 2), patch.square = _mm_extract_epi32(first, 3);
    patch.xx = _mm_cvtsi128_si32(second), patch.xy = _mm_extract_epi32(second, 1);
    patch.yy = _mm_extract_epi32(second, 2);
  }

  DYNFILTER_AVX2 static SmallPatchMismatch mismatch(const cv::Mat& image, const SmallCorner& corner,
                                                    int window_px, const SmallPatch& patch) {
    __m256i by_x = _mm256_setzero_si256(), by_y = by_x, all_of = by_x;
    Rows rows(image, corner, window_px);
    for (int at = 0; at < window_px * SmallPatch::kColumns; at += SmallPatch::kColumns) {
      const __m256i off = _mm256_sub_epi16(rows.next(), avx2::load(patch.grey + at));
      by_x = _mm256_add_epi32(by_x, _mm256_madd_epi16(off, avx2::load(patch.dx + at)));
      by_y = _mm256_add_epi32(by_y, _mm256_madd_epi16(off, avx2::load(patch.dy + at)));
      all_of = _mm256_add_epi16(all_of, off);
    }
    const __m128i s = sums(by_x, by_y, in_pairs(all_of), _mm256_setzero_si256());
    return {_mm_cvtsi128_si32(s), _mm_extract_epi32(s, 1), _mm_extract_epi32(s, 2)};
  }

  DYNFILTER_AVX2 static SmallPatchLikeness likeness(const cv::Mat& image, const SmallCorner& corner,
                                                    int window_px, const SmallPatch& patch) {
    __m256i all_of = _mm256_setzero_si256(), square = all_of, product = all_of;
    Rows rows(image, corner, window_px);
    for (int at = 0; at < window_px * SmallPatch::kColumns; at += SmallPatch::kColumns) {
      const __m256i grey = avx2::load(patch.grey + at);
      const __m256i off = _mm256_sub_epi16(rows.next(), grey);
      all_of = _mm256_add_epi16(all_of, off);
      square = _mm256_add_epi32(square, _mm256_madd_epi16(off, off));
      product = _mm256_add_epi32(product, _mm256_madd_epi16(off, grey));
    }
    const __m128i s = sums(in_pairs(all_of), square, product, _mm256_setzero_si256());
    return {_mm_cvtsi128_si32(s), _mm_extract_epi32(s, 1), _mm_extract_epi32(s, 2)};
  }

  DYNFILTER_AVX2 static SmallPatchDifference difference(const cv::Mat& image, int x, int y, int window_px,
                                                        const SmallPatch& patch) {
    const __m256i in_window = columns(0, window_px);
    const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
    const unsigned char* row = pixel(image, x, y);
    __m256i all_of = _mm256_setzero_si256(), square = all_of;
    for (int at = 0; at < window_px * SmallPatch::kColumns; at += SmallPatch::kColumns, row += step) {
      const __m256i value = _mm256_and_si256(_mm256_slli_epi16(avx2::load_bytes(row), 3), in_window);
      const __m256i off = _mm256_sub_epi16(value, avx2::load(patch.grey + at));
      all_of = _mm256_add_epi16(all_of, off);
      square = _mm256_add_epi32(square, _mm256_madd_epi16(off, off));
    }
    const __m128i s = sums(in_pairs(all_of), square, square, square);
    return {_mm_cvtsi128_si32(s), _mm_extract_epi32(s, 1)};
  }

 private:
  /// One row of the image: right - left neighbour, (1 3 1) along the row, and the row itself.
  struct Row {
    __m256i step, smooth, middle;
    DYNFILTER_AVX2 explicit Row(const unsigned char* at) : middle(avx2::load_bytes(at)) {
      const __m256i left = avx2::load_bytes(at - 1), right = avx2::load_bytes(at + 1);
      step = _mm256_sub_epi16(right, left);
      smooth = _mm256_add_epi16(_mm256_add_epi16(left, right), thrice(middle));
    }
  };
  DYNFILTER_AVX2 static __m256i thrice(const __m256i& v) {
    return _mm256_add_epi16(v, _mm256_add_epi16(v, v));
  }

  /// The window's rows between image rows, times SmallPatch::kGreyScale, from the top. 0 right of the window.
  struct Rows {
    DYNFILTER_AVX2 Rows(const cv::Mat& image, const SmallCorner& corner, int window_px)
        : u_(_mm256_set1_epi16(corner.u)),
          v_(_mm256_set1_epi16(corner.v)),
          in_window_(columns(0, window_px)),
          step_(static_cast<std::ptrdiff_t>(image.step[0])),
          row_(pixel(image, corner.x, corner.y)),
          upper_(between_columns(row_, u_)) {}
    DYNFILTER_AVX2 __m256i next() {
      row_ += step_;
      const __m256i lower = between_columns(row_, u_);
      const __m256i value = _mm256_add_epi16(_mm256_srai_epi16(upper_, 4),
                                             _mm256_mulhi_epi16(_mm256_sub_epi16(lower, upper_), v_));
      upper_ = lower;
      return _mm256_and_si256(value, in_window_);
    }

   private:
    __m256i u_, v_, in_window_;
    std::ptrdiff_t step_;
    const unsigned char* row_;
    __m256i upper_;
  };
  /// Sixteen grey values interpolated between two neighbouring columns, times 128.
  DYNFILTER_AVX2 static __m256i between_columns(const unsigned char* row, const __m256i& u) {
    const __m256i left = avx2::load_bytes(row), right = avx2::load_bytes(row + 1);
    return _mm256_add_epi16(_mm256_slli_epi16(left, 7), _mm256_mullo_epi16(_mm256_sub_epi16(right, left), u));
  }
  /// Sums of neighbouring lanes, which fit 16 bits only column by column (SmallPatch).
  DYNFILTER_AVX2 static __m256i in_pairs(const __m256i& v) {
    return _mm256_madd_epi16(v, _mm256_set1_epi16(1));
  }
  /// The sum of the lanes of each.
  DYNFILTER_AVX2 static __m128i sums(const __m256i& a, const __m256i& b, const __m256i& c, const __m256i& d) {
    const __m256i halves = _mm256_hadd_epi32(_mm256_hadd_epi32(a, b), _mm256_hadd_epi32(c, d));
    return _mm_add_epi32(_mm256_castsi256_si128(halves), _mm256_extracti128_si256(halves, 1));
  }
  /// All bits set where the lane is in [first, last).
  DYNFILTER_AVX2 static __m256i columns(int first, int last) {
    const __m256i lane = _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    return _mm256_andnot_si256(_mm256_cmpgt_epi16(_mm256_set1_epi16(static_cast<std::int16_t>(first)), lane),
                               _mm256_cmpgt_epi16(_mm256_set1_epi16(static_cast<std::int16_t>(last)), lane));
  }
};

}  // namespace dynfilter::detail

#else

namespace dynfilter::detail {

struct SmallPatchKernelsAvx2 : SmallPatchKernels {
  static bool available() { return false; }
};

}  // namespace dynfilter::detail

#endif
