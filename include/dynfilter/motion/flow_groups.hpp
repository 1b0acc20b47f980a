// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/image_neighbours.hpp>
#include <vector>

namespace dynfilter {

/// Groups of points with similar flow.
/// Image neighbours with similar flow are linked.
/// Each connected set is a group (single linkage).
/// The surface of one object forms one or a few groups.
/// A group rarely crosses the silhouette of a mover.
/// Cost: about 0.15 ms for 1000 points with 6 neighbours.
class FlowGroups {
 public:
  /// `alike(i, j)` returns whether two flows are similar. It must be symmetric.
  template <class Alike>
  void build(const std::vector<ImageNeighbours::Point>& points, double radius_px, int neighbours,
             double least_px, const Alike& alike) {
    const std::size_t n = points.size();
    grid_.build(points, radius_px);
    near_.clear();
    linked_.clear();
    parent_.resize(n);
    for (std::size_t i = 0; i < n; ++i) parent_[i] = static_cast<int>(i);
    for (std::size_t i = 0; i < n; ++i) {
      grid_.nearest(points[i].x, points[i].y, static_cast<int>(i), neighbours, nearest_, least_px);
      for (const int j : nearest_) {
        near_.push(j);
        if (!alike(i, static_cast<std::size_t>(j))) continue;
        linked_.push(j);
        join(static_cast<int>(i), j);
      }
      near_.end_list();
      linked_.end_list();
    }
    collect();
  }

  /// The nearest points of i, and those of them with similar flow.
  Span<const int> near(std::size_t i) const { return near_[i]; }
  Span<const int> linked(std::size_t i) const { return linked_[i]; }
  /// Groups in the order of their first members. A single point is also a group.
  std::size_t size() const { return members_.size(); }
  Span<const int> group(std::size_t g) const { return members_[g]; }

 private:
  /// Lists one after the other in one array.
  class Lists {
   public:
    void clear() { entries_.clear(), ends_.clear(); }
    void push(int entry) { entries_.push_back(entry); }
    void end_list() { ends_.push_back(entries_.size()); }
    /// Lists of these lengths, filled by put().
    void lay_out(const std::vector<int>& lengths);
    void put(std::size_t list, int entry) { entries_[ends_[list]++] = entry; }

    std::size_t size() const { return ends_.size(); }
    Span<const int> operator[](std::size_t list) const {
      const std::size_t begin = list == 0 ? 0 : ends_[list - 1];
      return {entries_.data() + begin, ends_[list] - begin};
    }

   private:
    std::vector<int> entries_;
    std::vector<std::size_t> ends_;
  };

  int root(int i);
  void join(int a, int b);
  void collect();

  ImageNeighbours grid_;
  Lists near_, linked_, members_;
  std::vector<int> nearest_, parent_, number_, counts_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/motion/detail/flow_groups-inl.hpp>
#endif
