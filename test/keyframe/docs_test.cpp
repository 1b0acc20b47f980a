// SPDX-License-Identifier: MIT
#include <dynfilter/keyframe/make_selector.hpp>

#include "doctest/doctest.h"
#include "support/parameter_tables.hpp"

namespace docs_test {

using namespace dynfilter;

TEST_CASE("the tables of docs/reference/keyframes.md are those of the parameters") {
  dynfilter_test::check_parameter_tables(
      "docs/reference/keyframes.md",
      {{"pose_change", dynfilter_test::parameter_table<PoseChangeParams>()},
       {"vertex_cover", dynfilter_test::parameter_table<VertexCoverParams>()}});
}

}  // namespace docs_test
