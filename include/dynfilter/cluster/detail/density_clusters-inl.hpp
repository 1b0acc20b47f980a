// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/cluster/density_clusters.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {

namespace detail {

DYNFILTER_INLINE void check_dbscan(const DbscanParams& params) {
  if (!(params.eps_m >= DbscanParams::kMinEpsM && params.eps_m <= DbscanParams::kMaxEpsM))
    throw ConfigError("eps_m", "expected 1e-06 to 1e+06");
  if (params.min_points < 1) throw ConfigError("min_points", "expected >= 1");
}

}  // namespace detail

DYNFILTER_INLINE void GridDbscan::run(Span<const cv::Point3f> points, const DbscanParams& params,
                                      Clusters& out) {
  detail::check_dbscan(params);
  out.reset(points.size());
  radius2_ = detail::squared_radius(params.eps_m);
  if (run_on_pairs(points, params, out)) return;
  // Slightly less than eps / sqrt(3): despite rounding, points of one cell are neighbours.
  constexpr double kDiagonal = 1.73207;
  grid_.build(points, params.eps_m / kDiagonal, 2);
  mark_core(params.min_points, out);
  join_cells(out);
  label_core(out);
  label_border(out);
  out.renumber(grid_.cells());
}

inline bool GridDbscan::run_on_pairs(Span<const cv::Point3f> points, const DbscanParams& params,
                                     Clusters& out) {
  constexpr std::size_t kTestsPerPoint = 100;
  grid_.build(points, params.eps_m * 1.00001, 1);
  const std::size_t n = grid_.points();
  if (!grid_.list_pairs(radius2_, kTestsPerPoint * n, pairs_)) return false;
  neighbours_.assign(n, 1);
  for (const Pair& pair : pairs_) ++neighbours_[pair.a], ++neighbours_[pair.b];
  const auto min_points = static_cast<std::uint32_t>(params.min_points);
  sets_.reset(n);
  nearest2_.assign(n, std::numeric_limits<float>::infinity());
  nearest_.resize(n);
  for (const Pair& pair : pairs_) {
    const bool a = neighbours_[pair.a] >= min_points, b = neighbours_[pair.b] >= min_points;
    if (a && b)
      sets_.unite(pair.a, pair.b);
    else if (a != b)
      offer_core(a ? pair.b : pair.a, a ? pair.a : pair.b, pair.d2);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool core = neighbours_[i] >= min_points;
    if (core || nearest2_[i] <= radius2_)
      out.label[grid_.index(i)] = static_cast<std::int32_t>(sets_.find(core ? i : nearest_[i]));
    out.core[grid_.index(i)] = core ? 1 : 0;
  }
  out.renumber(n);
  return true;
}

inline void GridDbscan::offer_core(std::uint32_t border, std::uint32_t core, float d2) {
  if (d2 > nearest2_[border]) return;
  if (d2 == nearest2_[border] && !earlier(core, nearest_[border])) return;
  nearest2_[border] = d2;
  nearest_[border] = core;
}

inline bool GridDbscan::earlier(std::uint32_t a, std::uint32_t b) const {
  const cv::Point3f p = grid_.at(a), q = grid_.at(b);
  return p.z != q.z ? p.z < q.z : p.y != q.y ? p.y < q.y : p.x < q.x;
}

inline void GridDbscan::mark_core(int min_points, Clusters& out) const {
  Rows rows(grid_, false);
  for (std::size_t c = 0; c < grid_.cells(); ++c) {
    const Run own = grid_.cell(c);
    const bool dense = own.end - own.begin >= static_cast<std::uint32_t>(min_points);
    if (!dense) rows.move_to(c);
    for (std::uint32_t i = own.begin; i < own.end; ++i)
      out.core[grid_.index(i)] = dense || has_neighbours(rows, i, min_points) ? 1 : 0;
  }
}

inline bool GridDbscan::has_neighbours(const Rows& rows, std::uint32_t i, int min_points) const {
  const cv::Point3f p = grid_.at(i);
  int n = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    n += grid_.count(rows.points(r), p, radius2_);
    if (n >= min_points) return true;
  }
  return false;
}

