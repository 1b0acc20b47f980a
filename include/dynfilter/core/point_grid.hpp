// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/span.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace dynfilter {

/// Where it is [px].
inline const cv::Point2f& place_of(const cv::Point2f& point) {
  return point;
}
/// Where it is [px].
inline const cv::Point2f& place_of(const cv::KeyPoint& keypoint) {
  return keypoint.pt;
}
/// Where it is, rounded to float [px].
inline cv::Point2f place_of(const cv::Point2d& point) {
  return {static_cast<float>(point.x), static_cast<float>(point.y)};
}

/// Image points (cv::Point2f, cv::Point2d or cv::KeyPoint) sorted into square cells. Finds the points around
/// a place without a full scan. Skips points that are not finite or beyond 1e6 pixels. Building takes about
/// 10 us for 1000 points and reuses memory. A table of at most 256 x 256 cells, whose cells grow with the
/// extent of the points. If that crowds them, only occupied cells of the wanted size are kept: a few outliers
/// do not make a search slow.
class PointGrid {
 public:
  /// Sorts the points into cells of this width; they are not copied.
  template <class P>
  void build(Span<P> points, float cell_px) {
    min_ = {std::numeric_limits<float>::max(), std::numeric_limits<float>::max()};
    cv::Point2f max(std::numeric_limits<float>::lowest(), std::numeric_limits<float>::lowest());
    for (const auto& point : points) {
      const cv::Point2f& p = place_of(point);
      if (!usable(p)) continue;
      min_ = {std::min(min_.x, p.x), std::min(min_.y, p.y)};
      max = {std::max(max.x, p.x), std::max(max.y, p.y)};
    }
    clear();
    if (max.x < min_.x) return;
    const cv::Point2f extent = max - min_;
    const float wanted_px = std::max(1.0F, cell_px), table_px = std::max(extent.x, extent.y) / kMaxCells;
    const auto cell_of = [&](std::size_t i) {
      const cv::Point2f& p = place_of(points[i]);
      return usable(p) ? key(row(p.y), column(p.x)) : CellLists::kNoCell;
    };
    divide(extent, std::max(wanted_px, table_px));
    cells_.build(key(rows_, 0), points.size(), cell_of);
    if (table_px <= wanted_px || entries().size() <= kCrowd || crowd() <= kCrowd) return;
    divide(extent, wanted_px);
    cells_.build_occupied(points.size(), cell_of);
  }

  /// Like build(), for nearest() and ranges_outwards(). The cells are smaller where points are crowded.
  template <class P>
  void build_for_nearest(Span<P> points, float cell_px) {
    build(points, cell_px);
    for (int k = 0; k < kMostRefinements && cell_px > kLeastCell_px; ++k) {
      const double crowd = this->crowd();
      if (crowd <= kCrowd) break;
      cell_px = std::max(kLeastCell_px, cell_px * static_cast<float>(std::sqrt(kFew / crowd)));
      build(points, cell_px);
    }
    places_.resize(entries().size());
    for (std::size_t e = 0; e < places_.size(); ++e)
      places_[e] = points[static_cast<std::size_t>(entries()[e])];
  }

