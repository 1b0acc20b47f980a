// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cells.hpp>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "doctest/doctest.h"

namespace cells_test {

using dynfilter::CellLists;
using dynfilter::ImageCells;
using Key = CellLists::Key;

namespace {

/// Random keys below `limit`, a tenth of them kNoCell.
std::vector<Key> random_keys(std::size_t n, Key limit, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<Key> keys(n);
  for (Key& key : keys) key = random() % 10 == 0 ? CellLists::kNoCell : random() % limit;
  return keys;
}

std::map<Key, std::vector<std::int32_t>> lists_of(const std::vector<Key>& keys) {
  std::map<Key, std::vector<std::int32_t>> lists;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i] != CellLists::kNoCell) lists[keys[i]].push_back(static_cast<std::int32_t>(i));
  return lists;
}

std::vector<std::int32_t> list_of(const CellLists& cells, std::size_t list) {
  return {cells[list].begin(), cells[list].end()};
}

void check_occupied(CellLists& cells, const std::vector<Key>& keys) {
  cells.build_occupied(keys.size(), [&](std::size_t i) { return keys[i]; });
  const auto lists = lists_of(keys);
  REQUIRE(cells.size() == lists.size());
  std::size_t list = 0;
  for (const auto& [key, items] : lists) {
    CHECK(cells.keys()[list] == key);
    CHECK(list_of(cells, list++) == items);
  }
}

}  // namespace

TEST_CASE("lists of occupied cells are those of a map, whatever the keys") {
  CellLists cells;
  CHECK(cells.size() == 0);
  unsigned seed = 1;
  // Few items are sorted by comparison, many by digits, and those with long keys without packing.
  for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{50}, std::size_t{3000}})
    for (const int bits : {0, 1, 11, 22, 40, 52, 63})
      check_occupied(cells, random_keys(n, Key{1} << bits, ++seed));
  check_occupied(cells, {CellLists::kNoCell, CellLists::kNoCell});
  check_occupied(cells, {CellLists::kNoCell - 1, 0, CellLists::kNoCell - 1});
}

TEST_CASE("lists of all cells are those of a map, and ranges are the same with both") {
  CellLists all, occupied;
  constexpr Key kCells = 97;
  for (const std::size_t n : {std::size_t{0}, std::size_t{40}, std::size_t{2000}}) {
    const std::vector<Key> keys = random_keys(n, kCells - 7, 5);
    const auto key = [&](std::size_t i) { return keys[i]; };
    all.build(kCells, n, key);
    occupied.build_occupied(n, key);
    auto lists = lists_of(keys);
    REQUIRE(all.size() == kCells);
    for (Key c = 0; c < kCells; ++c) CHECK(list_of(all, c) == lists[c]);
    CHECK(all.entries() == occupied.entries());
    CHECK(all.crowd() == doctest::Approx(occupied.crowd()));
    if (n == 0) continue;
    for (Key first = 0; first < kCells; first += 5)
      for (Key last = first; last < kCells; last += 9) {
        const auto range = all.range(first, last), same = occupied.range(first, last);
        CHECK(range.second - range.first == same.second - same.first);
        if (range.first < range.second) CHECK(range == same);
      }
  }
}

TEST_CASE("how many items share the cell of an item") {
  CellLists cells;
  CHECK(cells.crowd() == 0);
  const std::vector<Key> keys{5, 5, 5, 9};  // (3 * 3 + 1) / 4
  cells.build_occupied(keys.size(), [&](std::size_t i) { return keys[i]; });
  CHECK(cells.crowd() == 2.5);
  cells.clear();
  CHECK(cells.size() == 0);
  CHECK(cells.crowd() == 0);
}

TEST_CASE("cells of an image, and what is beyond it") {
  const ImageCells<double> cells{640, 480, 4, 3};
  CHECK(cells.count() == 12);
  CHECK(cells.of(0, 0) == 0);
  CHECK(cells.of(159.9, 0) == 0);
  CHECK(cells.of(160, 0) == 1);
  CHECK(cells.of(160, 159.9) == 1);
  CHECK(cells.of(160, 160) == 5);
  CHECK(cells.of(640, 480) == 11);
  CHECK(cells.of(1e30, 1e30) == 11);
  CHECK(cells.of(-1e30, -1e30) == 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(cells.of(nan, 470) == 8);
  CHECK(cells.of(630, nan) == 3);
  const ImageCells<float> centred{640, 480, 4, 3, 0.5F};
  CHECK(centred.of(-320, -240) == 0);
  CHECK(centred.of(0, 0) == 6);
  CHECK(centred.of(319, 239) == 11);
  const ImageCells<float> none{0, 0, 4, 3};
  CHECK(none.of(-3, 0) == 0);
}

}  // namespace cells_test
