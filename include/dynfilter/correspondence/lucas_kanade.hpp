// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <dynfilter/correspondence/patch_kernels.hpp>
#include <dynfilter/correspondence/patch_spread.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <vector>

namespace dynfilter {

/// Pyramidal Lucas-Kanade (Bouguet 2000) with OpenCV's arithmetic and the same accuracy. It takes a third of
/// OpenCV's time with AVX2, and less than half without. It needs no derivative images, because gradients are
/// computed from the interpolated patch. Interpolation is separable, and no loop has a scalar remainder.
struct LucasKanade {
  int window_px = 21;
  int levels = 3;
  int max_iterations = 30;
  double epsilon_px = 0.01;
  double min_eigenvalue = 1e-4;
  bool wide = true;  ///< use 256-bit instructions where available, with identical results

  /// True if a patch, padded to whole vectors, fits in a border of one window around the image.
  static constexpr bool supports(int window_px) {
    return window_px <= Patch::kMaxWindow && Patch::padded(window_px + 2) + 2 - window_px / 2 <= window_px;
  }

  /// `from` and `to` are pyramids with a border of `window_px` around every level.
  /// Every `stride`-th image is one level. `to_px` contains the guesses on entry and the results on return.
  /// Points are tracked independently.
  void track(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to, std::size_t stride,
             const std::vector<cv::Point2f>& from_px, std::vector<cv::Point2f>& to_px,
             std::vector<std::uint8_t>& status, std::vector<MatchSpread>& spread) const;

 private:
  using Patch = detail::Patch;
  using Corner = detail::Corner;

  template <class Kernels>
  void track_points(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to, std::size_t stride,
                    int top, const std::vector<cv::Point2f>& from_px, std::vector<cv::Point2f>& to_px,
                    std::vector<std::uint8_t>& status, std::vector<MatchSpread>& spread) const;

  template <class Kernels>
  bool track_level(const cv::Mat& from, const cv::Mat& to, const cv::Point2f& from_px, Patch& patch,
                   cv::Point2f& at) const;

  /// True if `at` is close enough to the image for integer arithmetic. False for NaN.
  bool near(const cv::Point2f& at, const cv::Mat& image) const {
    const auto margin = static_cast<float>(window_px);
    return at.x >= -margin && at.y >= -margin && at.x <= static_cast<float>(image.cols) + margin &&
           at.y <= static_cast<float>(image.rows) + margin;
  }
};

inline void LucasKanade::track(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to,
                               std::size_t stride, const std::vector<cv::Point2f>& from_px,
                               std::vector<cv::Point2f>& to_px, std::vector<std::uint8_t>& status,
                               std::vector<MatchSpread>& spread) const {
  status.assign(from_px.size(), 0);
  spread.assign(from_px.size(), {});
  const auto count = static_cast<int>(std::min(from.size(), to.size()) / stride);
  const int top = std::min(levels, count - 1);
  if (top < 0 || !supports(window_px)) return;
  if (wide && uses_avx2())
    track_points<detail::PatchKernels<16>>(from, to, stride, top, from_px, to_px, status, spread);
  else
    track_points<detail::PatchKernels<8>>(from, to, stride, top, from_px, to_px, status, spread);
}

template <class Kernels>
void LucasKanade::track_points(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to,
                               std::size_t stride, int top, const std::vector<cv::Point2f>& from_px,
                               std::vector<cv::Point2f>& to_px, std::vector<std::uint8_t>& status,
                               std::vector<MatchSpread>& spread) const {
  const auto track_range = [&](const cv::Range& range) {
    Patch patch;
    for (int i = range.start; i < range.end; ++i) {
      const auto k = static_cast<std::size_t>(i);
      cv::Point2f at = to_px[k] * std::ldexp(1.0F, -top);
      for (int level = top; level >= 0; --level) {
        const auto l = static_cast<std::size_t>(level) * stride;
        if (level < top) at *= 2;
        const cv::Point2f start = from_px[k] * std::ldexp(1.0F, -level);
        status[k] = track_level<Kernels>(from[l], to[l], start, patch, at) ? 1 : 0;
      }
      spread[k] = PatchSpread::of(patch.xx, patch.xy, patch.yy);
      to_px[k] = at;
    }
  };
  cv::parallel_for_({0, static_cast<int>(from_px.size())}, detail::RangeBody(track_range),
                    static_cast<double>(from_px.size()) / 64);
}

template <class Kernels>
bool LucasKanade::track_level(const cv::Mat& from, const cv::Mat& to, const cv::Point2f& from_px,
                              Patch& patch, cv::Point2f& at) const {
  const float half = static_cast<float>(window_px - 1) * 0.5F;
  if (!near(from_px, from)) return false;
  const Corner corner(from_px - cv::Point2f(half + 1, half + 1));
  if (!corner.readable(from, window_px, window_px + 2)) return false;
  Kernels::cut(from, corner, window_px, patch);
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
    const cv::Point2f b = Kernels::mismatch(to, target, window_px, patch);
    const cv::Point2f step((patch.xy * b.y - patch.yy * b.x) / determinant,
                           (patch.xy * b.x - patch.xx * b.y) / determinant);
    at += step;
    if (step.dot(step) <= enough * enough) break;
    if (iteration > 0 && std::abs(step.x + previous.x) < 0.01F && std::abs(step.y + previous.y) < 0.01F) {
      at -= step * 0.5F;  // damps oscillation
      break;
    }
    previous = step;
  }
  return std::isfinite(at.x) && std::isfinite(at.y);
}

}  // namespace dynfilter
