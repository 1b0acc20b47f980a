// SPDX-License-Identifier: MIT
#include <dynfilter/config/near_miss.hpp>

#include "doctest/doctest.h"

namespace near_miss_test {

using namespace dynfilter;

TEST_CASE("edit distance: changes, additions, omissions and swaps of neighbours count one each") {
  CHECK(edit_distance("", "") == 0);
  CHECK(edit_distance("abc", "") == 3);
  CHECK(edit_distance("pipeline", "pipeline") == 0);
  CHECK(edit_distance("Pipeline", "pipeline") == 0);
  CHECK(edit_distance("pipelin", "pipeline") == 1);
  CHECK(edit_distance("piepline", "pipeline") == 1);
  CHECK(edit_distance("pipelines", "pipeline") == 1);
  CHECK(edit_distance("baseline", "pipeline") == 3);
  CHECK(edit_distance("kitten", "sitting") == 3);
}

TEST_CASE("the nearest name is offered, and none where nothing is near") {
  const std::vector<std::string> names{"rts_slam", "rts_slam_g", "dynfilter", "none"};
  CHECK(near_miss("rtsslam", names) == "rts_slam");
  CHECK(near_miss("rts_slam_q", names) == "rts_slam_g");
  CHECK(near_miss("dynflter", names) == "dynfilter");
  CHECK(near_miss("oracle", names).empty());
  CHECK(near_miss(std::string(100000, 'x'), names).empty());
  CHECK(did_you_mean("nome", names) == " (did you mean `none`?)");
  CHECK(did_you_mean("x", names).empty());
}

TEST_CASE("a name that only lacks its end is offered") {
  const std::vector<std::string> names{"min_features", "max_distance_px", "max_gap_s"};
  CHECK(near_miss("max_distance", names) == "max_distance_px");
  CHECK(near_miss("max_dist", names) == "max_distance_px");
  CHECK(near_miss("ma", names).empty());
}

TEST_CASE("errors about unknown names quote them shortened and offer the nearest") {
  CHECK(unknown_name("key", "limt", {"limit", "mark"}) ==
        "unknown key `limt` (did you mean `limit`?); known keys: limit, mark");
  CHECK(unknown_name("key", "x", {}) == "unknown key `x`; known keys: none");
  CHECK(expected_one_of({"prior", "reject"}, "rejct") ==
        "expected one of prior, reject, got `rejct` (did you mean `reject`?)");
  CHECK(unknown_name("key", std::string(9000, 'x') + "\n", {"a"}) ==
        "unknown key `" + std::string(60, 'x') + "...`; known keys: a");
}

}  // namespace near_miss_test
