// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/cell_grid.hpp>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/cluster/kd_tree.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Limits of AdaptiveDbscan.
struct AdaptiveDbscanLimits {
  int max_k = 30;         ///< largest k that is tested
  int max_points = 2000;  ///< larger inputs are subsampled evenly, in the given order
};

/// Parameters and result for one k.
struct DbscanCandidate {
  double eps_m = 0;
  int min_points = 1;
  int clusters = 0;
};

/// Result of AdaptiveDbscan. `params` is valid only if `found`.
struct AdaptiveDbscanChoice {
  bool found = false;
  int k = 0;  ///< the selected k
  DbscanParams params;
  std::vector<DbscanCandidate> candidates;  ///< for k = 1, 2, ... up to the last k tested
};

/// Chooses DBSCAN's radius and count from the points (Zhou et al., section 3.2.2).
/// Eps_k is the mean distance to the k-th neighbour.
/// MinPts_k is the mean number of points within Eps_k, including the point, rounded up.
/// DBSCAN runs for k = 1, 2, ...
/// The third k of the first run of three equal, non-zero cluster counts is selected.
///
/// The n x n distance matrix of the paper is not built.
/// A kd-tree gives the k nearest neighbours, and one list of pairs within the largest Eps
/// gives the neighbours and clusters for every k.
/// If that list would be long, the pairs are searched again for each k.
/// Cost: O(n (log n + MinPts_k)).
class AdaptiveDbscan {
 public:
  explicit AdaptiveDbscan(const AdaptiveDbscanLimits& limits = AdaptiveDbscanLimits()) : limits_(limits) {}

  /// Not found if fewer than four points are finite or no run of three exists up to max_k.
  const AdaptiveDbscanChoice& choose(Span<const cv::Point3f> points);

 private:
  struct Pair {
    std::uint32_t a, b;
    float d2;
  };
  /// Includes distances of exactly Eps_k, as on lattices, despite rounding of the mean.
  static constexpr double kRounding = 1 + 1e-5;

  void thin_out(Span<const cv::Point3f> points);

  static bool usable(double eps_m) {
    return eps_m >= DbscanParams::kMinEpsM && eps_m <= DbscanParams::kMaxEpsM;
  }

  void measure_eps(int to);

  double largest_usable_eps_m() const;
  void collect_pairs(double eps_m);
  /// Counting sort of the pairs: those within Eps_1, then those that Eps_2 adds, and so on.
  void order_pairs();
  /// Calls f(a, b) with positions in the grid for each pair within Eps_k.
  template <class F>
  void for_each_pair(int k, const F& f) const;

  void try_k(int k);

  /// Counts the neighbours of each point. Returns their mean, rounded up.
  int count_neighbours(int k);
  int count_clusters(int k, std::uint32_t min_points);

  AdaptiveDbscanLimits limits_;
  AdaptiveDbscanChoice choice_;
  std::vector<cv::Point3f> points_;
  KdTree tree_;
  std::vector<float> nearest2_;
  std::vector<double> eps_m_;
  detail::CellGrid grid_;
  std::vector<Pair> pairs_, ordered_;
  std::vector<std::size_t> pairs_within_, next_;  ///< per k
  std::vector<std::uint16_t> first_k_;
  bool listed_ = true;
  std::vector<std::uint32_t> neighbours_;
  detail::DisjointSets sets_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/cluster/detail/adaptive_dbscan-inl.hpp>
#endif
