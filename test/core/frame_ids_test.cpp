// SPDX-License-Identifier: MIT
#include <dynfilter/core/limits.hpp>

#include "doctest/doctest.h"

namespace frame_ids_test {

using namespace dynfilter;

TEST_CASE("the gap of two ids is their difference, and does not wrap") {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max(),
                         kLeast = std::numeric_limits<std::int64_t>::min();
  CHECK(id_gap(7, 4) == 3);
  CHECK(id_gap(4, 7) == -3);
  CHECK(id_gap(-2, -2) == 0);
  CHECK(id_gap(kMost, 0) == kMost);
  CHECK(id_gap(kMost, -1) == kMost);
  CHECK(id_gap(kMost, kLeast) == kMost);
  CHECK(id_gap(kLeast, kMost) == -kMost);
  CHECK(id_gap(kLeast, kLeast) == 0);
  CHECK(id_gap(kLeast + 1, 0) == -kMost);
}

}  // namespace frame_ids_test
