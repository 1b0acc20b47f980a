// SPDX-License-Identifier: MIT
#pragma once

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>

#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/cluster/density_clusters.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

/// DBSCAN as published, on FLANN's radius search: a twin of GridDbscan, three to four times slower.
namespace dynfilter_test {

/// `neighbours(i, out)` fills `out` with the indices within the radius of point i, including i.
/// It returns none for a point that is excluded.
/// A border point joins the first cluster that reaches it.
template <class Neighbours>
void dbscan_by_neighbours(std::size_t n, int min_points, const Neighbours& neighbours,
                          dynfilter::Clusters& out) {
  dynfilter::detail::check_dbscan({1.0, min_points});
  out.reset(n);
  std::vector<std::uint8_t> seen(n, 0);
  std::vector<std::int32_t> found, open;
  for (std::size_t i = 0; i < n; ++i) {
    if (seen[i] != 0) continue;
    open.assign(1, static_cast<std::int32_t>(i));
    bool grown = false;
    while (!open.empty()) {
      const auto p = static_cast<std::size_t>(open.back());
      open.pop_back();
      if (seen[p] != 0) continue;
      seen[p] = 1;
      neighbours(p, found);
      if (found.size() < static_cast<std::size_t>(min_points)) continue;
      out.core[p] = 1;
      grown = true;
      for (const std::int32_t q : found) {
        if (out.label[static_cast<std::size_t>(q)] < 0) out.label[static_cast<std::size_t>(q)] = out.count;
        if (seen[static_cast<std::size_t>(q)] == 0) open.push_back(q);
      }
    }
    if (grown) ++out.count;
  }
  out.renumber(static_cast<std::size_t>(out.count));
}

inline void flann_dbscan(dynfilter::Span<const cv::Point3f> points, const dynfilter::DbscanParams& params,
                         dynfilter::Clusters& out) {
  using dynfilter::detail::squared_distance;
  dynfilter::detail::check_dbscan(params);
  std::vector<float> values;
  std::vector<std::int32_t> original;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!dynfilter::detail::finite(points[i])) continue;
    values.insert(values.end(), {points[i].x, points[i].y, points[i].z});
    original.push_back(static_cast<std::int32_t>(i));
  }
  flann::KDTreeSingleIndex<flann::L2_Simple<float>> index{flann::KDTreeSingleIndexParams(10, true)};
  if (!original.empty()) index.buildIndex(flann::Matrix<float>(values.data(), original.size(), 3));
  const float radius2 = dynfilter::detail::squared_radius(params.eps_m);
  const flann::SearchParams search(flann::FLANN_CHECKS_UNLIMITED, 0, false);
  std::vector<std::vector<std::size_t>> indices;
  std::vector<std::vector<float>> distances;
  const auto within = [&](std::size_t i, std::vector<std::int32_t>& found) {
    found.clear();
    if (!dynfilter::detail::finite(points[i])) return;
    float query[] = {points[i].x, points[i].y, points[i].z};
    // FLANN excludes points at exactly its radius.
    index.radiusSearch(flann::Matrix<float>(query, 1, 3), indices, distances, radius2 * 1.00001F, search);
    for (const std::size_t j : indices[0])
      if (squared_distance(points[static_cast<std::size_t>(original[j])], points[i]) <= radius2)
        found.push_back(original[j]);
  };
  dbscan_by_neighbours(points.size(), params.min_points, within, out);
}

}  // namespace dynfilter_test
