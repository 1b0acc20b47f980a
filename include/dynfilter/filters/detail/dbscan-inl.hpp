// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/dbscan.hpp>

// <flann/flann.hpp> does not compile after <opencv2/opencv.hpp>. These headers compile in either order.
#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>
#include <algorithm>
#include <cmath>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/core/inline.hpp>
#include <limits>

namespace dynfilter {

namespace detail {

DYNFILTER_INLINE void NeighbourDistances::measure(Span<const cv::Point3f> points, std::size_t k) {
  static_assert(sizeof(cv::Point3f) == 3 * sizeof(float), "points are rows of a matrix");
  constexpr int kLeafPoints = 10;            // FLANN's default
  constexpr float kRoundingOfSums = -1e-5F;  // the search stays exact despite rounded bounds
  width_ = k + 1;
  squared_.assign(points.size() * width_, std::numeric_limits<float>::infinity());
  indices_.resize(squared_.size());
  // FLANN writes to neither points nor queries.
  const flann::Matrix<float> data(const_cast<float*>(&points[0].x), points.size(), 3);
  flann::KDTreeSingleIndex<flann::L2_Simple<float>> tree(data, flann::KDTreeSingleIndexParams(kLeafPoints));
  tree.buildIndex();
  flann::Matrix<std::size_t> indices(indices_.data(), points.size(), width_);
  flann::Matrix<float> squared(squared_.data(), points.size(), width_);
  tree.knnSearch(data, indices, squared, width_,
                 flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED, kRoundingOfSums));
}

}  // namespace detail

DYNFILTER_INLINE const FieldTable<DbscanFilterParams>& DbscanFilterParams::fields() {
  using P = DbscanFilterParams;
  static const FieldTable<P> table{
      real("eps_m", &P::eps_m, "m", {0.001, 100},
           "radius of the neighbourhood that must contain min_points (Eps)"),
      integer("min_points", &P::min_points, "features", {1, 100000},
              "dynamic features within eps_m that make a core point, itself included (MinPts)"),
      flag("adaptive", &P::adaptive,
           "choose eps_m and min_points from the first frame with enough dynamic features, and keep them "
           "until reset"),
  };
  return table;
}

DYNFILTER_INLINE void DbscanFilter::apply(const Evidence& evidence, Votes& votes) {
  collect(evidence);
  if (seeds_.empty()) return votes.note("no dynamic feature with depth");
  const DbscanParams params = parameters(votes);
  dbscan_.run(seeds_, params, clusters_);
  points_.clear();
  for (std::size_t k = 0; k < seeds_.size(); ++k)
    if (clusters_.core[k] != 0) points_.push_back(seeds_[k]);
  note(params, votes);
  if (!points_.empty()) extend(evidence, params.eps_m, votes);
}

inline void DbscanFilter::extend(const Evidence& evidence, double eps_m, Votes& votes) {
  const auto core = static_cast<std::uint32_t>(points_.size());
  judged_.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!evidence.judged(i)) continue;
    judged_.push_back(static_cast<std::uint32_t>(i));
    points_.push_back(evidence.points_m()[i]);
  }
  grid_.build(points_, eps_m * detail::kCellMargin, 1);
  core_count_.resize(grid_.cells());
  for (std::size_t c = 0; c < grid_.cells(); ++c)
    core_count_[c] = grid_.partition(c, [core](std::uint32_t index) { return index < core; });
  const float radius2 = detail::squared_radius(eps_m);
  detail::CellGrid::Rows rows(grid_, false);
  for (std::size_t c = 0; c < grid_.cells(); ++c) {
    rows.move_to(c);
    const detail::CellGrid::Run cell = grid_.cell(c);
    for (std::uint32_t place = cell.begin + core_count_[c]; place < cell.end; ++place) {
      const float nearest2 = nearest_core(place, rows, radius2);
      if (!std::isfinite(nearest2)) continue;
      // 1 at a core point, 0.5 at distance Eps.
      const double away = std::sqrt(static_cast<double>(nearest2)) / eps_m;
      votes.cast(judged_[grid_.index(place) - core], Vote::Dynamic, static_cast<float>(1 - 0.5 * away));
    }
  }
}

inline float DbscanFilter::nearest_core(std::uint32_t place, const detail::CellGrid::Rows& rows,
                                        float radius2) const {
  const cv::Point3f point = grid_.at(place);
  float nearest2 = std::numeric_limits<float>::infinity();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const detail::CellGrid::Run cells = rows.cells(r);
    for (std::uint32_t c = cells.begin; c < cells.end; ++c) {
      const std::uint32_t begin = grid_.cell(c).begin;
      for (std::uint32_t j = begin; j < begin + core_count_[c]; ++j)
        nearest2 = std::min(nearest2, detail::squared_distance(grid_.at(j), point));
    }
  }
  return nearest2 <= radius2 ? nearest2 : std::numeric_limits<float>::infinity();
}

inline void DbscanFilter::collect(const Evidence& evidence) {
  seeds_.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (evidence.called_dynamic(i) && detail::finite(evidence.points_m()[i]))
      seeds_.push_back(evidence.points_m()[i]);
}

inline DbscanParams DbscanFilter::parameters(Votes& votes) {
  if (params_.adaptive && !chosen_ && seeds_.size() >= static_cast<std::size_t>(params_.adaptive_min_points))
    choose(votes);
  return chosen_.value_or(DbscanParams{params_.eps_m, params_.min_points});
}

inline void DbscanFilter::choose(Votes& votes) {
  const AdaptiveDbscanChoice& choice = adaptive_.choose(seeds_);
  if (choice.found && choice.params.eps_m <= Params::kAdaptiveMaxEps_m)
    chosen_ = choice.params;
  else
    votes.note(choice.found ? "adaptive: the points are too far apart" : "adaptive: no stable count");
}

inline void DbscanFilter::note(const DbscanParams& params, Votes& votes) const {
  votes.note(clusters_.count, " objects of ", seeds_.size(), " features, eps ", fixed_text(params.eps_m, 3),
             " m, min_points ", params.min_points);
}

}  // namespace dynfilter
