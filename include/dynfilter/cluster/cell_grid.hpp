// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/span.hpp>
#include <limits>
#include <numeric>
#include <opencv2/core/types.hpp>
#include <utility>
#include <vector>

namespace dynfilter::detail {

/// Points sorted into the cubes of a uniform grid, for the neighbours of all points in one pass. PointGrid
/// (core/point_grid.hpp) searches around single places in an image. Stores only occupied cells, sorted by key
/// (z, y, x). A row of neighbouring cells is therefore one contiguous run of points. A pass over all cells
/// finds the neighbouring rows by advancing pointers, without hashing. Cost: O(n) for moderate keys.
class CellGrid {
 public:
  struct Run {
    std::uint32_t begin, end;
  };

  /// Skips points that are not finite. `reach` is the neighbour distance in cells.
  /// Throws Error if several hundred thousand points are all far apart relative to `cell_m`.
  void build(Span<const cv::Point3f> points, double cell_m, int reach) {
    reach_ = reach;
    index_.clear();
    for (std::size_t i = 0; i < points.size(); ++i)
      if (finite(points[i])) index_.push_back(static_cast<std::uint32_t>(i));
    place(points, cell_m);
    sort(points);
  }

  std::size_t points() const { return index_.size(); }
  std::size_t cells() const { return cells_.size(); }
  /// Points of a cell, as positions in the sorted arrays.
  Run cell(std::size_t c) const { return {cells_.starts()[c], cells_.starts()[c + 1]}; }
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
      const auto cells = static_cast<std::uint32_t>(grid_.cells());
      const CellLists::Key* keys = grid_.cells_.keys().data();
      const auto at = [keys](std::size_t cell) { return static_cast<std::int64_t>(keys[cell]); };
      const std::int64_t key = at(c);
      for (std::size_t r = 0; r < size_; ++r) {
        Row& row = rows_[r];
        while (row.begin < cells && at(row.begin) < key + row.first) ++row.begin;
        row.end = std::max(row.end, row.begin);
        while (row.end < cells && at(row.end) <= key + row.last) ++row.end;
      }
    }
    std::size_t size() const { return size_; }
    /// Row 0 is the row of the cell itself.
    Run cells(std::size_t r) const { return {rows_[r].begin, rows_[r].end}; }
    Run points(std::size_t r) const {
      const std::vector<std::uint32_t>& starts = grid_.cells_.starts();
      return {starts[rows_[r].begin], starts[rows_[r].end]};
    }

   private:
    struct Row {
      std::int64_t first, last;  ///< keys relative to the cell's key
      std::uint32_t begin, end;  ///< cells
    };
    const CellGrid& grid_;
    std::array<Row, 25> rows_{};
    std::size_t size_ = 0;
  };

  /// Lists each pair of points within the radius once, by position. Returns false, without a complete list,
  /// if this takes more than `most` tests. Requires cells at least as wide as the radius, and reach 1.
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
  /// Calls f(i, run) until it returns false. Each pair of points in neighbouring cells occurs once.
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

  /// Computes cell coordinates from 0. `reach` empty cells separate consecutive rows.
  void place(Span<const cv::Point3f> points, double cell_m) {
    const double per_m = 1 / cell_m;
    std::array<double, 3> extent{}, lows{};
    const float cv::Point3f::*axes[] = {&cv::Point3f::x, &cv::Point3f::y, &cv::Point3f::z};
    for (std::size_t a = 0; a < 3; ++a) {
      std::vector<double>& cells = coordinates_[a];
      cells.resize(index_.size());
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (std::size_t k = 0; k < index_.size(); ++k) {
        cells[k] = floor_of(static_cast<double>(points[index_[k]].*axes[a]) * per_m);
        low = std::min(low, cells[k]);
        high = std::max(high, cells[k]);
      }
      extent[a] = index_.empty() ? 1.0 : high - low + 1 + reach_;
      lows[a] = low;
    }
    const bool wide = key_bits(extent) + key_bits({static_cast<double>(index_.size() + 1), 1, 1}) > 63;
    for (std::size_t a = 0; a < 3; ++a) {
      if (wide)
        extent[a] = close_gaps(coordinates_[a]) + 1 + reach_;
      else
        for (double& cell : coordinates_[a]) cell -= lows[a];
    }
    if (key_bits(extent) > 62) throw Error("the points are too far apart for clusters of this size");
    stride_y_ = static_cast<std::int64_t>(extent[0]);
    stride_z_ = stride_y_ * static_cast<std::int64_t>(extent[1]);
  }

  /// Without SSE4.1, std::floor is a function call.
  static double floor_of(double v) {
    if (!(std::abs(v) < 4e15)) return std::floor(v);
    const auto whole = static_cast<double>(static_cast<std::int64_t>(v));
    return whole > v ? whole - 1 : whole;
  }
  static int key_bits(const std::array<double, 3>& extent) {
    const double bits = portable::log2(extent[0]) + portable::log2(extent[1]) + portable::log2(extent[2]);
    return bits > 1000 ? 1000 : static_cast<int>(bits) + 1;
  }

  /// Shrinks empty stretches that are longer than the reach, which keeps all neighbourhoods.
  /// Returns the largest coordinate.
  double close_gaps(std::vector<double>& coordinates) {
    std::vector<std::size_t> order(coordinates.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return coordinates[a] < coordinates[b]; });
    double before = coordinates[order[0]], closed = 0;
    for (const std::size_t k : order) {
      closed += std::min(coordinates[k] - before, static_cast<double>(reach_ + 1));
      before = coordinates[k];
      coordinates[k] = closed;
    }
    return closed;
  }

  void sort(Span<const cv::Point3f> points) {
    const std::size_t n = index_.size();
    cells_.build_occupied(n, [&](std::size_t k) {
      return static_cast<CellLists::Key>(static_cast<std::int64_t>(coordinates_[2][k]) * stride_z_ +
                                         static_cast<std::int64_t>(coordinates_[1][k]) * stride_y_ +
                                         static_cast<std::int64_t>(coordinates_[0][k]));
    });
    x_.resize(n), y_.resize(n), z_.resize(n), unsorted_.swap(index_), index_.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      const std::uint32_t i = unsorted_[static_cast<std::size_t>(cells_.entries()[k])];
      x_[k] = points[i].x, y_[k] = points[i].y, z_[k] = points[i].z, index_[k] = i;
    }
  }

  void swap(std::uint32_t a, std::uint32_t b) {
    std::swap(x_[a], x_[b]);
    std::swap(y_[a], y_[b]);
    std::swap(z_[a], z_[b]);
    std::swap(index_[a], index_[b]);
  }

  int reach_ = 1;
  std::int64_t stride_y_ = 0, stride_z_ = 0;
  CellLists cells_;
  std::vector<float> x_, y_, z_;
  std::vector<std::uint32_t> index_, unsorted_;
  std::array<std::vector<double>, 3> coordinates_;
};

}  // namespace dynfilter::detail
