// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/motion/ground_plane.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

DYNFILTER_INLINE std::optional<GroundPlane> GroundPlaneFinder::find(const std::vector<GroundPoint>& points,
                                                                    const Options& options) {
  std::optional<GroundPlane> found;
  double best = 0;
  for (int k = -options.tilts; k <= options.tilts; ++k) {
    GroundPlane plane;
    plane.tilt = 0.02 * k;
    const double support = fit_scale(points, options, plane) * (1 - 0.02 * std::abs(k));
    if (!(support > best)) continue;
    best = support;
    found = plane;
  }
  return found;
}

inline double GroundPlaneFinder::fit_scale(const std::vector<GroundPoint>& points, const Options& options,
                                           GroundPlane& plane) {
  collect_ratios(points, options, plane);
  support_.resize(ratios_.size());
  double best = 0, sum = 0, total = 0;
  for (const Ratio& r : ratios_) total += r.weight;
  std::size_t end = 0;
  for (std::size_t i = 0; i < ratios_.size(); ++i) {
    for (; end < ratios_.size() && ratios_[end].value <= ratios_[i].value * options.window; ++end)
      sum += ratios_[end].weight;
    support_[i] = sum;
    best = std::max(best, sum);
    sum -= ratios_[i].weight;
  }
  if (best < options.min_support) return 0;
  std::size_t lowest = 0;
  while (support_[lowest] < options.share_of_best * best) ++lowest;
  std::size_t peak = lowest;
  for (std::size_t i = lowest;
       i < ratios_.size() && ratios_[i].value <= ratios_[lowest].value * options.window; ++i)
    if (support_[i] > support_[peak]) peak = i;
  if (support_[peak] < options.min_share * total || !recedes(peak, options)) return 0;
  plane.scale = weighted_median_from(peak);
  return support_[peak];
}

inline bool GroundPlaneFinder::recedes(std::size_t first, const Options& options) const {
  double weight = 0, sum = 0, squares = 0;
  for (std::size_t i = first; i < ratios_.size() && ratios_[i].value <= ratios_[first].value * options.window;
       ++i) {
    const Ratio& r = ratios_[i];
    weight += r.weight, sum += r.weight * r.log_below, squares += r.weight * r.log_below * r.log_below;
  }
  const double variance = squares / weight - (sum / weight) * (sum / weight);
  return variance > options.min_log_spread * options.min_log_spread;
}

inline void GroundPlaneFinder::collect_ratios(const std::vector<GroundPoint>& points, const Options& options,
                                              const GroundPlane& plane) {
  const auto is_below = [&](const GroundPoint& p) {
    return p.inverse_depth > 0 && plane.below(p.x, p.y) > options.min_below_px;
  };
  int cells = 0;
  for (const GroundPoint& p : points) cells = std::max(cells, p.cell + 1);
  in_cell_.assign(static_cast<std::size_t>(cells), 0);
  for (const GroundPoint& p : points)
    if (is_below(p)) ++in_cell_[static_cast<std::size_t>(p.cell)];
  ratios_.clear();
  for (const GroundPoint& p : points)
    if (is_below(p))
      ratios_.push_back({p.inverse_depth / plane.below(p.x, p.y),
                         1.0 / in_cell_[static_cast<std::size_t>(p.cell)],
                         portable::log(plane.below(p.x, p.y))});
  std::sort(ratios_.begin(), ratios_.end());
}

inline double GroundPlaneFinder::weighted_median_from(std::size_t first) const {
  double sum = 0;
  for (std::size_t i = first; i < ratios_.size(); ++i) {
    sum += ratios_[i].weight;
    if (sum >= support_[first] / 2) return ratios_[i].value;
  }
  return ratios_.back().value;
}

}  // namespace dynfilter
