// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/cluster/cell_grid.hpp>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

namespace detail {

void check_dbscan(const DbscanParams& params);

}  // namespace detail

/// DBSCAN (Ester et al. 1996) for 3-D points with a fixed radius. Uses a uniform grid whose cell diagonal is
/// the radius (Gunawan 2013). All points of a cell are neighbours, and a cell with `min_points` needs no
/// counting. Clusters are merged cell by cell. Core points and their clusters are exactly those of the
/// definition. A border point joins the cluster of its nearest core point. The result does not depend on the
/// order of the points, except for the numbering. Points that are not finite are noise. Cost: linear in the
/// number of points at constant density. Buffers are reused from call to call.
class GridDbscan {
 public:
  /// In any frame of reference [m]. Throws ConfigError if the radius or the count is out of range.
  void run(Span<const cv::Point3f> points, const DbscanParams& params, Clusters& out);

 private:
  using Run = detail::CellGrid::Run;
  using Rows = detail::CellGrid::Rows;
  struct Pair {
    std::uint32_t a, b;
    float d2;
  };

  /// Uses a list of all neighbours if the points are sparse, because it is cheaper than cells.
  bool run_on_pairs(Span<const cv::Point3f> points, const DbscanParams& params, Clusters& out);
  /// Ties between core points are decided by position, not by order.
  void offer_core(std::uint32_t border, std::uint32_t core, float d2);
  bool earlier(std::uint32_t a, std::uint32_t b) const;
  void mark_core(int min_points, Clusters& out) const;
  bool has_neighbours(const Rows& rows, std::uint32_t i, int min_points) const;

  /// Merges two cells if core points of both are within eps.
  void join_cells(const Clusters& clusters);
  Run core_of(std::uint32_t c) const;
  bool touch(Run a, Run b) const;

  struct Bounds {
    cv::Point3f low, high;
    float squared_distance(const cv::Point3f& p) const;
  };
  Bounds bounds(Run run) const;
  void label_core(Clusters& out);
  void label_border(Clusters& out) const;
  std::int32_t nearest_core_label(const Rows& rows, std::uint32_t i, const Clusters& clusters) const;

  detail::CellGrid grid_;
  detail::DisjointSets sets_;
  std::vector<std::uint32_t> core_count_;
  std::vector<Pair> pairs_;
  std::vector<std::uint32_t> neighbours_, nearest_;
  std::vector<float> nearest2_;
  float radius2_ = 0;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/cluster/detail/density_clusters-inl.hpp>
#endif
