// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/cell_grid.hpp>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

namespace detail {

/// Distances of points to their nearest neighbours, by FLANN's exact kd-tree.
/// Cost: O(n (k + log n)). FLANN allocates its tree in every call.
class NeighbourDistances {
 public:
  /// Requires finite points, k < points.size().
  void measure(Span<const cv::Point3f> points, std::size_t k);
  /// Squared distances of point i to itself and its k nearest neighbours, nearest first.
  /// Infinite if they exceed the range of float.
  Span<const float> of(std::size_t i) const { return {squared_.data() + i * width_, width_}; }

 private:
  std::size_t width_ = 0;
  std::vector<float> squared_;
  std::vector<std::size_t> indices_;
};

}  // namespace detail

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

/// Chooses DBSCAN's radius and count from the points (Zhou et al., section 3.2.2). Eps_k is the mean distance
/// to the k-th neighbour. MinPts_k is the mean number of points within Eps_k, including the point, rounded
/// up. DBSCAN runs for k = 1, 2, ... The third k of the first run of three equal, non-zero cluster counts is
/// selected.
///
/// The n x n distance matrix of the paper is not built. FLANN gives the k nearest neighbours, and one list of
/// pairs within the largest Eps gives the neighbours and clusters for every k. If that list would be long,
/// the pairs are searched again for each k. Cost: O(n (log n + MinPts_k)).
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
  detail::NeighbourDistances distances_;
  std::vector<double> eps_m_;
  detail::CellGrid grid_;
  std::vector<Pair> pairs_, ordered_;
  std::vector<std::size_t> pairs_within_, next_;  ///< per k
  std::vector<std::uint16_t> first_k_;
  bool listed_ = true;
  std::vector<std::uint32_t> neighbours_;
  detail::DisjointSets sets_;
};

inline const AdaptiveDbscanChoice& AdaptiveDbscan::choose(Span<const cv::Point3f> points) {
  choice_ = AdaptiveDbscanChoice();
  thin_out(points);
  const int n = static_cast<int>(points_.size());
  const int last = std::min(limits_.max_k, n - 1);
  if (n < 4) return choice_;
  constexpr int kFirstBlock = 16;  // the run usually ends in the first block
  for (int from = 1; from <= last && !choice_.found; from = std::max(kFirstBlock, from) + 1) {
    const int to = from == 1 ? std::min(kFirstBlock, last) : last;
    measure_eps(to);
    collect_pairs(largest_usable_eps_m());
    for (int k = from; k <= to && !choice_.found; ++k) try_k(k);
    if (to == last) break;
  }
  return choice_;
}

inline void AdaptiveDbscan::thin_out(Span<const cv::Point3f> points) {
  points_.clear();
  for (const cv::Point3f& p : points)
    if (detail::finite(p)) points_.push_back(p);
  const std::size_t n = points_.size(), most = static_cast<std::size_t>(std::max(1, limits_.max_points));
  if (n <= most) return;
  for (std::size_t i = 0; i < most; ++i) points_[i] = points_[i * n / most];
  points_.resize(most);
}

inline void AdaptiveDbscan::measure_eps(int to) {
  eps_m_.assign(static_cast<std::size_t>(to) + 1, 0.0);
  distances_.measure(points_, static_cast<std::size_t>(to));
  for (std::size_t i = 0; i < points_.size(); ++i)
    for (std::size_t k = 1; k < eps_m_.size(); ++k)
      eps_m_[k] += std::sqrt(static_cast<double>(distances_.of(i)[k]));
  for (double& eps : eps_m_) eps *= kRounding / static_cast<double>(points_.size());
}

inline double AdaptiveDbscan::largest_usable_eps_m() const {
  double largest = 0;
  for (const double eps : eps_m_)
    if (usable(eps)) largest = std::max(largest, eps);
  return largest;
}

inline void AdaptiveDbscan::collect_pairs(double eps_m) {
  pairs_.clear();
  listed_ = true;
  grid_.build(points_, std::max(eps_m, DbscanParams::kMinEpsM) * detail::kCellMargin, 1);
  if (usable(eps_m)) listed_ = grid_.list_pairs(detail::squared_radius(eps_m), 400 * points_.size(), pairs_);
  order_pairs();
}

inline void AdaptiveDbscan::order_pairs() {
  const std::size_t count = eps_m_.size();
  pairs_within_.assign(count + 1, 0);
  first_k_.resize(pairs_.size());
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    std::size_t k = 1;
    for (std::size_t c = 1; c < count; ++c) k += pairs_[p].d2 > detail::squared_radius(eps_m_[c]) ? 1U : 0U;
    first_k_[p] = static_cast<std::uint16_t>(k);
    ++pairs_within_[k];
  }
  for (std::size_t k = 1; k <= count; ++k) pairs_within_[k] += pairs_within_[k - 1];
  next_.assign(pairs_within_.begin(), pairs_within_.end() - 1);
  ordered_.resize(pairs_.size());
  for (std::size_t p = 0; p < pairs_.size(); ++p) ordered_[next_[first_k_[p] - 1U]++] = pairs_[p];
}

template <class F>
void AdaptiveDbscan::for_each_pair(int k, const F& f) const {
  const auto at = static_cast<std::size_t>(k);
  if (!listed_) return grid_.for_each_pair(detail::squared_radius(eps_m_[at]), f);
  for (std::size_t p = 0; p < pairs_within_[at]; ++p) f(ordered_[p].a, ordered_[p].b);
}

inline void AdaptiveDbscan::try_k(int k) {
  DbscanCandidate candidate;
  candidate.eps_m = eps_m_[static_cast<std::size_t>(k)];
  if (usable(candidate.eps_m)) {
    candidate.min_points = count_neighbours(k);
    candidate.clusters = count_clusters(k, static_cast<std::uint32_t>(candidate.min_points));
  }
  auto& tried = choice_.candidates;
  tried.push_back(candidate);
  const std::size_t n = tried.size();
  if (n < 3 || candidate.clusters == 0 || tried[n - 2].clusters != candidate.clusters ||
      tried[n - 3].clusters != candidate.clusters)
    return;
  choice_.found = true;
  choice_.k = k;
  choice_.params = {candidate.eps_m, candidate.min_points};
}

inline int AdaptiveDbscan::count_neighbours(int k) {
  const std::size_t n = points_.size();
  neighbours_.assign(n, 1);
  std::size_t sum = n;
  for_each_pair(k, [&](std::uint32_t a, std::uint32_t b) {
    ++neighbours_[a];
    ++neighbours_[b];
    sum += 2;
  });
  return static_cast<int>((sum + n - 1) / n);
}

inline int AdaptiveDbscan::count_clusters(int k, std::uint32_t min_points) {
  sets_.reset(points_.size());
  int clusters = 0;
  for (const std::uint32_t n : neighbours_) clusters += n >= min_points ? 1 : 0;
  for_each_pair(k, [&](std::uint32_t a, std::uint32_t b) {
    if (neighbours_[a] >= min_points && neighbours_[b] >= min_points && sets_.unite(a, b)) --clusters;
  });
  return clusters;
}

}  // namespace dynfilter
