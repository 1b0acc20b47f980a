// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/image_neighbours.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace dynfilter {

DYNFILTER_INLINE void ImageNeighbours::build(const std::vector<Point>& points, double radius_px) {
  radius_px_ = radius_px;
  double right = 0, bottom = 0;
  left_ = top_ = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    left_ = i == 0 ? points[i].x : std::min(left_, points[i].x);
    right = i == 0 ? points[i].x : std::max(right, points[i].x);
    top_ = i == 0 ? points[i].y : std::min(top_, points[i].y);
    bottom = i == 0 ? points[i].y : std::max(bottom, points[i].y);
  }
  width_px_ = right - left_, height_px_ = bottom - top_;
  cell_px_ = std::max(radius_px / kCellsOfRadius, std::max(width_px_, height_px_) / kMaxCells);
  sparse_ = false;
  columns_ = cell(width_px_) + 1;
  rows_ = cell(height_px_) + 1;
  fill(points);
  for (int k = 0; k < kMostRefinements && cell_px_ > kLeastCell_px; ++k) {
    const double crowd = mean_crowd(start_);
    if (crowd <= kCrowd) return;
    cell_px_ = std::max(kLeastCell_px, cell_px_ * std::sqrt(kFew / crowd));
    fill_sparse(points);
  }
}

DYNFILTER_INLINE void ImageNeighbours::nearest(double x, double y, int self, int k, std::vector<int>& out,
                                               double least_px) {
  out.clear();
  if (k <= 0) return;
  found_.clear();
  query_ = {{x, y}, self, static_cast<std::size_t>(k), radius_px_ * radius_px_, least_px * least_px};
  const int column = cell(x - left_), row = cell(y - top_);
  look(row, column, column);  // the nearest cell first, so that few others remain within reach
  look_along(row, column);
  bool above = true, below = true;
  for (int away = 1; above || below; ++away) {
    above = row - away >= 0 && within_reach(y - top_ - (row - away + 1) * cell_px_);
    below = row + away < rows_ && within_reach((row + away) * cell_px_ - (y - top_));
    if (above) look_along(row - away, kNoColumn);
    if (below) look_along(row + away, kNoColumn);
  }
  for (const auto& near : found_) out.push_back(near.second);
}

inline int ImageNeighbours::cell(double offset_px) const {
  const double at = cell_px_ > 0 ? std::floor(offset_px / cell_px_) : 0;
  const double most = sparse_ ? kMaxSparse : kMaxCells + 3.0;
  return static_cast<int>(std::clamp(at, sparse_ ? -most : -3.0, most));
}

inline std::size_t ImageNeighbours::index(int row, int column) const {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
         static_cast<std::size_t>(column);
}

inline bool ImageNeighbours::within_reach(double gap_px) const {
  return gap_px <= 0 || gap_px * gap_px <= query_.reach2 * kRounding;
}

inline void ImageNeighbours::look_along(int row, int but) {
  const double reach_px = std::sqrt(query_.reach2) * kRounding, offset_px = query_.at.x - left_;
  const int first = cell(offset_px - reach_px), last = cell(offset_px + reach_px);
  look(row, first, but == kNoColumn ? last : but - 1);
  if (but != kNoColumn) look(row, but + 1, last);
}

inline void ImageNeighbours::look(int row, int first, int last) {
  first = std::max(0, first);
  last = std::min(columns_ - 1, last);
  if (row < 0 || row >= rows_ || first > last) return;
  const auto [begin, end] = range(row, first, last);
  for (std::size_t at = begin; at < end; ++at) {
    const double dx = places_[at].x - query_.at.x, dy = places_[at].y - query_.at.y,
                 squared = dx * dx + dy * dy;
    if (squared >= query_.least2 && squared <= query_.reach2 && members_[at] != query_.self)
      insert({squared, members_[at]});
  }
}

inline std::pair<std::size_t, std::size_t> ImageNeighbours::range(int row, int first, int last) const {
  std::size_t from = 0, to = 0;
  if (sparse_)
    std::tie(from, to) = cells_.cells(SparseCells::key(row, first), SparseCells::key(row, last));
  else
    from = index(row, first), to = index(row, last) + 1;
  return {static_cast<std::size_t>(start_[from]), static_cast<std::size_t>(start_[to])};
}

inline void ImageNeighbours::insert(const std::pair<double, int>& near) {
  if (found_.size() == query_.wanted) {
    if (!(near < found_.back())) return;
    found_.pop_back();
  }
  found_.push_back(near);
  for (std::size_t i = found_.size() - 1; i > 0 && near < found_[i - 1]; --i)
    std::swap(found_[i], found_[i - 1]);
  if (found_.size() == query_.wanted) query_.reach2 = found_.back().first;
}

inline void ImageNeighbours::fill(const std::vector<Point>& points) {
  const std::size_t cells = index(rows_, 0);
  start_.assign(cells + 1, 0);
  const auto cell_of = [&](const Point& p) { return index(cell(p.y - top_), cell(p.x - left_)); };
  for (const Point& p : points) ++start_[cell_of(p) + 1];
  for (std::size_t c = 0; c < cells; ++c) start_[c + 1] += start_[c];
  next_.assign(start_.begin(), start_.end());
  members_.resize(points.size());
  places_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = static_cast<std::size_t>(next_[cell_of(points[i])]++);
    members_[at] = static_cast<int>(i);
    places_[at] = points[i];
  }
}

inline void ImageNeighbours::fill_sparse(const std::vector<Point>& points) {
  sparse_ = true;
  columns_ = cell(width_px_) + 1;
  rows_ = cell(height_px_) + 1;
  keys_.clear();
  for (const Point& p : points) keys_.push_back(SparseCells::key(cell(p.y - top_), cell(p.x - left_)));
  cells_.build(keys_, members_, start_);
  for (std::size_t at = 0; at < members_.size(); ++at)
    places_[at] = points[static_cast<std::size_t>(members_[at])];
}

}  // namespace dynfilter
