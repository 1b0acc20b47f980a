// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/detail/grid_motion_statistics.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <numeric>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE GridMotionStatistics::GridMotionStatistics(const GmsParams& params) : params_(params) {
  if (params_.grid_cells < 0 || params_.grid_cells > 40) throw ConfigError("grid_cells", "expected 0 to 40");
  if (!(params_.matches_per_cell > 0)) throw ConfigError("matches_per_cell", "expected more than 0");
  if (!(params_.factor >= 0)) throw ConfigError("factor", "expected >= 0");
}

DYNFILTER_INLINE std::size_t GridMotionStatistics::run(
    Span<const cv::Point2f> first, const cv::Size& first_size, Span<const cv::Point2f> second,
    const cv::Size& second_size, Span<const std::uint8_t> valid, std::vector<std::uint8_t>& kept) {
  kept.assign(first.size(), 0);
  collect(first, first_size, second, second_size, valid);
  const std::size_t n = index_.size();
  if (n == 0) return 0;
  cells_ = cells_for(n);
  sort_by_cell();
  lay_left_grids();
  std::size_t best = 0;
  for (int scale = 0; scale < (params_.scale ? 5 : 1); ++scale) {
    lay_right_grid(scale);
    for (int turn = 0; turn < (params_.rotation ? 8 : 1); ++turn) {
      const std::size_t count = judge(turn);
      if (count <= best) continue;
      best = count;
      best_.swap(agreed_);
    }
  }
  if (best > 0)
    for (std::size_t k = 0; k < n; ++k) kept[index_[k]] = best_[k];
  return best;
}

DYNFILTER_INLINE int GridMotionStatistics::cells_for(std::size_t matches) const {
  if (params_.grid_cells > 0) return params_.grid_cells;
  const double cells = std::sqrt(static_cast<double>(matches) / params_.matches_per_cell);
  return static_cast<int>(std::clamp(std::round(cells), 4.0, 20.0));
}

inline void GridMotionStatistics::Side::set(int per_side) {
  if (cells == per_side) return;
  cells = per_side;
  around.assign(square(cells), 0);
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x)
      for (int j = 0; j < 9; ++j) {
        const int nx = x + j % 3 - 1, ny = y + j / 3 - 1, cell = y * cells + x;
        if (nx >= 0 && ny >= 0 && nx < cells && ny < cells)
          around[static_cast<std::size_t>(cell)] |= static_cast<std::uint16_t>(1U << j);
      }
  for (int j = 0; j < 9; ++j) offset[static_cast<std::size_t>(j)] = (j / 3 - 1) * cells + j % 3 - 1;
}

inline void GridMotionStatistics::collect(Span<const cv::Point2f> first, const cv::Size& first_size,
                                          Span<const cv::Point2f> second, const cv::Size& second_size,
                                          Span<const std::uint8_t> valid) {
  index_.clear(), first_.clear(), second_.clear();
  const auto unit = [](const cv::Point2f& p, const cv::Size& size) {
    constexpr float kLast = 0.999999F;
    return cv::Point2f(std::clamp(p.x / static_cast<float>(std::max(1, size.width)), 0.0F, kLast),
                       std::clamp(p.y / static_cast<float>(std::max(1, size.height)), 0.0F, kLast));
  };
  const std::size_t n = std::min(first.size(), second.size());
  for (std::size_t i = 0; i < n; ++i) {
    if (i < valid.size() && valid[i] == 0) continue;
    if (!detail::finite(first[i]) || !detail::finite(second[i])) continue;
    index_.push_back(static_cast<std::uint32_t>(i));
    first_.push_back(unit(first[i], first_size));
    second_.push_back(unit(second[i], second_size));
  }
}

inline void GridMotionStatistics::sort_by_cell() {
  const auto size = static_cast<float>(cells_);
  const auto cell = [&](const cv::Point2f& p) {
    return static_cast<std::size_t>(p.y * size) * static_cast<std::size_t>(cells_) +
           static_cast<std::size_t>(p.x * size);
  };
  const std::size_t n = index_.size();
  in_cell_.assign(square(cells_) + 1, 0);
  for (const cv::Point2f& p : first_) ++in_cell_[cell(p) + 1];
  std::partial_sum(in_cell_.begin(), in_cell_.end(), in_cell_.begin());
  sorted_index_.resize(n), sorted_first_.resize(n), sorted_second_.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t place = in_cell_[cell(first_[k])]++;
    sorted_index_[place] = index_[k];
    sorted_first_[place] = first_[k];
    sorted_second_[place] = second_[k];
  }
  index_.swap(sorted_index_), first_.swap(sorted_first_), second_.swap(sorted_second_);
}

inline void GridMotionStatistics::lay_left_grids() {
  const std::size_t n = index_.size();
  left_.set(cells_);
  const auto nowhere = static_cast<std::uint16_t>(cells_ * cells_);
  const auto size = static_cast<float>(cells_);
  for (std::vector<std::uint16_t>& grid : left_cell_) grid.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const float x = first_[k].x * size, y = first_[k].y * size;
    for (int shift = 0; shift < 4; ++shift) {
      const bool right = (shift & 1) != 0, down = (shift & 2) != 0;
      const int cx = static_cast<int>(right ? x + 0.5F : x), cy = static_cast<int>(down ? y + 0.5F : y);
      const bool inside = cx < cells_ && cy < cells_ && (!right || cx >= 1) && (!down || cy >= 1);
      left_cell_[static_cast<std::size_t>(shift)][k] =
          inside ? static_cast<std::uint16_t>(cy * cells_ + cx) : nowhere;
    }
  }
}

