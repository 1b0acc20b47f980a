// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/neighbour_noise.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

DYNFILTER_INLINE std::optional<double> NeighbourNoise::scale(Span<const Miss> misses, float reach_px,
                                                             MissAxes axes) {
  places_.clear();
  for (const Miss& miss : misses) places_.push_back(miss.place_px);
  grid_.build_for_nearest(Span<const cv::Point2f>(places_), reach_px / 2);
  by_place_.clear();
  for (const std::int32_t i : grid_.entries()) by_place_.push_back(misses[static_cast<std::size_t>(i)]);
  differences_.clear();
  for (const Miss& miss : by_place_)
    if (const Miss* other = nearest(miss, reach_px)) compare(miss, *other);
  if (differences_.size() < kMinPairs) return std::nullopt;
  return std::sqrt(static_cast<double>(median_in_place(differences_)) / median_chi2(axes));
}

DYNFILTER_INLINE std::optional<double> NeighbourNoise::whole_scale(Span<const Miss> misses, float reach_px,
                                                                   MissAxes axes) {
  const std::optional<double> unshared = scale(misses, reach_px, axes);
  if (!unshared) return std::nullopt;
  differences_.clear();
  for (const Miss& miss : misses)
    differences_.push_back(miss.miss_px.dot(miss.miss_px) / (miss.predicted_px * miss.predicted_px));
  const double whole = std::sqrt(static_cast<double>(median_in_place(differences_)) / median_chi2(axes));
  return std::clamp(whole, *unshared, kMostShared * *unshared);
}

inline const Miss* NeighbourNoise::nearest(const Miss& miss, float reach_px) const {
  const float limit_m = kSameSurface * miss.depth_m;
  const Miss* best = nullptr;
  float best2 = reach_px * reach_px;
  const auto reach = [&] { return std::sqrt(static_cast<double>(best2)) * kRounding; };
  grid_.ranges_outwards(miss.place_px, reach(), [&](std::size_t begin, std::size_t end) {
    for (const Miss* other = by_place_.data() + begin; other != by_place_.data() + end; ++other) {
      const cv::Point2f apart = other->place_px - miss.place_px;
      const float apart2 = apart.dot(apart);
      if (apart2 > best2 || apart2 < kMinApart_px * kMinApart_px) continue;
      if (std::abs(other->depth_m - miss.depth_m) > limit_m) continue;
      if (apart2 == best2 && best != nullptr && !before(*other, *best)) continue;
      best2 = apart2;
      best = other;
    }
    return reach();
  });
  return best;
}

inline bool NeighbourNoise::before(const Miss& a, const Miss& b) {
  return a.place_px.y != b.place_px.y ? a.place_px.y < b.place_px.y : a.place_px.x < b.place_px.x;
}

inline void NeighbourNoise::compare(const Miss& a, const Miss& b) {
  const cv::Point2f d = a.miss_px - b.miss_px;
  differences_.push_back(d.dot(d) / (a.predicted_px * a.predicted_px + b.predicted_px * b.predicted_px));
}

}  // namespace dynfilter
