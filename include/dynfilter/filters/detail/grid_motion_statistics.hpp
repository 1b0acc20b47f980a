// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

struct GmsParams {
  /// Cells per side, up to 40 (published: 20); 0: chosen from the number of matches.
  int grid_cells = 0;
  /// For grid_cells 0: mean matches per cell, within 4 to 20 cells per side.
  double matches_per_cell = 2.0;
  double factor = 3.0;  ///< a match needs factor * sqrt(n) supporters (published: 6)
  /// False, as published: only matches to the most frequent partner of a cell.
  bool every_pair = true;
};

/// Grid-based motion statistics (Bian et al., CVPR 2017). A match is kept if enough matches of the 3 x 3
/// cells around it agree. A match agrees if it leads to the corresponding cell around the target. The first
/// image's grid is placed four times, shifted by half a cell. A match is kept if one placement keeps it.
///
/// The published code uses only the most frequent partner of each cell.
/// It thereby loses matches that parallax moves to the next cell.
/// Cells are bounds-checked here: points on or beyond the border count in the last cell.
/// The published code reads out of range there. Points that are not finite are neither kept nor counted.
///
/// Cost: four passes over the matches.
/// The counters (0.3 MB for 20 x 20 cells) are reused from call to call.
class GridMotionStatistics {
 public:
  /// Throws ConfigError for parameters out of range.
  explicit GridMotionStatistics(const GmsParams& params = GmsParams()) : params_(params) {
    if (params_.grid_cells < 0 || params_.grid_cells > 40)
      throw ConfigError("grid_cells", "expected 0 to 40");
    if (!(params_.matches_per_cell > 0)) throw ConfigError("matches_per_cell", "expected more than 0");
    if (!(params_.factor >= 0)) throw ConfigError("factor", "expected >= 0");
  }
  const GmsParams& params() const { return params_; }

  /// `first[i]` and `second[i]` [px] match where `valid[i]` is not 0; an empty `valid` means all.
  /// Sets `kept` to 1 for matches with enough support. Returns their number.
  std::size_t run(Span<const cv::Point2f> first, const cv::Size& first_size, Span<const cv::Point2f> second,
                  const cv::Size& second_size, Span<const std::uint8_t> valid,
                  std::vector<std::uint8_t>& kept);

  /// Cells per side for this number of matches.
  int cells_for(std::size_t matches) const {
    if (params_.grid_cells > 0) return params_.grid_cells;
    const double cells = std::sqrt(static_cast<double>(matches) / params_.matches_per_cell);
    return static_cast<int>(std::clamp(std::round(cells), 4.0, 20.0));
  }

 private:
  static std::size_t square(int side) {
    return static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  }

  /// Sets cells_, around_cell_ and the offsets.
  void set_cells(int per_side);
  void collect(Span<const cv::Point2f> first, const cv::Size& first_size, Span<const cv::Point2f> second,
               const cv::Size& second_size, Span<const std::uint8_t> valid);

  /// Groups the matches by cell, so that a cell's counters remain in the cache.
  void sort_by_cell();

  /// Computes the four placements of the first image's grid.
  /// Matches in a half cell at the border belong to an extra cell that is never judged.
  void lay_left_grids();

  void lay_right_grid();

  /// Counts matches per cell and per pair of cells, and finds the most frequent partner.
  /// The first of equally frequent partners is used.
  void count(const std::vector<std::uint16_t>& left);
  /// Sums the matches of the 3 x 3 cells around each cell.
  void sum_around();

  void verify_matches(const std::vector<std::uint16_t>& left) {
    const auto nowhere = static_cast<std::uint32_t>(cells_ * cells_);
    for (std::size_t k = 0; k < left.size(); ++k)
      if (agreed_[k] == 0 && left[k] != nowhere && supported(left[k], right_cell_[k])) agreed_[k] = 1;
  }
  /// Judges only matches to the most frequent partner of their cell.
  void verify_cells(const std::vector<std::uint16_t>& left);

  bool supported(std::uint32_t l, std::uint32_t r) const;

  static constexpr std::uint32_t kMost = 0xFFFF;
  static constexpr std::uint16_t kNone = 0xFFFF;

  GmsParams params_;
  int cells_ = 0;                                ///< per side
  std::vector<std::uint16_t> around_cell_;       ///< one bit for each of its 3 x 3 neighbours that exists
  std::array<int, 9> offset_{};                  ///< of these neighbours, row by row
  std::array<std::ptrdiff_t, 9> pair_offset_{};  ///< of the pairs of neighbours, in pairs_
  std::vector<std::uint32_t> index_, sorted_index_;
  std::vector<cv::Point2f> first_, second_;  ///< in units of the image size
  std::vector<cv::Point2f> sorted_first_, sorted_second_;
  CellLists by_cell_;
  std::array<std::vector<std::uint16_t>, 4> left_cell_;
  std::vector<std::uint16_t> right_cell_;
  std::vector<std::uint16_t> pairs_;  ///< count per left and right cell, all zero between calls
  std::vector<std::uint32_t> in_cell_, in_three_, around_, best_partner_;
  std::vector<std::uint16_t> target_;
  std::vector<std::uint8_t> agreed_;
};