  /// Calls f(index) for every point in the cells that the circle touches.
  /// This includes some points outside the circle. The order depends on position first, then on index.
  template <class F>
  void around(const cv::Point2f& centre, float radius_px, const F& f) const {
    ranges_around(centre, radius_px, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) f(entries()[e]);
    });
  }
  /// Like around(), but calls f(begin, end) with ranges of entries().
  template <class F>
  void ranges_around(const cv::Point2f& centre, float radius_px, const F& f) const {
    if (empty() || !usable(centre)) return;
    const int x0 = column(centre.x - radius_px), y0 = row(centre.y - radius_px);
    const int x1 = column(centre.x + radius_px), y1 = row(centre.y + radius_px);
    for (int y = y0; y <= y1; ++y) {
      const auto [begin, end] = cells_.range(key(y, x0), key(y, x1));
      if (begin < end) f(begin, end);
    }
  }

  /// Calls f(begin, end) with ranges of entries(): the cell of `at`, then what else is within reach, nearer
  /// rows first. f returns the reach [px] that is left, a little more than the distance of what it found.
  template <class F>
  void ranges_outwards(const cv::Point2d& at, double reach_px, const F& f) const {
    if (empty() || !usable(place_of(at))) return;
    const int x = column(static_cast<float>(at.x)), y = row(static_cast<float>(at.y));
    const auto look = [&](int in_row, int first, int last) {
      if (first > last) return;
      const auto [begin, end] = cells_.range(key(in_row, first), key(in_row, last));
      if (begin < end) reach_px = f(begin, end);
    };
    const auto left = [&] { return column(static_cast<float>(at.x - reach_px)); };
    const auto right = [&] { return column(static_cast<float>(at.x + reach_px)); };
    look(y, x, x);
    for (int end = x - 1, n = 2; end >= left(); end -= n, n *= 2) look(y, std::max(left(), end - n + 1), end);
    for (int begin = x + 1, n = 2; begin <= right(); begin += n, n *= 2)
      look(y, begin, std::min(right(), begin + n - 1));
    bool above = true, below = true;
    for (int away = 1; above || below; ++away) {
      above = above && y - away >= row(static_cast<float>(at.y - reach_px));
      if (above) look(y - away, left(), right());
      below = below && y + away <= row(static_cast<float>(at.y + reach_px));
      if (below) look(y + away, left(), right());
    }
  }

  /// What to search for.
  struct Nearest {
    int count;            ///< at most
    double radius_px;     ///< at most so far away
    double least_px = 0;  ///< and at least so far
    int self = -1;        ///< index of a point that does not count
  };
  /// The points nearest to `at`, nearest first, then by index. Compares exact coordinates.
  /// Needs build_for_nearest(), with cells of half the radius. Cells beyond what was found are not read, so
  /// the cost does not depend on the radius: about 0.1 us for 6 of 1000 points.
  void nearest(const cv::Point2d& at, const Nearest& wanted, std::vector<int>& out) {
    out.clear();
    found_.clear();
    if (places_.empty() || wanted.count <= 0) return;
    const auto reach = [](double squared) { return std::sqrt(squared) * kRounding; };
    const double least2 = wanted.least_px * wanted.least_px;
    double reach2 = wanted.radius_px * wanted.radius_px;
    ranges_outwards(at, reach(reach2), [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        const cv::Point2d d = places_[e] - at;
        const double apart2 = d.x * d.x + d.y * d.y;
        if (!(apart2 >= least2 && apart2 <= reach2) || entries()[e] == wanted.self) continue;
        insert({apart2, entries()[e]}, static_cast<std::size_t>(wanted.count));
        if (found_.size() == static_cast<std::size_t>(wanted.count)) reach2 = found_.back().first;
      }
      return reach(reach2);
    });
    for (const auto& near : found_) out.push_back(near.second);
  }

  /// Calls f(begin, end) with the range of entries() of every cell.
  template <class F>
  void for_each_cell(const F& f) const {
    for (std::size_t c = 0; c < cells_.size(); ++c)
      f(std::size_t{cells_.starts()[c]}, std::size_t{cells_.starts()[c + 1]});
  }
  /// Indices of the usable points, sorted by cell.
  const std::vector<std::int32_t>& entries() const { return cells_.entries(); }
  bool empty() const { return entries().empty(); }
  /// How many points share the cell of a point, on average.
  double crowd() const { return cells_.crowd(); }
  void clear() { cells_.clear(), places_.clear(); }

  /// Larger than any image; cell numbers and sums fit an int.
  static constexpr float kMaxPixel = 1e6F;
  /// False for NaN and for places that no image reaches.
  static bool usable(const cv::Point2f& p) { return std::abs(p.x) < kMaxPixel && std::abs(p.y) < kMaxPixel; }

 private:
  static constexpr float kMaxCells = 256;
  static constexpr std::size_t kCrowd = 64;      ///< points in a cell that are no longer few
  static constexpr double kFew = 8;              ///< points in a cell that are wanted
  static constexpr int kMostRefinements = 4;     ///< for points that are crowded in few of the new cells
  static constexpr float kLeastCell_px = 1;      ///< features are not denser (limits::kMaxCrowd)
  static constexpr double kRounding = 1 + 1e-9;  ///< of distances

  void divide(const cv::Point2f& extent_px, float cell_px) {
    per_px_ = 1 / cell_px;
    columns_ = static_cast<int>(extent_px.x * per_px_) + 1;
    rows_ = static_cast<int>(extent_px.y * per_px_) + 1;
  }
  // Both grow with the coordinate: a point within reach is never in a cell beyond that of the reach.
  int column(float x_px) const { return cell_along((x_px - min_.x) * per_px_, columns_); }
  int row(float y_px) const { return cell_along((y_px - min_.y) * per_px_, rows_); }
  CellLists::Key key(int row, int column) const {
    return static_cast<CellLists::Key>(row) * static_cast<CellLists::Key>(columns_) +
           static_cast<CellLists::Key>(column);
  }

  void insert(const std::pair<double, int>& near, std::size_t most) {
    if (found_.size() == most) {
      if (!(near < found_.back())) return;
      found_.pop_back();
    }
    found_.push_back(near);
    for (std::size_t i = found_.size() - 1; i > 0 && near < found_[i - 1]; --i)
      std::swap(found_[i], found_[i - 1]);
  }

  cv::Point2f min_;
  float per_px_ = 1;
  int columns_ = 0, rows_ = 0;
  CellLists cells_;
  std::vector<cv::Point2d> places_;            ///< of entries(), for nearest()
  std::vector<std::pair<double, int>> found_;  ///< squared distance, index
};

}  // namespace dynfilter
