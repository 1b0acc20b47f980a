// SPDX-License-Identifier: MIT
// CTest runs this file also with a value of DYNFILTER_SIMD that does not exist.
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>

#include "doctest/doctest.h"

namespace simd_choice_test {

using namespace dynfilter;

TEST_CASE("DYNFILTER_SIMD: a pipeline refuses an unknown value") {
  const auto make = [] {
    Pipeline(pipeline_from_text("pipeline:\n  before_pose: [ semantic_box ]\n", builtin_filters()));
  };
  if (simd_choice() != SimdChoice::Unknown) {
    CHECK_NOTHROW(make());
    return;
  }
  CHECK_THROWS_WITH_AS(make(), doctest::Contains("DYNFILTER_SIMD: expected auto or baseline"), ConfigError);
  CHECK_FALSE(uses_avx2());
}

}  // namespace simd_choice_test
