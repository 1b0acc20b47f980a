// SPDX-License-Identifier: MIT
#pragma once

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/span.hpp>
#include <memory>
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/cluster/detail/flann_neighbours-inl.hpp>
#endif
