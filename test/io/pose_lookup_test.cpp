// SPDX-License-Identifier: MIT

#include "io/pose_lookup.hpp"
#include "doctest/doctest.h"

namespace pose_lookup_test {

using namespace dynfilter;

namespace {

Pose turned(double angle_rad, double x_m) {
  return Pose::from(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {x_m, 0, 0});
}

}  // namespace

TEST_CASE("a pose between two is half way in place and angle") {
  const io::PoseLookup lookup({{10, turned(0, 0)}, {10.1, turned(0.2, 1)}, {11, turned(0, 5)}});
  const Pose half = *lookup.at(10.05);
  CHECK(half.translation_m[0] == doctest::Approx(0.5));
  CHECK(half.rotation[0] == doctest::Approx(std::cos(0.1)));
  CHECK(lookup.at(10.1003)->translation_m[0] == 1);
  CHECK(lookup.at(9.9998)->translation_m[0] == 0);
  CHECK_FALSE(lookup.at(10.5));  // a gap
  CHECK_FALSE(lookup.at(9.9));
  CHECK_FALSE(lookup.at(11.1));
  CHECK(lookup.gaps().first == 1);
  CHECK(lookup.gaps().second == doctest::Approx(0.9));
  CHECK_FALSE(io::PoseLookup({}).at(1));
}

TEST_CASE("poses are aligned also when the camera stands still") {
  const Pose T = turned(0.7, 3);
  io::Trajectory truth, estimate;
  for (int i = 0; i < 5; ++i) {
    const Pose camera = turned(1e-3 * i, 0.5);
    estimate.push_back({i * 0.03, camera});
    truth.push_back({i * 0.03, T * camera});
  }
  const Pose found = *io::align_poses(truth, estimate);
  CHECK((found.R() - T.R()).norm() < 1e-9);
  CHECK((found.t() - T.t()).norm() < 1e-9);
  CHECK_FALSE(io::align_poses(truth, {}));
}

}  // namespace pose_lookup_test
