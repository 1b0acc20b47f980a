// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/types.hpp>
#include <utility>
#include <vector>

namespace dynfilter::detail {

/// Points sorted into the cubes of a uniform grid.
/// Stores only occupied cells, sorted by key (z, y, x).
/// A row of neighbouring cells is therefore one contiguous run of points.
/// A pass over all cells finds the neighbouring rows by advancing pointers, without hashing.
/// Cost: O(n) for keys of moderate extent.
class CellGrid {
 public:
  struct Run {
    std::uint32_t begin, end;
  };

  /// Skips points that are not finite. `reach` is the neighbour distance in cells.
  /// Throws Error if several hundred thousand points are all far apart relative to `cell_m`.
  void build(Span<const cv::Point3f> points, double cell_m, int reach);

  std::size_t points() const { return index_.size(); }
  std::size_t cells() const { return keys_.size(); }
  /// Points of a cell, as positions in the sorted arrays.
  Run cell(std::size_t c) const { return {begin_[c], begin_[c + 1]}; }
  cv::Point3f at(std::size_t place) const { return {x_[place], y_[place], z_[place]}; }
  std::uint32_t index(std::size_t place) const { return index_[place]; }

  /// Number of points in a run that are within the radius.
  int count(Run run, const cv::Point3f& p, float radius2) const {
    int n = 0;
    for (std::uint32_t j = run.begin; j < run.end; ++j) {
      const float dx = x_[j] - p.x, dy = y_[j] - p.y, dz = z_[j] - p.z;
      n += dx * dx + dy * dy + dz * dz <= radius2 ? 1 : 0;
    }
    return n;
  }

  /// Moves the points of a cell with chosen(index) to its front and keeps the order otherwise.
  /// Returns their number.
  template <class F>
  std::uint32_t partition(std::size_t c, const F& chosen) {
    const Run run = cell(c);
    std::uint32_t next = run.begin;
    for (std::uint32_t j = run.begin; j < run.end; ++j) {
      if (!chosen(index_[j])) continue;
      for (std::uint32_t k = j; k > next; --k) swap(k, k - 1);
      ++next;
    }
    return next - run.begin;
  }

  /// The rows of cells around a cell, for a pass over all cells in order.
  class Rows {
   public:
    /// `forward`: only cells after the cell itself in key order.
    Rows(const CellGrid& grid, bool forward) : grid_(grid) {
      const std::int64_t reach = grid.reach_;
      for (std::int64_t dz = forward ? 0 : -reach; dz <= reach; ++dz)
        for (std::int64_t dy = -reach; dy <= reach; ++dy) {
          const bool own = dz == 0 && dy == 0;
          if (forward && dz == 0 && dy < 0) continue;
          const std::int64_t row = dz * grid.stride_z_ + dy * grid.stride_y_;
          Row& added = rows_[size_++];
          added = {row + (forward && own ? 1 : -reach), row + reach, 0, 0};
          if (own) std::swap(added, rows_[0]);
        }
    }
    /// Call with increasing c.
    void move_to(std::size_t c) {
      const std::int64_t key = grid_.keys_[c];
      const auto cells = static_cast<std::uint32_t>(grid_.keys_.size());
      const std::int64_t* keys = grid_.keys_.data();
      for (std::size_t r = 0; r < size_; ++r) {
        Row& row = rows_[r];
        while (row.begin < cells && keys[row.begin] < key + row.first) ++row.begin;
        row.end = std::max(row.end, row.begin);
        while (row.end < cells && keys[row.end] <= key + row.last) ++row.end;
      }
    }
    std::size_t size() const { return size_; }
    /// Row 0 is the row of the cell itself.
    Run cells(std::size_t r) const { return {rows_[r].begin, rows_[r].end}; }
    Run points(std::size_t r) const { return {grid_.begin_[rows_[r].begin], grid_.begin_[rows_[r].end]}; }

   private:
    struct Row {
      std::int64_t first, last;  ///< keys relative to the cell's key
      std::uint32_t begin, end;  ///< cells
    };
    const CellGrid& grid_;
    std::array<Row, 25> rows_{};
    std::size_t size_ = 0;
  };

