// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/cluster/cell_grid.hpp>

#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <limits>
#include <numeric>
#include <opencv2/core.hpp>

namespace dynfilter::detail {

DYNFILTER_INLINE void CellGrid::build(Span<const cv::Point3f> points, double cell_m, int reach) {
  reach_ = reach;
  collect(points);
  place(points, cell_m);
  sort();
  fill(points);
}

inline void CellGrid::collect(Span<const cv::Point3f> points) {
  index_.clear();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (finite(points[i])) index_.push_back(static_cast<std::uint32_t>(i));
}

DYNFILTER_INLINE void CellGrid::place(Span<const cv::Point3f> points, double cell_m) {
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
  const bool wide = key_bits(extent) + index_bits() > 63;
  for (std::size_t a = 0; a < 3; ++a) {
    if (wide)
      extent[a] = close_gaps(coordinates_[a]) + 1 + reach_;
    else
      for (double& cell : coordinates_[a]) cell -= lows[a];
  }
  key_bits_ = key_bits(extent);
  if (key_bits_ > 62) throw Error("the points are too far apart for clusters of this size");
  stride_y_ = static_cast<std::int64_t>(extent[0]);
  stride_z_ = stride_y_ * static_cast<std::int64_t>(extent[1]);
}

inline double CellGrid::floor_of(double v) {
  if (!(std::abs(v) < 4e15)) return std::floor(v);
  const auto whole = static_cast<double>(static_cast<std::int64_t>(v));
  return whole > v ? whole - 1 : whole;
}

inline int CellGrid::key_bits(const std::array<double, 3>& extent) {
  const double bits = portable::log2(extent[0]) + portable::log2(extent[1]) + portable::log2(extent[2]);
  return bits > 1000 ? 1000 : static_cast<int>(bits) + 1;
}

inline double CellGrid::close_gaps(std::vector<double>& coordinates) {
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

inline void CellGrid::sort() {
  const std::size_t n = index_.size();
  key_of_.resize(n);
  for (std::size_t k = 0; k < n; ++k)
    key_of_[k] = static_cast<std::int64_t>(coordinates_[2][k]) * stride_z_ +
                 static_cast<std::int64_t>(coordinates_[1][k]) * stride_y_ +
                 static_cast<std::int64_t>(coordinates_[0][k]);
  const int shift = index_bits();
  if (key_bits_ + shift > 63) return sort_wide();
  packed_.resize(n);
  for (std::size_t k = 0; k < n; ++k)
    packed_[k] = static_cast<std::uint64_t>(key_of_[k]) << shift | static_cast<std::uint64_t>(k);
  const int passes = (key_bits_ + 10) / 11, digit = (key_bits_ + passes - 1) / passes;
  if (static_cast<std::size_t>(passes) << digit > 8 * n)
    std::sort(packed_.begin(), packed_.end());
  else
    for (int pass = 0; pass < passes; ++pass) radix_pass(shift + pass * digit, digit);
  order_.resize(n);
  const std::uint64_t mask = (std::uint64_t{1} << shift) - 1;
  for (std::size_t k = 0; k < n; ++k) order_[k] = static_cast<std::uint32_t>(packed_[k] & mask);
}

inline void CellGrid::sort_wide() {
  order_.resize(key_of_.size());
  std::iota(order_.begin(), order_.end(), 0U);
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return key_of_[a] < key_of_[b]; });
}

inline void CellGrid::radix_pass(int shift, int digit) {
  const std::uint64_t mask = (std::uint64_t{1} << digit) - 1;
  counts_.assign(mask + 2, 0);
  for (const std::uint64_t p : packed_) ++counts_[(p >> shift & mask) + 1];
  for (std::size_t d = 1; d < counts_.size(); ++d) counts_[d] += counts_[d - 1];
  swapped_.resize(packed_.size());
  for (const std::uint64_t p : packed_) swapped_[counts_[p >> shift & mask]++] = p;
  packed_.swap(swapped_);
}

inline void CellGrid::fill(Span<const cv::Point3f> points) {
  const std::size_t n = index_.size();
  x_.resize(n), y_.resize(n), z_.resize(n), unsorted_.swap(index_), index_.resize(n);
  keys_.clear();
  begin_.clear();
  std::int64_t last = -1;
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t i = unsorted_[order_[k]];
    x_[k] = points[i].x, y_[k] = points[i].y, z_[k] = points[i].z, index_[k] = i;
    const std::int64_t key = key_of_[order_[k]];
    if (key == last) continue;
    keys_.push_back(key);
    begin_.push_back(static_cast<std::uint32_t>(k));
    last = key;
  }
  begin_.push_back(static_cast<std::uint32_t>(n));
}

}  // namespace dynfilter::detail
