// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/cluster/flann_neighbours.hpp>

#include <dynfilter/cluster/density_clusters.hpp>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE void FlannNeighbours::build(Span<const cv::Point3f> points) {
  index_.reset();
  values_.clear();
  original_.clear();
  points_.assign(points.begin(), points.end());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!detail::finite(points[i])) continue;
    values_.insert(values_.end(), {points[i].x, points[i].y, points[i].z});
    original_.push_back(static_cast<std::int32_t>(i));
  }
  if (original_.empty()) return;
  const flann::Matrix<float> data(values_.data(), original_.size(), 3);
  index_ = std::make_unique<Index>(data, flann::KDTreeSingleIndexParams(10, true));
  index_->buildIndex();
}

DYNFILTER_INLINE void FlannNeighbours::within(const cv::Point3f& query, double radius_m,
                                              std::vector<std::int32_t>& out) {
  out.clear();
  if (index_ == nullptr || !detail::finite(query)) return;
  float values[] = {query.x, query.y, query.z};
  const float radius2 = detail::squared_radius(radius_m);
  flann::SearchParams search(flann::FLANN_CHECKS_UNLIMITED, 0, false);
  // FLANN excludes points at exactly its radius.
  index_->radiusSearch(flann::Matrix<float>(values, 1, 3), indices_, distances_, radius2 * 1.00001F, search);
  for (const std::size_t found : indices_[0])
    if (detail::squared_distance(points_[static_cast<std::size_t>(original_[found])], query) <= radius2)
      out.push_back(original_[found]);
}

DYNFILTER_INLINE void FlannNeighbours::nearest(const cv::Point3f& query, std::size_t k,
                                               std::vector<float>& squared_distances) {
  squared_distances.clear();
  if (index_ == nullptr || k == 0 || !detail::finite(query)) return;
  float values[] = {query.x, query.y, query.z};
  index_->knnSearch(flann::Matrix<float>(values, 1, 3), indices_, distances_, k,
                    flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
  squared_distances.assign(distances_[0].begin(), distances_[0].end());
}

DYNFILTER_INLINE void flann_dbscan(Span<const cv::Point3f> points, const DbscanParams& params,
                                   Clusters& out) {
  detail::check_dbscan(params);
  FlannNeighbours tree;
  tree.build(points);
  dbscan_by_neighbours(
      points.size(), params.min_points,
      [&](std::size_t i, std::vector<std::int32_t>& found) { tree.within(points[i], params.eps_m, found); },
      out);
}

}  // namespace dynfilter
