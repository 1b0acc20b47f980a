// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/span.hpp>
#include <limits>
#include <utility>
#include <vector>

namespace dynfilter {

/// The cell, out of `cells`, that a coordinate in cells is in.
/// Coordinates beyond them are in the first or the last, NaN in the first.
template <class T>
int cell_along(T at, int cells) {
  return at > 0 ? static_cast<int>(std::min(at, static_cast<T>(cells - 1))) : 0;
}

/// An image divided into equal cells, row by row.
template <class T>
struct ImageCells {
  T width_px = 0, height_px = 0;
  int columns = 1, rows = 1;
  T origin = 0;  ///< [image sizes] where the coordinates begin: 0 at the left and the top, 0.5 in the middle

  int count() const { return columns * rows; }  ///< number of cells
  /// The cell of a place, in the units of the width and the height.
  int of(T x, T y) const {
    return cell_along((y / height_px + origin) * static_cast<T>(rows), rows) * columns +
           cell_along((x / width_px + origin) * static_cast<T>(columns), columns);
  }
};

/// Items sorted by the number of their cell. Items of one cell keep their order. Rebuilding reuses memory.
class CellLists {
 public:
  using Key = std::uint64_t;
  static constexpr Key kNoCell = std::numeric_limits<Key>::max();  ///< of items that are left out

  /// A list for each of `cells` cells. key(i) is the cell of item i, and kNoCell leaves it out.
  /// Cost: O(n + cells).
  template <class KeyOf>
  void build(std::size_t cells, std::size_t n, const KeyOf& key) {
    occupied_ = false;
    cell_of_.resize(n);
    begin_.assign(cells + 1, 0);
    for (std::size_t i = 0; i < n; ++i) {
      cell_of_[i] = static_cast<std::uint32_t>(key(i));
      if (cell_of_[i] != kNone) ++begin_[std::size_t{cell_of_[i]} + 1];
    }
    for (std::size_t c = 0; c < cells; ++c) begin_[c + 1] += begin_[c];
    entries_.resize(begin_.back());
    next_.assign(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < n; ++i)
      if (cell_of_[i] != kNone) entries_[next_[cell_of_[i]]++] = static_cast<std::int32_t>(i);
  }

  /// A list for each occupied cell, in the order of the keys, which may be any. Cost: O(n), with more passes
  /// for keys of more bits. Keys that leave too few bits for the index are sorted in O(n log n).
  template <class KeyOf>
  void build_occupied(std::size_t n, const KeyOf& key) {
    key_of_.resize(n);
    Key largest = 1;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n; ++i) {
      key_of_[i] = key(i);
      if (key_of_[i] == kNoCell) continue;
      largest = std::max(largest, key_of_[i]);
      ++kept;
    }
    entries_.resize(kept);
    if (const int key_bits = bits_of(largest), shift = bits_of(n); key_bits + shift <= 64)
      sort_packed(key_bits, shift);
    else
      sort_wide();
    occupied_ = true;
  }
  void clear() { entries_.clear(), begin_.clear(); }

  /// Number of lists.
  std::size_t size() const { return begin_.empty() ? 0 : begin_.size() - 1; }
  /// The items of one list, in their order.
  Span<const std::int32_t> operator[](std::size_t list) const {
    return {entries_.data() + begin_[list], std::size_t{begin_[list + 1]} - begin_[list]};
  }
  /// The items, list by list.
  const std::vector<std::int32_t>& entries() const { return entries_; }
  /// Where each list begins in entries(), and the end of the last.
  const std::vector<std::uint32_t>& starts() const { return begin_; }
  /// The cell of each list, after build_occupied().
  const std::vector<Key>& keys() const { return keys_; }

  /// Where in entries() the items of the cells from `first` to `last` begin and end.
  std::pair<std::size_t, std::size_t> range(Key first, Key last) const {
    if (!occupied_) return {begin_[first], begin_[last + 1]};
    const auto from = std::lower_bound(keys_.begin(), keys_.end(), first);
    const auto to = std::upper_bound(from, keys_.end(), last);
    return {begin_[static_cast<std::size_t>(from - keys_.begin())],
            begin_[static_cast<std::size_t>(to - keys_.begin())]};
  }

