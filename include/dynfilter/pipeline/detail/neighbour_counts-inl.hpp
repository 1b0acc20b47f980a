// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/detail/neighbour_counts.hpp>

#include <algorithm>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE void NeighbourCounts::build(Span<const cv::Point3f> points) {
  items_.clear();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (detail::finite(points[i])) items_.push_back({points[i], static_cast<std::uint32_t>(i), {}});
  nodes_.clear();
  if (!items_.empty()) split(0, static_cast<std::uint32_t>(items_.size()));
}

inline std::uint32_t NeighbourCounts::split(std::uint32_t begin, std::uint32_t end) {
  const auto n = static_cast<std::uint32_t>(nodes_.size());
  Node node{begin, end, 0, items_[begin].point, items_[begin].point, {}};
  for (std::uint32_t i = begin; i < end; ++i) {
    const cv::Point3f& p = items_[i].point;
    node.low = {std::min(node.low.x, p.x), std::min(node.low.y, p.y), std::min(node.low.z, p.z)};
    node.high = {std::max(node.high.x, p.x), std::max(node.high.y, p.y), std::max(node.high.z, p.z)};
  }
  nodes_.push_back(node);
  if (end - begin <= kLeaf) return n;
  const cv::Point3f size = node.high - node.low;
  const auto axis = size.x >= size.y && size.x >= size.z ? &cv::Point3f::x
                    : size.y >= size.z                   ? &cv::Point3f::y
                                                         : &cv::Point3f::z;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end,
                   [axis](const Item& a, const Item& b) { return a.point.*axis < b.point.*axis; });
  split(begin, middle);
  nodes_[n].right = split(middle, end);
  return n;
}

DYNFILTER_INLINE void NeighbourCounts::add_up() {
  for (std::size_t n = nodes_.size(); n-- > 0;) {  // children come after their parents
    Node& node = nodes_[n];
    node.counts = Counts();
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) node.counts.add(items_[i].counts);
    } else {
      node.counts.add(nodes_[n + 1].counts);
      node.counts.add(nodes_[node.right].counts);
    }
  }
}

DYNFILTER_INLINE NeighbourCounts::Counts NeighbourCounts::around(const cv::Point3f& query,
                                                                 double radius_m) const {
  if (nodes_.empty() || !detail::finite(query)) return {};
  constexpr float kRounding = 1e-4F;  // of bounds: a point is compared exactly
  const float radius2 = detail::squared_radius(radius_m);
  Query q{query, radius2, radius2 * (1 - kRounding), radius2 * (1 + kRounding), {}};
  search(0, q);
  return q.found;
}

inline void NeighbourCounts::search(std::uint32_t n, Query& query) const {
  const Node& node = nodes_[n];
  const cv::Point3f& at = query.at;
  const cv::Point3f near(std::clamp(at.x, node.low.x, node.high.x), std::clamp(at.y, node.low.y, node.high.y),
                         std::clamp(at.z, node.low.z, node.high.z));
  if (detail::squared_distance(at, near) > query.surely_beyond2) return;
  const auto farther = [](float from, float low, float high) {
    return from - low > high - from ? low : high;
  };
  const cv::Point3f far(farther(at.x, node.low.x, node.high.x), farther(at.y, node.low.y, node.high.y),
                        farther(at.z, node.low.z, node.high.z));
  if (detail::squared_distance(at, far) <= query.surely_within2) return query.found.add(node.counts);
  if (node.right != 0) {
    search(n + 1, query);
    search(node.right, query);
    return;
  }
  for (std::uint32_t i = node.begin; i < node.end; ++i)
    if (detail::squared_distance(items_[i].point, at) <= query.radius2) query.found.add(items_[i].counts);
}

}  // namespace dynfilter
