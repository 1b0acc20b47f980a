// SPDX-License-Identifier: MIT
#include <memory>
#include <odometry/numbered.hpp>
#include <random>
#include <set>

#include "doctest/doctest.h"

namespace numbered_test {

using namespace dynfilter::odometry;

TEST_CASE("indices of the newest elements remain when older ones go") {
  NewestOf<int> values;
  CHECK(values.empty());
  for (int i = 0; i < 10; ++i) values.push_back(100 + i);
  for (int i = 0; i < 4; ++i) values.remove_first();
  CHECK(values.first() == 4);
  CHECK(values.size() == 10);
  CHECK(values.count() == 6);
  for (int i = 4; i < 10; ++i) CHECK(values[i] == 100 + i);
  values.push_back(110);
  CHECK(values[10] == 110);
  CHECK(values.back() == 110);
  CHECK_FALSE(values.empty());
}

TEST_CASE("elements are removed in any order, the others stay where they are, and memory is freed") {
  const auto counted = std::make_shared<int>(0);
  SparseVector<std::shared_ptr<int>> values;
  std::set<std::int64_t> present;
  std::mt19937 random(3);
  for (std::int64_t i = 0; i < 1000; ++i) {
    values.push_back(counted);
    present.insert(i);
    if (random() % 3 == 0) {
      const std::int64_t gone = static_cast<std::int64_t>(random() % present.size());
      const auto at = std::next(present.begin(), gone);
      values.remove(*at);
      present.erase(at);
    }
  }
  CHECK(values.size() == 1000);
  CHECK(counted.use_count() == static_cast<long>(present.size()) + 1);
  for (std::int64_t i = -3; i < 1003; ++i) CHECK(values.has(i) == (present.count(i) > 0));
  for (const std::int64_t i : present) CHECK(values[i].get() == counted.get());
  CHECK(values.first() <= *present.begin());
  for (const std::int64_t i : present) values.remove(i);
  CHECK(values.first() >= 992);  // only the last page is left
  CHECK(counted.use_count() == 1);
  for (std::int64_t i = 0; i < 1000; ++i) CHECK_FALSE(values.has(i));
  values.push_back(counted);
  CHECK(values.has(1000));
}

}  // namespace numbered_test
