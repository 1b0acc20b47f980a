// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/cluster/adaptive_dbscan.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE const AdaptiveDbscanChoice& AdaptiveDbscan::choose(Span<const cv::Point3f> points) {
  choice_ = AdaptiveDbscanChoice();
  thin_out(points);
  const int n = static_cast<int>(points_.size());
  const int last = std::min(limits_.max_k, n - 1);
  if (n < 4) return choice_;
  tree_.build(points_);
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
  tree_.for_each_neighbourhood(eps_m_.size() - 1, nearest2_, [&](const std::vector<float>& squared) {
    for (std::size_t k = 1; k < squared.size(); ++k) eps_m_[k] += std::sqrt(static_cast<double>(squared[k]));
  });
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
  grid_.build(points_, std::max(eps_m, DbscanParams::kMinEpsM) * 1.00001, 1);
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
