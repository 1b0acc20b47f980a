// SPDX-License-Identifier: MIT
#include <dynfilter/cluster/flann_neighbours.hpp>

int clusters_of(const std::vector<cv::Point3f>& points) {
  dynfilter::Clusters clusters;
  dynfilter::flann_dbscan(points, dynfilter::DbscanParams(), clusters);
  return clusters.count;
}
