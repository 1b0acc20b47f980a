// SPDX-License-Identifier: MIT
#include "support/two_frames.hpp"

#include "doctest/doctest.h"

namespace two_frames_test {

// benchmark/two_frames_benchmark.cpp measures this over many pairs, scenes and gaps.
TEST_CASE("two consecutive frames with people, at first sight: what moves is found, and little else") {
  dynfilter::render::SequenceRenderer renderer(two_frames::options("walking_xyz", 1, 1));
  dynfilter::eval::Classification counts;
  for (const int first : {20, 37, 54}) counts.add(two_frames::judge(renderer, first, 1));
  CHECK(counts.dynamic_rejected + counts.dynamic_kept > 300);
  CHECK(counts.recall() >= 0.9);
  CHECK(counts.precision() >= 0.9);
}

}  // namespace two_frames_test
