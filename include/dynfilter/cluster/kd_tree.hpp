// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/span.hpp>
#include <limits>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Exact nearest neighbours among 3-D points of any distribution.
/// A balanced kd-tree over a copy of the points, in leaf order.
/// Points that are not finite are never found.
/// Cost: building O(n log n), a query O(k + log n). Rebuilding reuses memory.
class KdTree {
 public:
  struct Neighbour {
    float squared_distance = std::numeric_limits<float>::infinity();
    std::int32_t index = -1;  ///< -1: no neighbour

    /// By distance, then by index, so that the result does not depend on the tree.
    bool operator<(const Neighbour& o) const {
      return squared_distance != o.squared_distance ? squared_distance < o.squared_distance : index < o.index;
    }
  };

  void build(Span<const cv::Point3f> points);
  std::size_t size() const { return items_.size(); }

  /// The k nearest points, nearest first; fewer if the tree is smaller.
  /// A query at a point of the tree finds that point.
  void nearest(const cv::Point3f& query, std::size_t k, std::vector<Neighbour>& out) const;
  /// The nearest point if it is within the radius.
  Neighbour nearest_within(const cv::Point3f& query, double radius_m) const;
  /// Calls f(distances) for every point of the tree, in leaf order.
  /// `distances[j]` is the squared distance to its j-th nearest neighbour.
  /// j = 0 is the point itself.
  /// Requires k < size().
  /// Two to three times faster than separate queries,
  /// because the neighbours of the previous point bound the search.
  template <class F>
  void for_each_neighbourhood(std::size_t k, std::vector<float>& distances, const F& f) const {
    distances.resize(k + 1);
    for (std::size_t i = 0; i < items_.size(); ++i) {
      float bound2 = std::numeric_limits<float>::infinity();
      if (i > 0) {
        const double step =
            std::sqrt(static_cast<double>(detail::squared_distance(items_[i].point, items_[i - 1].point)));
        const double bound = (std::sqrt(static_cast<double>(distances[k])) + step) * 1.00001;
        bound2 = just_above(static_cast<float>(bound * bound));
      }
      std::fill(distances.begin(), distances.end(), bound2);
      Best<float> best{distances.data(), distances.data() + k};
      search_all(items_[i].point, best);
      f(distances);
    }
  }

 private:
  static constexpr std::uint32_t kLeaf = 8;

  struct Item {
    cv::Point3f point;
    std::int32_t index;
  };
  struct Node {
    std::uint32_t begin, end;  ///< items; a leaf has `right` 0
    std::uint32_t right;       ///< the left child follows its parent
    int axis;
    float cut;
  };
  /// Best candidates, sorted. A new candidate must be better than the last one.
  template <class T>
  struct Best {
    T *first, *last;

    float worst() const { return distance(*last); }
    void offer(float d2, std::int32_t index) const {
      if (d2 > worst()) return;
      const T found = made(d2, index, T());
      if (!(found < *last)) return;
      T* place = last;
      for (; place != first && found < place[-1]; --place) *place = place[-1];
      *place = found;
    }
    static float distance(float d2) { return d2; }
    static float distance(const Neighbour& n) { return n.squared_distance; }
    static float made(float d2, std::int32_t, float) { return d2; }
    static Neighbour made(float d2, std::int32_t index, const Neighbour&) { return {d2, index}; }
  };

  static float just_above(float v) { return std::nextafter(v, std::numeric_limits<float>::infinity()); }
  static float on_axis(const cv::Point3f& p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

  std::uint32_t split(std::uint32_t begin, std::uint32_t end);
  int widest_axis(std::uint32_t begin, std::uint32_t end) const;

  template <class T>
  void search_all(const cv::Point3f& query, const Best<T>& best) const {
    float offsets[3] = {0, 0, 0};
    search(0, query, 0, offsets, best);
  }
  /// `nearest2`: squared distance from the query to the node's cell, from the offsets per axis.
  template <class T>
  void search(std::uint32_t self, const cv::Point3f& query, float nearest2, float (&offsets)[3],
              const Best<T>& best) const {
    const Node& node = nodes_[self];
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        best.offer(detail::squared_distance(items_[i].point, query), items_[i].index);
      return;
    }
    const float side = on_axis(query, node.axis) - node.cut;
    const std::uint32_t left = self + 1;
    search(side < 0 ? left : node.right, query, nearest2, offsets, best);
    const float before = offsets[node.axis];
    const float beyond2 = nearest2 - before * before + side * side;
    // Tolerates the rounding of a sum of three squares, so that the search is exact.
    if (beyond2 * 0.99999F > best.worst()) return;
    offsets[node.axis] = side;
    search(side < 0 ? node.right : left, query, beyond2, offsets, best);
    offsets[node.axis] = before;
  }

  std::vector<Item> items_;
  std::vector<Node> nodes_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/cluster/detail/kd_tree-inl.hpp>
#endif
