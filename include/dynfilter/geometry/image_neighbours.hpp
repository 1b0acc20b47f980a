// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace dynfilter {

/// The nearest points of points in an image, by a uniform grid. All points finite. Cost: building O(n), a
/// query looks at the points of nine cells of `radius_px`.
class ImageNeighbours {
 public:
  struct Point {
    double x = 0, y = 0;
  };

  void build(const std::vector<Point>& points, double radius_px) {
    points_ = &points;
    radius_px_ = radius_px;
    double right = 0, bottom = 0;
    left_ = top_ = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      left_ = i == 0 ? points[i].x : std::min(left_, points[i].x);
      right = i == 0 ? points[i].x : std::max(right, points[i].x);
      top_ = i == 0 ? points[i].y : std::min(top_, points[i].y);
      bottom = i == 0 ? points[i].y : std::max(bottom, points[i].y);
    }
    cell_px_ = std::max(radius_px, std::max(right - left_, bottom - top_) / kMaxCells);
    columns_ = cell(right - left_) + 1;
    rows_ = cell(bottom - top_) + 1;
    fill();
  }

  /// Up to `k` nearest other points within the radius of (x, y), nearest first, those at the same distance by
  /// their index. `self` is left out (-1: none is).
  void nearest(double x, double y, int self, int k, std::vector<int>& out) {
    found_.clear();
    const int column = cell(x - left_), row = cell(y - top_);
    for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r)
      for (int c = std::max(0, column - 1); c <= std::min(columns_ - 1, column + 1); ++c) {
        const std::size_t at = index(r, c);
        for (int m = start_[at]; m < start_[at + 1]; ++m)
          consider(x, y, members_[static_cast<std::size_t>(m)], self);
      }
    const std::size_t n = std::min(found_.size(), static_cast<std::size_t>(std::max(0, k)));
    std::partial_sort(found_.begin(), found_.begin() + static_cast<std::ptrdiff_t>(n), found_.end());
    out.clear();
    for (std::size_t i = 0; i < n; ++i) out.push_back(found_[i].second);
  }

 private:
  static constexpr int kMaxCells = 256;

  int cell(double offset_px) const {
    const double at = cell_px_ > 0 ? std::floor(offset_px / cell_px_) : 0;
    return static_cast<int>(std::clamp(at, -2.0, kMaxCells + 2.0));
  }

  std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

  void consider(double x, double y, int index, int self) {
    if (index == self) return;
    const Point& p = (*points_)[static_cast<std::size_t>(index)];
    const double squared = (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y);
    if (squared <= radius_px_ * radius_px_) found_.emplace_back(squared, index);
  }

  // A counting sort of the points by cell.
  void fill() {
    const std::size_t cells = index(rows_, 0);
    start_.assign(cells + 1, 0);
    const auto cell_of = [&](const Point& p) { return index(cell(p.y - top_), cell(p.x - left_)); };
    for (const Point& p : *points_) ++start_[cell_of(p) + 1];
    for (std::size_t c = 0; c < cells; ++c) start_[c + 1] += start_[c];
    next_.assign(start_.begin(), start_.end());
    members_.resize(points_->size());
    for (std::size_t i = 0; i < points_->size(); ++i)
      members_[static_cast<std::size_t>(next_[cell_of((*points_)[i])]++)] = static_cast<int>(i);
  }

  const std::vector<Point>* points_ = nullptr;
  double radius_px_ = 0, cell_px_ = 1, left_ = 0, top_ = 0;
  int columns_ = 1, rows_ = 1;
  std::vector<int> start_, next_, members_;
  std::vector<std::pair<double, int>> found_;
};

}  // namespace dynfilter