inline std::size_t GridMotionStatistics::run(Span<const cv::Point2f> first, const cv::Size& first_size,
                                             Span<const cv::Point2f> second, const cv::Size& second_size,
                                             Span<const std::uint8_t> valid,
                                             std::vector<std::uint8_t>& kept) {
  kept.assign(first.size(), 0);
  collect(first, first_size, second, second_size, valid);
  const std::size_t n = index_.size();
  if (n == 0) return 0;
  set_cells(cells_for(n));
  sort_by_cell();
  lay_left_grids();
  lay_right_grid();
  agreed_.assign(n, 0);
  for (const std::vector<std::uint16_t>& left : left_cell_) {
    count(left);
    if (params_.every_pair)
      verify_matches(left);
    else
      verify_cells(left);
    for (std::size_t k = 0; k < n; ++k) pairs_[left[k] * square(cells_) + right_cell_[k]] = 0;
  }
  for (std::size_t k = 0; k < n; ++k) kept[index_[k]] = agreed_[k];
  return static_cast<std::size_t>(std::count(agreed_.begin(), agreed_.end(), std::uint8_t{1}));
}

inline void GridMotionStatistics::set_cells(int per_side) {
  if (cells_ == per_side) return;
  cells_ = per_side;
  around_cell_.assign(square(cells_), 0);
  for (int y = 0; y < cells_; ++y)
    for (int x = 0; x < cells_; ++x)
      for (int j = 0; j < 9; ++j) {
        const int nx = x + j % 3 - 1, ny = y + j / 3 - 1, cell = y * cells_ + x;
        if (nx >= 0 && ny >= 0 && nx < cells_ && ny < cells_)
          around_cell_[static_cast<std::size_t>(cell)] |= static_cast<std::uint16_t>(1U << j);
      }
  for (std::size_t j = 0; j < 9; ++j) {
    offset_[j] = (static_cast<int>(j) / 3 - 1) * cells_ + static_cast<int>(j) % 3 - 1;
    pair_offset_[j] = std::ptrdiff_t{offset_[j]} * (cells_ * cells_ + 1);
  }
  pairs_.assign((square(cells_) + 1) * square(cells_), 0);
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
  by_cell_.build(square(cells_), index_.size(), [&](std::size_t k) { return cell(first_[k]); });
  sorted_index_.clear(), sorted_first_.clear(), sorted_second_.clear();
  for (const std::int32_t entry : by_cell_.entries()) {
    const auto k = static_cast<std::size_t>(entry);
    sorted_index_.push_back(index_[k]);
    sorted_first_.push_back(first_[k]);
    sorted_second_.push_back(second_[k]);
  }
  index_.swap(sorted_index_), first_.swap(sorted_first_), second_.swap(sorted_second_);
}

inline void GridMotionStatistics::lay_left_grids() {
  const std::size_t n = index_.size();
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

inline void GridMotionStatistics::lay_right_grid() {
  right_cell_.resize(index_.size());
  const auto size = static_cast<float>(cells_);
  for (std::size_t k = 0; k < index_.size(); ++k)
    right_cell_[k] = static_cast<std::uint16_t>(static_cast<int>(second_[k].y * size) * cells_ +
                                                static_cast<int>(second_[k].x * size));
}

inline void GridMotionStatistics::count(const std::vector<std::uint16_t>& left) {
  const std::size_t cells = square(cells_);
  in_cell_.assign(cells + 1, 0);
  best_partner_.assign(cells + 1, 0);
  for (std::size_t k = 0; k < left.size(); ++k) {
    const std::uint32_t l = left[k], r = right_cell_[k];
    std::uint16_t& together = pairs_[l * cells + r];
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

inline void GridMotionStatistics::verify_cells(const std::vector<std::uint16_t>& left) {
  const auto cells = static_cast<std::uint32_t>(cells_ * cells_);
  target_.assign(cells + 1, kNone);
  for (std::uint32_t l = 0; l < cells; ++l) {
    if (in_cell_[l] == 0) continue;
    const std::uint32_t r = kMost - (best_partner_[l] & kMost);
    if (supported(l, r)) target_[l] = static_cast<std::uint16_t>(r);
  }
  for (std::size_t k = 0; k < left.size(); ++k)
    agreed_[k] |= static_cast<std::uint8_t>(target_[left[k]] == right_cell_[k] ? 1 : 0);
}

inline bool GridMotionStatistics::supported(std::uint32_t l, std::uint32_t r) const {
  std::uint32_t support = 0, matches = 0;
  int common = 0;
  const unsigned here = around_cell_[l], there = around_cell_[r];
  const std::uint16_t* pairs = &pairs_[l * square(cells_) + r];
  constexpr unsigned kAll = 0x1FF;
  if (here == kAll && there == kAll) {
    common = 9;
    matches = around_[l];
    for (const std::ptrdiff_t offset : pair_offset_) support += pairs[offset];
  } else {
    for (std::size_t j = 0; j < 9; ++j) {
      if ((here >> j & there >> j & 1U) == 0) continue;
      support += pairs[pair_offset_[j]];
      matches += in_cell_[l + static_cast<std::size_t>(offset_[j])];
      ++common;
    }
  }
  // support >= factor * sqrt(matches / common)
  const double s = support;
  return s * s * common >= params_.factor * params_.factor * matches;
}

}  // namespace dynfilter
