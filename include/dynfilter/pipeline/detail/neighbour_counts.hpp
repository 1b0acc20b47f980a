// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// Counts marked points within a radius, exactly, without a list of them. A balanced kd-tree whose nodes know
/// their bounds and their counts: a node that is all within the radius is added as a whole. So the time does
/// not grow with the number of neighbours. Points that are not finite are never counted. Cost: building O(n
/// log n), a count O(log n) where points are few within the radius or all within it, O(n^(2/3)) at worst.
/// Rebuilding reuses memory.
class NeighbourCounts {
 public:
  /// How many points have each of two marks.
  struct Counts {
    int first = 0, second = 0;

    void add(const Counts& other) { first += other.first, second += other.second; }
  };

  void build(Span<const cv::Point3f> points);

  /// marks(index) gives the Counts of one point.
  template <class Marks>
  void mark(const Marks& marks) {
    for (Item& item : items_) item.counts = marks(item.index);
    add_up();
  }

  /// Counts of the points within the radius of `query`, one at the query's own position included.
  Counts around(const cv::Point3f& query, double radius_m) const;

 private:
  static constexpr std::uint32_t kLeaf = 8;

  struct Item {
    cv::Point3f point;
    std::uint32_t index;
    Counts counts;
  };
  struct Node {
    std::uint32_t begin, end, right;  ///< items; a leaf has `right` 0; the left child follows its parent
    cv::Point3f low, high;
    Counts counts;
  };
  struct Query {
    cv::Point3f at;
    float radius2, surely_within2, surely_beyond2;
    Counts found;
  };

  std::uint32_t split(std::uint32_t begin, std::uint32_t end);
  void add_up();
  void search(std::uint32_t n, Query& query) const;

  std::vector<Item> items_;
  std::vector<Node> nodes_;
};

inline void NeighbourCounts::build(Span<const cv::Point3f> points) {
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

inline void NeighbourCounts::add_up() {
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

inline NeighbourCounts::Counts NeighbourCounts::around(const cv::Point3f& query, double radius_m) const {
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