inline void GridDbscan::join_cells(const Clusters& clusters) {
  core_count_.resize(grid_.cells());
  for (std::size_t c = 0; c < grid_.cells(); ++c)
    core_count_[c] = grid_.partition(c, [&](std::uint32_t i) { return clusters.core[i] != 0; });
  sets_.reset(grid_.cells());
  Rows rows(grid_, true);
  for (std::uint32_t c = 0; c < grid_.cells(); ++c) {
    if (core_count_[c] == 0) continue;
    rows.move_to(c);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const Run others = rows.cells(r);
      for (std::uint32_t d = others.begin; d < others.end; ++d)
        if (core_count_[d] != 0 && sets_.find(c) != sets_.find(d) && touch(core_of(c), core_of(d)))
          sets_.unite(c, d);
    }
  }
}

inline GridDbscan::Run GridDbscan::core_of(std::uint32_t c) const {
  const std::uint32_t begin = grid_.cell(c).begin;
  return {begin, begin + core_count_[c]};
}

inline bool GridDbscan::touch(Run a, Run b) const {
  constexpr std::size_t kMany = 64;
  const bool many = std::size_t{a.end - a.begin} * (b.end - b.begin) > kMany;
  const Bounds around_b = many ? bounds(b) : Bounds();
  for (std::uint32_t i = a.begin; i < a.end; ++i) {
    const cv::Point3f p = grid_.at(i);
    if (many && around_b.squared_distance(p) > radius2_ * 1.0001F) continue;
    if (grid_.count(b, p, radius2_) > 0) return true;
  }
  return false;
}

inline float GridDbscan::Bounds::squared_distance(const cv::Point3f& p) const {
  const cv::Point3f nearest(std::clamp(p.x, low.x, high.x), std::clamp(p.y, low.y, high.y),
                            std::clamp(p.z, low.z, high.z));
  return detail::squared_distance(p, nearest);
}

inline GridDbscan::Bounds GridDbscan::bounds(Run run) const {
  Bounds b{grid_.at(run.begin), grid_.at(run.begin)};
  for (std::uint32_t i = run.begin; i < run.end; ++i) {
    const cv::Point3f p = grid_.at(i);
    b.low = {std::min(b.low.x, p.x), std::min(b.low.y, p.y), std::min(b.low.z, p.z)};
    b.high = {std::max(b.high.x, p.x), std::max(b.high.y, p.y), std::max(b.high.z, p.z)};
  }
  return b;
}

inline void GridDbscan::label_core(Clusters& out) {
  for (std::uint32_t c = 0; c < grid_.cells(); ++c) {
    const Run core = core_of(c);
    for (std::uint32_t i = core.begin; i < core.end; ++i)
      out.label[grid_.index(i)] = static_cast<std::int32_t>(sets_.find(c));
  }
}

inline void GridDbscan::label_border(Clusters& out) const {
  Rows rows(grid_, false);
  for (std::uint32_t c = 0; c < grid_.cells(); ++c) {
    const Run own = grid_.cell(c), core = core_of(c);
    if (core.end == own.end) continue;
    rows.move_to(c);
    for (std::uint32_t i = core.end; i < own.end; ++i)
      out.label[grid_.index(i)] = nearest_core_label(rows, i, out);
  }
}

inline std::int32_t GridDbscan::nearest_core_label(const Rows& rows, std::uint32_t i,
                                                   const Clusters& clusters) const {
  const cv::Point3f p = grid_.at(i);
  std::uint32_t best = i;
  float best2 = std::nextafter(radius2_, std::numeric_limits<float>::infinity());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Run run = rows.points(r);
    for (std::uint32_t j = run.begin; j < run.end; ++j) {
      const float d2 = detail::squared_distance(p, grid_.at(j));
      if (d2 > best2 || d2 > radius2_ || clusters.core[grid_.index(j)] == 0) continue;
      if (d2 == best2 && !earlier(j, best)) continue;
      best2 = d2;
      best = j;
    }
  }
  return best == i ? Clusters::kNoise : clusters.label[grid_.index(best)];
}

}  // namespace dynfilter