  /// Lists each pair of points within the radius once, by position.
  /// Returns false, without a complete list, if this takes more than `most` tests.
  /// Requires cells at least as wide as the radius, and reach 1.
  template <class Pair>
  bool list_pairs(float radius2, std::size_t most, std::vector<Pair>& out) const {
    std::size_t found = 0, tests = 0;
    const bool complete = for_each_candidate([&](std::uint32_t i, Run with) {
      tests += with.end - with.begin;
      if (tests > most) return false;
      if (out.size() < found + (with.end - with.begin))
        out.resize(2 * found + 1024 + (with.end - with.begin));
      Pair* list = out.data();
      const float x = x_[i], y = y_[i], z = z_[i];
      // Branchless: half of the tests succeed.
      for (std::uint32_t j = with.begin; j < with.end; ++j) {
        const float dx = x_[j] - x, dy = y_[j] - y, dz = z_[j] - z;
        const float d2 = dx * dx + dy * dy + dz * dz;
        list[found] = {i, j, d2};
        found += d2 <= radius2 ? 1 : 0;
      }
      return true;
    });
    out.resize(complete ? found : 0);
    return complete;
  }
  /// Calls f(i, j) with positions, without a list.
  template <class F>
  void for_each_pair(float radius2, const F& f) const {
    for_each_candidate([&](std::uint32_t i, Run with) {
      for (std::uint32_t j = with.begin; j < with.end; ++j)
        if (squared_distance(at(i), at(j)) <= radius2) f(i, j);
      return true;
    });
  }

 private:
  /// Calls f(i, run) until it returns false.
  /// Each pair of points in neighbouring cells occurs once.
  template <class F>
  bool for_each_candidate(const F& f) const {
    Rows rows(*this, true);
    for (std::size_t c = 0; c < cells(); ++c) {
      rows.move_to(c);
      const Run own = cell(c);
      for (std::uint32_t i = own.begin; i < own.end; ++i) {
        // The first row begins where the cell itself ends.
        const Run first{i + 1, std::max(own.end, rows.points(0).end)};
        if (first.begin < first.end && !f(i, first)) return false;
        for (std::size_t r = 1; r < rows.size(); ++r) {
          const Run run = rows.points(r);
          if (run.begin < run.end && !f(i, run)) return false;
        }
      }
    }
    return true;
  }

  void collect(Span<const cv::Point3f> points);

  /// Computes cell coordinates from 0 and their keys.
  /// `reach` empty cells separate consecutive rows.
  void place(Span<const cv::Point3f> points, double cell_m);

  /// Without SSE4.1, std::floor is a function call.
  static double floor_of(double v);
  static int key_bits(const std::array<double, 3>& extent);
  int index_bits() const {
    return static_cast<int>(portable::log2(static_cast<double>(index_.size() + 1))) + 1;
  }

  /// Shrinks empty stretches that are longer than the reach, which keeps all neighbourhoods.
  /// Returns the largest coordinate.
  double close_gaps(std::vector<double>& coordinates);

  /// Sorts by key. Points of one cell keep their order.
  void sort();
  void sort_wide();
  void radix_pass(int shift, int digit);

  void fill(Span<const cv::Point3f> points);

  void swap(std::uint32_t a, std::uint32_t b) {
    std::swap(x_[a], x_[b]);
    std::swap(y_[a], y_[b]);
    std::swap(z_[a], z_[b]);
    std::swap(index_[a], index_[b]);
  }

  int reach_ = 1, key_bits_ = 0;
  std::int64_t stride_y_ = 0, stride_z_ = 0;
  std::vector<std::int64_t> keys_;
  std::vector<std::uint32_t> begin_;  ///< cells() + 1 entries
  std::vector<float> x_, y_, z_;
  std::vector<std::uint32_t> index_;

  std::array<std::vector<double>, 3> coordinates_;
  std::vector<std::int64_t> key_of_;
  std::vector<std::uint32_t> order_, unsorted_, counts_;
  std::vector<std::uint64_t> packed_, swapped_;
};

}  // namespace dynfilter::detail

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/cluster/detail/cell_grid-inl.hpp>
#endif
