// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/types.hpp>
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
  bool rotation = false;  ///< tests eight rotations between the images and keeps the best
  /// Tests five scale ratios between the images, 1/2 to 2, and keeps the best.
  bool scale = false;
};

/// Grid-based motion statistics (Bian et al., CVPR 2017).
/// A match is kept if enough matches of the 3 x 3 cells around it agree.
/// A match agrees if it leads to the corresponding cell around the target.
/// The first image's grid is placed four times, shifted by half a cell.
/// A match is kept if one placement keeps it.
///
/// The published code uses only the most frequent partner of each cell.
/// It thereby loses matches that parallax moves to the next cell.
/// Cells are bounds-checked here: points on or beyond the border count in the last cell.
/// The published code reads out of range there.
/// Points that are not finite are neither kept nor counted.
///
/// Cost: four passes over the matches, times 8 with rotation and times 5 with scale.
/// The counters (0.3 MB for 20 x 20 cells) are reused from call to call.
class GridMotionStatistics {
 public:
  /// Throws ConfigError for parameters out of range.
  explicit GridMotionStatistics(const GmsParams& params = GmsParams());
  const GmsParams& params() const { return params_; }

  /// `first[i]` and `second[i]` [px] match where `valid[i]` is not 0; an empty `valid` means all.
  /// Sets `kept` to 1 for matches with enough support. Returns their number.
  std::size_t run(Span<const cv::Point2f> first, const cv::Size& first_size, Span<const cv::Point2f> second,
                  const cv::Size& second_size, Span<const std::uint8_t> valid,
                  std::vector<std::uint8_t>& kept);

  /// Cells per side for this number of matches.
  int cells_for(std::size_t matches) const;

 private:
  static std::size_t square(int side) {
    return static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  }

  /// A cell, and one bit for each of its 3 x 3 neighbours that exists, row by row.
  struct Side {
    int cells = 0;
    std::vector<std::uint16_t> around;
    std::array<int, 9> offset{};

    void set(int per_side);
  };

  void collect(Span<const cv::Point2f> first, const cv::Size& first_size, Span<const cv::Point2f> second,
               const cv::Size& second_size, Span<const std::uint8_t> valid);

  /// Groups the matches by cell, so that a cell's counters remain in the cache.
  void sort_by_cell();

  /// Computes the four placements of the first image's grid.
  /// Matches in a half cell at the border belong to an extra cell that is never judged.
  void lay_left_grids();

  void lay_right_grid(int scale);

  /// Judges all four placements for one rotation. Returns how many matches agree.
  std::size_t judge(int turn);

  /// Counts matches per cell and per pair of cells, and finds the most frequent partner.
  /// The first of equally frequent partners is used.
  void count(const std::vector<std::uint16_t>& left);
  /// Sums the matches of the 3 x 3 cells around each cell.
  void sum_around();

  void verify_matches(const std::vector<std::uint16_t>& left, int turn);
  /// Judges only matches to the most frequent partner of their cell.
  void verify_cells(const std::vector<std::uint16_t>& left, int turn);

  /// Neighbours in the second image, in the order of the first image's neighbours.
  struct Turned {
    Turned(const Side& left, const Side& right, int turn);
    std::array<unsigned, 9> bit{};
    std::array<std::ptrdiff_t, 9> offset{};  ///< of the pair of neighbours, in pairs_
  };
  bool supported(std::uint32_t l, std::uint32_t r, const Turned& turned) const;
  /// Index of neighbour j of 3 x 3 after `turn` eighths of a rotation.
  static std::size_t turned(int j, int turn);

  static constexpr std::uint32_t kMost = 0xFFFF;
  static constexpr std::uint16_t kNone = 0xFFFF;

  GmsParams params_;
  int cells_ = 0;
  Side left_, right_;
  std::vector<std::uint32_t> index_, sorted_index_;
  std::vector<cv::Point2f> first_, second_;  ///< in units of the image size
  std::vector<cv::Point2f> sorted_first_, sorted_second_;
  std::array<std::vector<std::uint16_t>, 4> left_cell_;
  std::vector<std::uint16_t> right_cell_;
  std::size_t columns_ = 0;
  std::vector<std::uint16_t> pairs_;  ///< count per left and right cell
  std::vector<std::uint32_t> in_cell_, in_three_, around_, best_partner_;
  std::vector<std::uint16_t> target_;
  std::vector<std::uint8_t> agreed_, best_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/grid_motion_statistics-inl.hpp>
#endif
