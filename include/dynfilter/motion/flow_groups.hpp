// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Groups of points with similar flow. Image neighbours with similar flow are linked. Each connected set is a
/// group (single linkage). The surface of one object forms one or a few groups. A group rarely crosses the
/// silhouette of a mover. Cost: about 0.15 ms for 1000 points with 6 neighbours.
class FlowGroups {
 public:
  /// `alike(i, j)` returns whether two flows are similar. It must be symmetric.
  template <class Alike>
  void build(const std::vector<cv::Point2d>& points, double radius_px, int neighbours, double least_px,
             const Alike& alike) {
    grid_.build_for_nearest(Span<const cv::Point2d>(points), static_cast<float>(radius_px / 2));
    near_.clear();
    linked_.clear();
    sets_.reset(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      grid_.nearest(points[i], {neighbours, radius_px, least_px, static_cast<int>(i)}, nearest_);
      for (const int j : nearest_) {
        near_.push(j);
        if (!alike(i, static_cast<std::size_t>(j))) continue;
        linked_.push(j);
        sets_.unite(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
      }
      near_.end_list();
      linked_.end_list();
    }
    collect(points.size());
  }

  /// The nearest points of i, and those of them with similar flow.
  Span<const int> near(std::size_t i) const { return near_[i]; }
  Span<const int> linked(std::size_t i) const { return linked_[i]; }  ///< those of them with similar flow
  /// Groups in the order of their first members. A single point is also a group.
  std::size_t size() const { return members_.size(); }
  Span<const int> group(std::size_t g) const { return members_[g]; }  ///< members of group g

 private:
  /// Lists one after the other in one array.
  class Lists {
   public:
    void clear() { entries_.clear(), ends_.clear(); }
    void push(int entry) { entries_.push_back(entry); }
    void end_list() { ends_.push_back(entries_.size()); }
    Span<const int> operator[](std::size_t list) const {
      const std::size_t begin = list == 0 ? 0 : ends_[list - 1];
      return {entries_.data() + begin, ends_[list] - begin};
    }

   private:
    std::vector<int> entries_;
    std::vector<std::size_t> ends_;
  };

  void collect(std::size_t points) {
    std::size_t groups = 0;
    number_.resize(points);  // the root of a set is its first point, and so comes before the others
    for (std::size_t i = 0; i < points; ++i) {
      const std::size_t root = sets_.find(static_cast<std::uint32_t>(i));
      number_[i] = root == i ? groups++ : number_[root];
    }
    members_.build(groups, points, [&](std::size_t i) { return number_[i]; });
  }

  PointGrid grid_;
  detail::DisjointSets sets_;
  Lists near_, linked_;
  CellLists members_;  ///< by the group's number
  std::vector<int> nearest_;
  std::vector<std::size_t> number_;
};

}  // namespace dynfilter