inline void GridMotionStatistics::lay_right_grid(int scale) {
  static constexpr double kRatios[] = {1, 0.5, 0.70710678118654752, 1.4142135623730951, 2};
  const int cells = std::max(1, static_cast<int>(cells_ * kRatios[scale]));
  right_.set(cells);
  right_cell_.resize(index_.size());
  const auto size = static_cast<float>(cells);
  for (std::size_t k = 0; k < index_.size(); ++k)
    right_cell_[k] = static_cast<std::uint16_t>(static_cast<int>(second_[k].y * size) * cells +
                                                static_cast<int>(second_[k].x * size));
  const std::size_t rows = square(cells_) + 1;
  const std::size_t columns = square(cells);
  if (columns_ != columns || pairs_.size() < rows * columns) pairs_.assign(rows * columns, 0);
  columns_ = columns;  // pairs_ is all zero between calls
}

inline std::size_t GridMotionStatistics::judge(int turn) {
  const std::size_t n = index_.size();
  agreed_.assign(n, 0);
  for (const std::vector<std::uint16_t>& left : left_cell_) {
    count(left);
    if (params_.every_pair)
      verify_matches(left, turn);
    else
      verify_cells(left, turn);
    for (std::size_t k = 0; k < n; ++k) pairs_[left[k] * columns_ + right_cell_[k]] = 0;
  }
  std::size_t agreed = 0;
  for (const std::uint8_t a : agreed_) agreed += a;
  return agreed;
}

inline void GridMotionStatistics::count(const std::vector<std::uint16_t>& left) {
  const std::size_t cells = square(cells_);
  in_cell_.assign(cells + 1, 0);
  best_partner_.assign(cells + 1, 0);
  for (std::size_t k = 0; k < left.size(); ++k) {
    const std::uint32_t l = left[k], r = right_cell_[k];
    std::uint16_t& together = pairs_[l * columns_ + r];
    together = static_cast<std::uint16_t>(together + (together < kMost ? 1 : 0));
    ++in_cell_[l];
    best_partner_[l] = std::max(best_partner_[l], std::uint32_t{together} << 16U | (kMost - r));
  }
  sum_around();
}

inline void GridMotionStatistics::sum_around() {
  const auto size = static_cast<std::size_t>(cells_), cells = size * size;
  in_three_.assign(cells, 0);
  around_.assign(cells, 0);
  for (std::size_t l = 1; l + 1 < cells; ++l) in_three_[l] = in_cell_[l - 1] + in_cell_[l] + in_cell_[l + 1];
  for (std::size_t l = size; l + size < cells; ++l)
    around_[l] = in_three_[l - size] + in_three_[l] + in_three_[l + size];
}

inline void GridMotionStatistics::verify_matches(const std::vector<std::uint16_t>& left, int turn) {
  const Turned turned(left_, right_, turn);
  const auto nowhere = static_cast<std::uint32_t>(cells_ * cells_);
  for (std::size_t k = 0; k < left.size(); ++k)
    if (agreed_[k] == 0 && left[k] != nowhere && supported(left[k], right_cell_[k], turned)) agreed_[k] = 1;
}

inline void GridMotionStatistics::verify_cells(const std::vector<std::uint16_t>& left, int turn) {
  const Turned turned(left_, right_, turn);
  const auto cells = static_cast<std::uint32_t>(cells_ * cells_);
  target_.assign(cells + 1, kNone);
  for (std::uint32_t l = 0; l < cells; ++l) {
    if (in_cell_[l] == 0) continue;
    const std::uint32_t r = kMost - (best_partner_[l] & kMost);
    if (supported(l, r, turned)) target_[l] = static_cast<std::uint16_t>(r);
  }
  for (std::size_t k = 0; k < left.size(); ++k)
    agreed_[k] |= static_cast<std::uint8_t>(target_[left[k]] == right_cell_[k] ? 1 : 0);
}

DYNFILTER_INLINE GridMotionStatistics::Turned::Turned(const Side& left, const Side& right, int turn) {
  const auto columns = static_cast<std::ptrdiff_t>(right.cells) * right.cells;
  for (std::size_t j = 0; j < 9; ++j) {
    bit[j] = static_cast<unsigned>(turned(static_cast<int>(j), turn));
    offset[j] = left.offset[j] * columns + right.offset[bit[j]];
  }
}

inline bool GridMotionStatistics::supported(std::uint32_t l, std::uint32_t r, const Turned& turned) const {
  std::uint32_t support = 0, matches = 0;
  int common = 0;
  const unsigned here = left_.around[l], there = right_.around[r];
  const std::uint16_t* pairs = &pairs_[l * columns_ + r];
  constexpr unsigned kAll = 0x1FF;
  if (here == kAll && there == kAll) {
    common = 9;
    matches = around_[l];
    for (const std::ptrdiff_t offset : turned.offset) support += pairs[offset];
  } else {
    for (std::size_t j = 0; j < 9; ++j) {
      if ((here >> j & there >> turned.bit[j] & 1U) == 0) continue;
      support += pairs[turned.offset[j]];
      matches += in_cell_[l + static_cast<std::size_t>(left_.offset[j])];
      ++common;
    }
  }
  // support >= factor * sqrt(matches / common)
  const double s = support;
  return s * s * common >= params_.factor * params_.factor * matches;
}

DYNFILTER_INLINE std::size_t GridMotionStatistics::turned(int j, int turn) {
  static constexpr int kRing[8] = {0, 1, 2, 5, 8, 7, 6, 3}, kPlace[9] = {0, 1, 2, 7, -1, 3, 6, 5, 4};
  return static_cast<std::size_t>(j == 4 ? 4 : kRing[(kPlace[j] + 8 - turn) % 8]);
}

}  // namespace dynfilter
