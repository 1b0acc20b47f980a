// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace dynfilter {

/// The occupied cells of a grid of any extent, sorted by row, then by column. For points that are so far apart
/// that a table of all cells would need cells too large to separate them.
/// Building costs O(n log n), a range O(log n).
class SparseCells {
 public:
  using Key = std::uint64_t;
  static constexpr Key kNoCell = std::numeric_limits<Key>::max();

  static Key key(int row, int column) {
    return static_cast<Key>(static_cast<std::uint32_t>(row)) << 32U | static_cast<std::uint32_t>(column);
  }

  /// Puts the indices of the points into `entries`, by cell, then by index. `begin` gets the first entry of
  /// each occupied cell, and the end of the last.
  void build(const std::vector<Key>& cell_of_point, std::vector<std::int32_t>& entries,
             std::vector<std::int32_t>& begin) {
    sorted_.clear();
    for (std::size_t i = 0; i < cell_of_point.size(); ++i)
      if (cell_of_point[i] != kNoCell) sorted_.emplace_back(cell_of_point[i], static_cast<std::int32_t>(i));
    std::sort(sorted_.begin(), sorted_.end());
    keys_.clear(), begin.clear(), entries.clear();
    for (const auto& [key, index] : sorted_) {
      if (keys_.empty() || keys_.back() != key) {
        keys_.push_back(key);
        begin.push_back(static_cast<std::int32_t>(entries.size()));
      }
      entries.push_back(index);
    }
    begin.push_back(static_cast<std::int32_t>(entries.size()));
  }

  /// The occupied cells from `first` to `last`, both included, as positions in `begin`.
  std::pair<std::size_t, std::size_t> cells(Key first, Key last) const {
    const auto from = std::lower_bound(keys_.begin(), keys_.end(), first);
    const auto to = std::upper_bound(from, keys_.end(), last);
    return {static_cast<std::size_t>(from - keys_.begin()), static_cast<std::size_t>(to - keys_.begin())};
  }

 private:
  std::vector<std::pair<Key, std::int32_t>> sorted_;
  std::vector<Key> keys_;
};

/// How many points share the cell of a point, on average. `begin`: the first entry of each cell, and the end.
inline double mean_crowd(const std::vector<std::int32_t>& begin) {
  double squares = 0;
  for (std::size_t c = 0; c + 1 < begin.size(); ++c) {
    const double points = begin[c + 1] - begin[c];
    squares += points * points;
  }
  return begin.empty() || begin.back() == 0 ? 0 : squares / begin.back();
}

}  // namespace dynfilter
