// SPDX-License-Identifier: MIT
// The AVX2 loops over points at every address that a float may have. The heap aligns to 16 bytes, the sanitizers' heap
// to more: neither shows a load that needs 32.
#include <algorithm>
#include <cstdint>
#include <dynfilter/geometry/detail/rigid_least_squares.hpp>
#include <dynfilter/geometry/detail/rigid_points.hpp>
#include <dynfilter/geometry/detail/rigid_sums_avx2.hpp>
#include <vector>

#include "doctest/doctest.h"
#include "geometry/rigid_scene.hpp"

#if defined(DYNFILTER_X86)
namespace misaligned_rows_test {

using namespace dynfilter;
using detail::RigidPoints;

TEST_CASE("rigid motion: rows at every address score and add up to the scalar loop's bits") {
  if (!uses_avx2()) {
    MESSAGE("no AVX2 here");
    return;
  }
  const geometry_test::RigidScene scene(203, 0.3, 5, 1);
  RigidPoints points;
  points.wide = false;
  points.pack(geometry_test::camera(), {RigidResidualKind::ImageDepth, 1.0, DepthNoise()}, scene.reference,
              scene.current, scene.all());
  const detail::RigidTransform T{scene.truth.R(), scene.truth.t()};
  detail::RigidSumsInput in{
      nullptr, points.stride, points.count, points.image_depth, RobustLoss::Cauchy, 12.25F, {}};
  RigidPoints::to_float(T, in.m);
  const float score = points.block_score(in.m, 1 / 11.34F, 0, points.stride);
  const detail::RigidNormal normal = accumulate_rigid(points, in.loss, 12.25, points.count, T);
  CHECK(score > 20.0F);

  constexpr std::size_t kRegister = 32 / sizeof(float);
  std::vector<float> memory(points.data.size() + 2 * kRegister);
  const std::size_t past = reinterpret_cast<std::uintptr_t>(memory.data()) / sizeof(float) % kRegister;
  for (std::size_t offset = 0; offset < kRegister; ++offset) {
    CAPTURE(offset);
    float* rows = memory.data() + (kRegister - past) + offset;
    std::copy(points.data.begin(), points.data.end(), rows);
    CHECK(detail::rigid_block_score_avx2(rows, points.stride, in.m, 1 / 11.34F, 0, points.stride) == score);
    in.rows = rows;
    const detail::RigidNormal wide = detail::accumulate_rigid_avx2(in);
    CHECK(wide.matrix() == normal.matrix());
    CHECK(wide.gradient() == normal.gradient());
    CHECK(wide.cost == normal.cost);
  }
}

}  // namespace misaligned_rows_test
#endif
