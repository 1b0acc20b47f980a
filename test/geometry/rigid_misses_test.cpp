// SPDX-License-Identifier: MIT
#include <dynfilter/geometry/rigid_misses.hpp>

#include "doctest/doctest.h"
#include "rigid_scene.hpp"

namespace rigid_misses_test {

using namespace dynfilter;
using geometry_test::camera;
using geometry_test::RigidScene;

namespace {

RigidMisses measured(const RigidScene& scene, const Pose& T, const std::vector<int>& points) {
  const std::vector<cv::Point2f> pixels(scene.current.size(), {320, 240});
  RigidMisses misses;
  misses.measure(camera(), T, {scene.reference, scene.current, pixels}, points);
  return misses;
}

}  // namespace

TEST_CASE("scaled depth noise is so many times as large at every depth") {
  for (const double z_m : {0.5, 2.0, 6.0})
    CHECK(DepthNoise().scaled(3).sigma_m(z_m) == doctest::Approx(3 * DepthNoise().sigma_m(z_m)));
}

TEST_CASE("the true motion leaves nothing, a shift by t leaves f t / z") {
  const RigidScene scene(200, 0, 1, 0);
  const RigidMisses exact = measured(scene, scene.truth, scene.all());
  for (const Miss& miss : exact.misses()) CHECK(cv::norm(miss.miss_px) < 1e-2);
  constexpr double kShift_m = 0.05;
  const Pose shifted = Pose::from(scene.truth.R(), scene.truth.t() + Eigen::Vector3d(kShift_m, 0, 0));
  const RigidMisses misses = measured(scene, shifted, scene.all());
  REQUIRE(misses.misses().size() == 200);
  for (const Miss& miss : misses.misses()) {
    CHECK(miss.miss_px.x == doctest::Approx(-camera().fx_px * kShift_m / miss.depth_m).epsilon(1e-2));
    CHECK(std::abs(miss.miss_px.y) < 1e-2);
  }
}

TEST_CASE("the factor of the depths is their error over the model's, at least 1; few points give 1") {
  const RigidScene as_modelled(2000, 0, 2, 0.5), worse(2000, 0, 2, 3);
  CHECK(measured(as_modelled, as_modelled.truth, as_modelled.all()).depth_factor() == 1);
  const RigidMisses misses = measured(worse, worse.truth, worse.all());
  CHECK(misses.depth_factor() > 2.7);
  CHECK(misses.depth_factor() < 3.3);
  CHECK(measured(worse, worse.truth, {0, 1, 2, 3}).depth_factor() == 1);
  CHECK(measured(worse, worse.truth, {}).misses().empty());
}

}  // namespace rigid_misses_test
