// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Counts marked points within a radius, exactly, without a list of them.
/// A balanced kd-tree whose nodes know their bounds and their counts: a node that is all within the radius is
/// added as a whole. So the time does not grow with the number of neighbours.
/// Points that are not finite are never counted.
/// Cost: building O(n log n), a count O(log n) where points are few within the radius or all within it,
/// O(n^(2/3)) at worst. Rebuilding reuses memory.
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/neighbour_counts-inl.hpp>
#endif
