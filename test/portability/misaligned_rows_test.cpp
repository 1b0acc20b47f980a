// SPDX-License-Identifier: MIT
// The loops over points with rows at every address that a float may have. The heap aligns to 16 bytes, the
// sanitizers' heap to more: neither shows a load that needs 32.
#include <algorithm>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/geometry/detail/rigid_points.hpp>
#include <dynfilter/geometry/rigid_least_squares.hpp>

#include "doctest/doctest.h"
#include "geometry/rigid_scene.hpp"

namespace misaligned_rows_test {

using namespace dynfilter;
using detail::RigidPoints;

namespace {

/// The same rows, each `more` floats further behind the one before.
RigidPoints moved_apart(const RigidPoints& points, std::size_t more) {
  RigidPoints out = points;
  out.stride += more;
  out.data.assign(out.stride * RigidPoints::kRows, 0);
  for (int r = 0; r < RigidPoints::kRows; ++r) std::copy_n(points.row(r), points.stride, &out.at(r, 0));
  return out;
}

}  // namespace

TEST_CASE("rigid motion: rows at every address score and add up to the same bits, wide and narrow") {
  if (!uses_avx2()) MESSAGE("no AVX2 here: both take the same path");
  const geometry_test::RigidScene scene(203, 0.3, 5, 1);
  RigidPoints points;
  points.wide = false;
  points.pack(geometry_test::camera(), {1.0, DepthNoise()}, scene.reference, scene.current, scene.all());
  const detail::RigidTransform T{scene.truth.R(), scene.truth.t()};
  float m[12];
  RigidPoints::to_float(T, m);
  const std::size_t end = points.stride;
  const float score = points.block_score(m, 1 / 11.34F, 0, end);
  const detail::RigidNormal normal = accumulate_rigid(points, 12.25, points.count, T);
  CHECK(score > 20.0F);
  for (std::size_t more = 0; more < 32 / sizeof(float); ++more) {
    CAPTURE(more);
    RigidPoints apart = moved_apart(points, more);
    for (const bool wide : {false, true}) {
      apart.wide = wide;
      CHECK(apart.block_score(m, 1 / 11.34F, 0, end) == score);
      const detail::RigidNormal found = accumulate_rigid(apart, 12.25, points.count, T);
      CHECK(found.matrix == normal.matrix);
      CHECK(found.gradient == normal.gradient);
      CHECK(found.cost == normal.cost);
    }
  }
}

}  // namespace misaligned_rows_test
