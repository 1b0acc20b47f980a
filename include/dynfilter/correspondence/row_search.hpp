// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <dynfilter/core/simd.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {

/// Finds points of a left image in the rectified right image, on the same row.
///
/// The patch around the point is compared at every second disparity by the sum of absolute differences, then
/// beside the best one. The images' mean brightness may differ. From there the right patch must lead back to
/// the point. The rest f of the disparity b + f minimises
///   sum (L(x) - o - (1 - f) R(x - b) - f R(x - b - 1))^2,   f in [0, 1],
/// o an offset of the brightness. Not found is what has no texture along the row: f has a large deviation.
/// Nor is what the right camera does not see: the sum is large.
/// Sums are integers, the same on every processor. Cost: about 0.6 us per point and 128 px of disparity.
class RowSearch {
 public:
  /// Both CV_8UC1 and of one size, or empty. Refers to them.
  RowSearch(const cv::Mat& left, const cv::Mat& right) : RowSearch(left, right, left_brighter(left, right)) {}
  /// The same, where left_brighter() of the images is known.
  RowSearch(const cv::Mat& left, const cv::Mat& right, int left_brighter)
      : left_(left), right_(right), brighter_(left_brighter) {}
  /// On average [grey levels].
  static int left_brighter(const cv::Mat& left, const cv::Mat& right) {
    return right.empty() ? 0 : cvRound(cv::mean(left)[0] - cv::mean(right)[0]);
  }

  static constexpr int kMost_px = 128;  ///< disparity, a limit of cost
  /// Column in the right image of the point at `px` in the left one, less than `most_px` away. NaN: none.
  float column(const cv::Point2f& px, int most_px = kMost_px) const;

 private:
  static constexpr int kWidth = 16, kHeight = 9;   ///< of a patch [px]; 16 bytes are compared at once
  static constexpr int kLeft = 8, kAbove = 4;      ///< of them before its middle
  static constexpr int kBack_px = 1;               ///< tolerance of the way back
  static constexpr double kMostSigma_px = 0.25;    ///< of a disparity: DepthNoise assumes as much
  static constexpr double kMostUnexplained = 0.5;  ///< share of the patch's variance

  struct Patch {
    const std::uint8_t* first;
    std::size_t step;  ///< from row to row
    Patch at(std::ptrdiff_t columns) const { return {first + columns, step}; }
  };
  static Patch patch(const cv::Mat& image, int x, int y) {
    return {image.ptr<std::uint8_t>(y - kAbove) + x - kLeft, image.step};
  }
  /// Of the first rows only, where they differ by `enough`.
  static int difference(Patch a, Patch b, int enough);
  /// Steps in [0, most] that `to` must take in `direction` until it is like `from`, which is made darker.
  /// Patches worse than at `expected` are left early, so it changes the time only.
  static int nearest(Patch from, int darker, Patch to, int direction, int most, int expected);
  struct Part {
    double f = 0, squares = std::numeric_limits<double>::infinity(), sigma = squares, unexplained = squares;
  };
  template <int kLanes>
  DYNFILTER_AS_CALLER static Part between(Patch l,
                                          Patch r);  ///< the disparities b and b + 1, of patches at b

  const cv::Mat &left_, &right_;
  int brighter_;  ///< the left image, on average
};

inline float RowSearch::column(const cv::Point2f& px, int most_px) const {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const int last = left_.cols - (kWidth - kLeft);  // column of a patch
  if (!(px.x > kLeft && px.x < static_cast<float>(last) && px.y > kAbove)) return kNone;
  const int x = cvRound(px.x), y = cvRound(px.y);
  const int most = std::min({kMost_px, most_px, x - kLeft - 1});  // R(x - b - 1) is in the image
  if (x > last || y < kAbove || y + kHeight - kAbove > left_.rows || most < 1) return kNone;
  const Patch here = patch(left_, x, y);
  const int found = nearest(here, brighter_, patch(right_, x, y), -1, most, 0);
  const Patch there = patch(right_, x - found, y);
  const int back = nearest(there, -brighter_, patch(left_, x - found, y), 1,
                           std::min({kMost_px, most_px, last - (x - found)}), found);
  if (found == most || std::abs(back - found) > kBack_px) return kNone;
  const auto between = [&](Patch r) {
    return detail::call_widest([&](auto lanes)
                                   DYNFILTER_AS_CALLER { return RowSearch::between<2 * lanes()>(here, r); });
  };
  Part part = between(there);
  double disparity_px = found + part.f;
  if (found > 0) {
    const Part before = between(there.at(1));
    if (before.squares < part.squares) part = before, disparity_px = found - 1 + part.f;
  }
  if (part.sigma > kMostSigma_px || part.unexplained > kMostUnexplained) return kNone;
  return static_cast<float>(px.x - disparity_px);
}

