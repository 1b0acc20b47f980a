// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/neighbour_noise.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/lanes.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

DYNFILTER_INLINE std::optional<double> NeighbourNoise::scale(Span<const Miss> misses, float reach_px,
                                                             MissAxes axes) {
  places_.clear();
  for (const Miss& miss : misses) places_.push_back(miss.place_px);
  sort_into_cells(misses, reach_px);
  differences_.clear();
  for (std::size_t k = 0; k < misses.size(); ++k)
    if (const int other = nearest(misses, k, reach_px); other >= 0)
      compare(misses[k], misses[static_cast<std::size_t>(other)]);
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

inline void NeighbourNoise::sort_into_cells(Span<const Miss> misses, float reach_px) {
  grid_.build(Span<const cv::Point2f>(places_), reach_px);
  first_reach_px_ = reach_px;
  const double crowd = grid_.crowd();
  if (crowd > kCrowd) {
    first_reach_px_ = std::max(kLeastReach_px, reach_px * static_cast<float>(std::sqrt(kFew / crowd)));
    grid_.build(Span<const cv::Point2f>(places_), first_reach_px_);
  }
  lay_out(misses);
}

inline void NeighbourNoise::lay_out(Span<const Miss> misses) {
  const std::size_t n = grid_.entries().size();
  for (std::vector<float>* column : {&x_, &y_, &depth_m_}) column->resize(n + kLanes);
  for (std::size_t e = 0; e < n; ++e) {
    const Miss& miss = misses[static_cast<std::size_t>(grid_.entries()[e])];
    x_[e] = miss.place_px.x, y_[e] = miss.place_px.y, depth_m_[e] = miss.depth_m;
  }
}

inline NeighbourNoise::Four NeighbourNoise::load(const std::vector<float>& column, std::size_t at) {
  Four four;
  std::memcpy(&four, column.data() + at, sizeof four);
  return four;
}

inline int NeighbourNoise::nearest(Span<const Miss> misses, std::size_t k, float reach_px) const {
  for (float within_px = first_reach_px_; within_px < reach_px; within_px *= 2)
    if (const int found = nearest_within(misses, k, within_px); found >= 0) return found;
  return nearest_within(misses, k, reach_px);
}

inline int NeighbourNoise::nearest_within(Span<const Miss> misses, std::size_t k, float reach_px) const {
  const Miss& miss = misses[k];
  const float limit_m = kSameSurface * miss.depth_m;
  Four best2 = Four{} + reach_px * reach_px, best = Four{} - 1;
  Mask tie{};
  grid_.ranges_around(miss.place_px, reach_px, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; e += kLanes) {
      const Four dx = load(x_, e) - miss.place_px.x, dy = load(y_, e) - miss.place_px.y;
      const Four apart2 = dx * dx + dy * dy, deeper_m = load(depth_m_, e) - miss.depth_m;
      const Mask off = (apart2 > best2) | (apart2 < kMinApart_px * kMinApart_px) | (deeper_m > limit_m) |
                       (deeper_m < -limit_m) | (kLane >= static_cast<float>(end - e));
      tie |= ~off & (apart2 == best2);
      best2 = off ? best2 : apart2;
      best = off ? best : kLane + static_cast<float>(e);
    }
  });
  int lane = 0;
  for (int other = 1; other < static_cast<int>(kLanes); ++other) {
    if (best[other] >= 0 && best[lane] >= 0) tie[0] |= best2[other] == best2[lane] ? 1 : 0;
    lane = best2[other] < best2[lane] ? other : lane;
  }
  if ((tie[0] | tie[1] | tie[2] | tie[3]) != 0) return nearest_of_equals(misses, k, reach_px);
  return best[lane] < 0 ? -1 : grid_.entries()[static_cast<std::size_t>(best[lane])];
}

inline int NeighbourNoise::nearest_of_equals(Span<const Miss> misses, std::size_t k, float reach_px) const {
  const Miss& miss = misses[k];
  float best2 = reach_px * reach_px;
  int best = -1;
  grid_.around(miss.place_px, reach_px, [&](std::int32_t j) {
    const Miss& other = misses[static_cast<std::size_t>(j)];
    const cv::Point2f apart = other.place_px - miss.place_px;
    const float apart2 = apart.dot(apart);
    if (apart2 > best2 || apart2 < kMinApart_px * kMinApart_px) return;
    if (std::abs(other.depth_m - miss.depth_m) > kSameSurface * miss.depth_m) return;
    if (apart2 == best2 && best >= 0 && !before(other, misses[static_cast<std::size_t>(best)])) return;
    best2 = apart2;
    best = j;
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