  /// How many items share the cell of an item, on average.
  double crowd() const {
    double squares = 0;
    for (std::size_t list = 0; list < size(); ++list) {
      const double items = begin_[list + 1] - begin_[list];
      squares += items * items;
    }
    return entries_.empty() ? 0 : squares / static_cast<double>(entries_.size());
  }

 private:
  static constexpr std::uint32_t kNone = static_cast<std::uint32_t>(kNoCell);
  static constexpr int kDigitBits = 11;  ///< counts of a pass that fit the first cache

  static int bits_of(Key value) {
    int bits = 0;
    for (; value != 0; value >>= 1U) ++bits;
    return bits;
  }

  /// Sorts the items by key_of_, both packed into one number.
  void sort_packed(int key_bits, int shift) {
    packed_.resize(entries_.size());
    for (std::size_t i = 0, e = 0; i < key_of_.size(); ++i)
      if (key_of_[i] != kNoCell) packed_[e++] = key_of_[i] << shift | i;
    const int passes = (key_bits + kDigitBits - 1) / kDigitBits, digit = (key_bits + passes - 1) / passes;
    if (static_cast<std::size_t>(passes) << digit > 8 * packed_.size())
      std::sort(packed_.begin(), packed_.end());
    else
      for (int pass = 0; pass < passes; ++pass) sort_by_digit(shift + pass * digit, digit);
    const Key item = (Key{1} << shift) - 1;
    for (std::size_t e = 0; e < packed_.size(); ++e)
      entries_[e] = static_cast<std::int32_t>(packed_[e] & item);
    separate([&](std::size_t e) { return packed_[e] >> shift; });
  }
  void sort_by_digit(int shift, int digit) {
    const Key mask = (Key{1} << digit) - 1;
    next_.assign(mask + 2, 0);
    for (const Key packed : packed_) ++next_[(packed >> shift & mask) + 1];
    for (std::size_t d = 1; d < next_.size(); ++d) next_[d] += next_[d - 1];
    swapped_.resize(packed_.size());
    for (const Key packed : packed_) swapped_[next_[packed >> shift & mask]++] = packed;
    packed_.swap(swapped_);
  }
  void sort_wide() {
    for (std::size_t i = 0, e = 0; i < key_of_.size(); ++i)
      if (key_of_[i] != kNoCell) entries_[e++] = static_cast<std::int32_t>(i);
    const auto key = [&](std::int32_t i) { return std::make_pair(key_of_[static_cast<std::size_t>(i)], i); };
    std::sort(entries_.begin(), entries_.end(),
              [&](std::int32_t a, std::int32_t b) { return key(a) < key(b); });
    separate([&](std::size_t e) { return key_of_[static_cast<std::size_t>(entries_[e])]; });
  }
  /// Finds where the lists begin. key(e) is that of a sorted entry.
  template <class KeyOf>
  void separate(const KeyOf& key) {
    const std::size_t n = entries_.size();
    keys_.resize(n), begin_.resize(n + 1);
    std::size_t lists = 0;
    for (std::size_t e = 0; e < n; ++e) {
      const Key of_entry = key(e);
      if (lists > 0 && keys_[lists - 1] == of_entry) continue;
      keys_[lists] = of_entry;
      begin_[lists++] = static_cast<std::uint32_t>(e);
    }
    keys_.resize(lists), begin_.resize(lists + 1);
    begin_[lists] = static_cast<std::uint32_t>(n);
  }

  bool occupied_ = false;  ///< lists of occupied cells only
  std::vector<std::int32_t> entries_;
  std::vector<std::uint32_t> begin_, next_, cell_of_;
  std::vector<Key> keys_, key_of_, packed_, swapped_;
};

}  // namespace dynfilter