inline int RowSearch::difference(Patch a, Patch b, int enough) {
  constexpr int kFirst = 4;  // rows after which most patches are left: with 3, more are not
  int sum = 0;
  const auto add = [&](int rows) {
    for (int row = 0; row < rows; ++row, a.first += a.step, b.first += b.step)
      for (int k = 0; k < kWidth; ++k) sum += std::abs(a.first[k] - b.first[k]);
  };
  add(kFirst);
  if (sum < enough) add(kHeight - kFirst);
  return sum;
}

inline int RowSearch::nearest(Patch from, int darker, Patch to, int direction, int most, int expected) {
  std::array<std::uint8_t, kWidth * kHeight> copy;
  std::uint8_t* to_row = copy.data();
  const auto darkest = static_cast<std::uint8_t>(std::clamp(darker, 0, 255)),
             brighter = static_cast<std::uint8_t>(std::clamp(-darker, 0, 255)),
             brightest = static_cast<std::uint8_t>(255 - brighter);
  for (int row = 0; row < kHeight; ++row, from.first += from.step, to_row += kWidth)
    for (int k = 0; k < kWidth; ++k) {  // bytes only, which saturate
      const auto dark = static_cast<std::uint8_t>(std::max(from.first[k], darkest) - darkest);
      to_row[k] = static_cast<std::uint8_t>(std::min(dark, brightest) + brighter);
    }
  from = {copy.data(), kWidth};
  constexpr int kAny = std::numeric_limits<int>::max();
  const int even_step = std::clamp(expected, 0, most) & ~1;
  int best = 0, least = difference(from, to.at(direction * even_step), kAny) + 1;  // so even_step may win
  const auto compare = [&](int step) {
    const int now = difference(from, to.at(direction * step), least);
    if (now < least) least = now, best = step;
  };
  for (int step = 0; step <= most; step += 2) compare(step);
  const int even = best;
  if (even > 0) compare(even - 1);
  if (even < most) compare(even + 1);
  return best;
}

template <int kLanes>
DYNFILTER_AS_CALLER inline RowSearch::Part RowSearch::between(Patch l, Patch r) {
  using namespace detail;
  constexpr double kCount = kWidth * kHeight;
  const auto load = [](const std::uint8_t* from) DYNFILTER_AS_CALLER { return load_bytes<kLanes>(from); };
  const Shorts<kLanes> one = all<kLanes>(1);
  PairSums<kLanes> l1{}, ll{}, u1{}, uu{}, w1{}, ww{}, uw{};
  for (int row = 0; row < kHeight; ++row, l.first += l.step, r.first += r.step)
    for (int k = 0; k < kWidth; k += kLanes) {
      const Shorts<kLanes> here = load(l.first + k), at = load(r.first + k), u = here - at,
                           w = load(r.first + k - 1) - at;
      l1 += pair_products(here, one), ll += pair_products(here, here), u1 += pair_products(u, one);
      uu += pair_products(u, u), w1 += pair_products(w, one), ww += pair_products(w, w);
      uw += pair_products(u, w);
    }
  const auto spread = [](int ab, int a, int b) { return ab - a * (b / kCount); };
  const double LL = spread(sum(ll), sum(l1), sum(l1)), UU = spread(sum(uu), sum(u1), sum(u1)),
               WW = spread(sum(ww), sum(w1), sum(w1)), UW = spread(sum(uw), sum(u1), sum(w1));
  Part part;
  if (!(WW > 0)) return part;
  part.f = std::clamp(UW / WW, 0.0, 1.0);
  part.squares = std::max(0.0, UU - part.f * (2 * UW - part.f * WW));
  part.sigma = std::sqrt(part.squares / (kCount - 2) / WW);
  part.unexplained = part.squares / std::max(1.0, LL);
  return part;
}

}  // namespace dynfilter
