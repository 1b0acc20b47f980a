// SPDX-License-Identifier: MIT
#pragma once

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/cluster/density_clusters.hpp>
#include <dynfilter/core/span.hpp>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

// <flann/flann.hpp> does not compile after <opencv2/opencv.hpp>.
// These headers compile in either order.

namespace dynfilter {

/// Neighbour search on FLANN's exact kd-tree. Link dynfilter::cluster to use it.
/// No other header includes FLANN.
class FlannNeighbours {
 public:
  /// Copies the points. Skips points that are not finite.
  void build(Span<const cv::Point3f> points);
  std::size_t size() const { return original_.size(); }

  /// Indices of all points within the radius, in no particular order.
  /// Empty if the query is not finite.
  void within(const cv::Point3f& query, double radius_m, std::vector<std::int32_t>& out);
  /// Squared distances to the k nearest points, nearest first.
  void nearest(const cv::Point3f& query, std::size_t k, std::vector<float>& squared_distances);

 private:
  using Index = flann::KDTreeSingleIndex<flann::L2_Simple<float>>;

  std::vector<cv::Point3f> points_;
  std::vector<float> values_;
  std::vector<std::int32_t> original_;
  std::unique_ptr<Index> index_;
  std::vector<std::vector<std::size_t>> indices_;
  std::vector<std::vector<float>> distances_;
};

/// DBSCAN on FLANN's neighbours, as published.
/// Gives the clusters of GridDbscan, three to four times slower.
void flann_dbscan(Span<const cv::Point3f> points, const DbscanParams& params, Clusters& out);

inline void FlannNeighbours::build(Span<const cv::Point3f> points) {
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

inline void FlannNeighbours::within(const cv::Point3f& query, double radius_m,
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

inline void FlannNeighbours::nearest(const cv::Point3f& query, std::size_t k,
                                     std::vector<float>& squared_distances) {
  squared_distances.clear();
  if (index_ == nullptr || k == 0 || !detail::finite(query)) return;
  float values[] = {query.x, query.y, query.z};
  index_->knnSearch(flann::Matrix<float>(values, 1, 3), indices_, distances_, k,
                    flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
  squared_distances.assign(distances_[0].begin(), distances_[0].end());
}

inline void flann_dbscan(Span<const cv::Point3f> points, const DbscanParams& params, Clusters& out) {
  detail::check_dbscan(params);
  FlannNeighbours tree;
  tree.build(points);
  dbscan_by_neighbours(
      points.size(), params.min_points,
      [&](std::size_t i, std::vector<std::int32_t>& found) { tree.within(points[i], params.eps_m, found); },
      out);
}

}  // namespace dynfilter
