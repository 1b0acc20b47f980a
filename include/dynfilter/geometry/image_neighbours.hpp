// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/sparse_cells.hpp>
#include <limits>
#include <utility>
#include <vector>

namespace dynfilter {

/// Nearest neighbours among image points, using a uniform grid. All points must be finite.
/// Cost: building O(n), a query about 0.1 us for 6 neighbours of 1000 points.
/// A query skips cells that are farther away than the k nearest points already found.
/// Cells are half the radius. If that crowds the points, the cells are smaller.
class ImageNeighbours {
 public:
  struct Point {
    double x = 0, y = 0;
  };

  void build(const std::vector<Point>& points, double radius_px);

  /// Finds up to `k` nearest other points within the radius of (x, y), nearest first.
  /// Equal distances are ordered by index. `self` is skipped; -1 skips none.
  /// Points closer than `least_px` are skipped.
  void nearest(double x, double y, int self, int k, std::vector<int>& out, double least_px = 0);

 private:
  static constexpr int kMaxCells = 256, kCellsOfRadius = 2, kNoColumn = std::numeric_limits<int>::min();
  static constexpr double kCrowd = 64, kFew = 8;  ///< points in a cell that are too many, and that are wanted
  static constexpr int kMostRefinements = 4;      ///< for points that are crowded in few of the new cells
  static constexpr double kLeastCell_px = 1;      ///< features are not denser (limits::kMaxCrowd)
  static constexpr double kMaxSparse = 1e8;       ///< cells per side, if only occupied ones are kept
  static constexpr double kRounding = 1 + 1e-9;

  struct Query {
    Point at;
    int self = -1;
    std::size_t wanted = 0;
    double reach2 = 0;  ///< [px^2] farther points are not among the nearest
    double least2 = 0;  ///< [px^2]
  };

  int cell(double offset_px) const;

  std::size_t index(int row, int column) const;

  bool within_reach(double gap_px) const;

  /// Searches the columns of a row within reach, except column `but`.
  void look_along(int row, int but);

  void look(int row, int first, int last);

  void insert(const std::pair<double, int>& near);

  // Counting sort of the points by cell.
  void fill(const std::vector<Point>& points);
  /// Sorts them into cells of any size, of which only the occupied ones are kept.
  void fill_sparse(const std::vector<Point>& points);
  /// Entries of a row's columns from `first` to `last`.
  std::pair<std::size_t, std::size_t> range(int row, int first, int last) const;

  double radius_px_ = 0, cell_px_ = 1, left_ = 0, top_ = 0;
  double width_px_ = 0, height_px_ = 0;
  int columns_ = 1, rows_ = 1;
  bool sparse_ = false;
  std::vector<std::int32_t> start_, next_, members_;
  SparseCells cells_;  ///< the cells of start_, if sparse_
  std::vector<SparseCells::Key> keys_;
  std::vector<Point> places_;  ///< positions of members_
  Query query_;
  std::vector<std::pair<double, int>> found_;  ///< squared distance, index
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/geometry/detail/image_neighbours-inl.hpp>
#endif
