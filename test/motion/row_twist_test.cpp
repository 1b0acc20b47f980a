// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/motion/rigid_background.hpp>
#include <dynfilter/motion/row_twist.hpp>
#include <vector>

#include "doctest/doctest.h"
#include "geometry/rigid_scene.hpp"
#include "motion/scene_of.hpp"

namespace row_twist_test {

using namespace dynfilter;

namespace {

/// A still room whose camera turns by T while it reads its rows, and by `a_rad` more per image than before.
struct RolledRoom {
  std::vector<cv::Point3f> reference_m, current_m;
  std::vector<cv::Point2f> pixels;
  std::vector<float> mobility;
  std::vector<int> seeds;

  RolledRoom(const Pose& T, const Eigen::Vector3d& a_rad) {
    SampleGenerator rng(3);
    const Camera c = geometry_test::camera();
    for (int i = 0; i < 600; ++i) {
      const double z = rng.uniform(1, 3), u = rng.uniform(0, 2 * c.cx_px), v = rng.uniform(0, 2 * c.cy_px);
      const Eigen::Vector3d p((u - c.cx_px) / c.fx_px * z, (v - c.cy_px) / c.fy_px * z, z);
      const Eigen::Vector3d straight = T.R() * p + T.t();
      Eigen::Vector3d q = straight;  // solves q + s(q) a x q = straight
      for (int k = 0; k < 20; ++k) {
        const double s = (q.y() / q.z() * c.fy_px + c.cy_px) / (2 * c.cy_px) - 0.5;
        q = straight - s * a_rad.cross(q);
      }
      reference_m.emplace_back(p.x(), p.y(), p.z());
      current_m.emplace_back(q.x(), q.y(), q.z());
      pixels.emplace_back(q.x() / q.z() * c.fx_px + c.cx_px, q.y() / q.z() * c.fy_px + c.cy_px);
      mobility.push_back(0.3F);
      seeds.push_back(i);
    }
  }
  RigidBackgroundScene scene() const { return motion_test::scene_of(*this); }
};

}  // namespace

TEST_CASE("row twist: a jerk of a rolling shutter is measured, and one motion explains the room") {
  const Eigen::Vector3d a_rad(0.008, -0.006, 0.004);
  const Pose T = Pose::from(exp_so3({0.01, -0.004, 0.002}), {0.01, 0, 0.005});
  const RolledRoom room(T, a_rad);
  RigidBackgroundEstimator estimator;
  RigidBackgroundScene scene = room.scene();
  scene.elapsed_s = 1.0 / 30;
  const RigidMotion motion = estimator.estimate(scene);
  REQUIRE(motion.ok);
  // The prior of a readout that is not known pulls the twist by a share of its variance only.
  CHECK((estimator.row_twist().a_rad - a_rad).norm() < 0.03 * a_rad.norm());
  CHECK((motion.T_current_reference.R() - T.R()).norm() < 2e-4);
  CHECK(motion.inliers > 0.95 * static_cast<double>(estimator.points()));

  SUBCASE("without a time between the frames nothing is straightened") {
    scene.elapsed_s = 0;
    CHECK(estimator.estimate(scene).ok);
    CHECK(estimator.row_twist().none());
  }
}

TEST_CASE("row twist: none is found where all rows are read at once") {
  const RolledRoom room(Pose::from(exp_so3({0.01, -0.004, 0.002}), {0.01, 0, 0.005}), {0, 0, 0});
  RigidBackgroundEstimator estimator;
  RigidBackgroundScene scene = room.scene();
  scene.elapsed_s = 1.0 / 30;
  REQUIRE(estimator.estimate(scene).ok);
  CHECK(estimator.row_twist().a_rad.norm() < 1e-5);
}

// The upper third moves sideways as one. A twist about the vertical axis would explain a part of that, too.
TEST_CASE("row twist: what moves in a part of the image is no twist, while no readout is known") {
  RolledRoom room(Pose::from(exp_so3({0.01, -0.004, 0.002}), {0.01, 0, 0.005}), {0, 0, 0});
  const Camera c = geometry_test::camera();
  for (std::size_t i = 0; i < room.pixels.size(); ++i)
    if (room.pixels[i].y < 2.0 / 3 * c.cy_px) {
      room.current_m[i].x += 0.02F;
      room.pixels[i].x += static_cast<float>(c.fx_px * 0.02) / room.current_m[i].z;
    }
  RigidBackgroundEstimator estimator;
  RigidBackgroundScene scene = room.scene();
  scene.elapsed_s = 1.0 / 30;
  REQUIRE(estimator.estimate(scene).ok);
  CHECK(estimator.row_twist().none());
}

// The readout is learned although a quarter of the image moves, and the twist is believed then.
TEST_CASE("row twist: a camera whose rows are times is known after a while, with movers in every frame") {
  const Camera c = geometry_test::camera();
  RigidBackgroundEstimator estimator;
  SampleGenerator rng(11);
  Eigen::Vector3d a_rad = Eigen::Vector3d::Zero();
  for (int frame = 0; frame < 12; ++frame) {
    a_rad = 0.002 * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
    RolledRoom room(Pose::from(exp_so3(6 * a_rad / 5), {0.01, 0, 0.005}), a_rad);
    for (std::size_t i = 0; i < room.pixels.size(); ++i)
      if (room.pixels[i].x < 0.5 * c.cx_px) {
        room.current_m[i].x += 0.05F;
        room.pixels[i].x += static_cast<float>(c.fx_px * 0.05) / room.current_m[i].z;
      }
    RigidBackgroundScene scene = room.scene();
    scene.elapsed_s = 1.0 / 30;
    scene.last_turn_radps = Eigen::Vector3d::Zero();
    REQUIRE(estimator.estimate(scene).ok);
    if (frame == 0) CHECK(estimator.row_twist().none());
  }
  CHECK((estimator.row_twist().a_rad - a_rad).norm() < 0.1 * a_rad.norm());
}

TEST_CASE("row twist: straightening is the first order of a turn") {
  const RowTwist twist{{0.01, 0.02, -0.01}};
  const Eigen::Vector3d q(0.3, -0.2, 2);
  CHECK((twist.straighten(q, 0.5) - exp_so3(0.5 * twist.a_rad) * q).norm() < 0.0001 * q.norm());
  CHECK(RowTwist().none());
  CHECK(RowTwist().straighten(q, 0.5) == q);
}

TEST_CASE("row readout: learned from twists, and a camera without one needs no twist") {
  SampleGenerator rng(5);
  for (const double readout_s : {0.0, 0.016, 0.033}) {
    CAPTURE(readout_s);
    RowReadout readout;
    CHECK(readout.may_roll());  // nothing is known
    CHECK(!readout.rolls());
    for (int frame = 0; frame < 60; ++frame) {
      const double change_radps = 0.3, sigma_rad = readout.sigma_rad(change_radps), noise_rad = 0.0005;
      const double per_own2 = 1 / (noise_rad * noise_rad), per_prior2 = 1 / (sigma_rad * sigma_rad);
      Eigen::Vector3d twist_rad;
      for (int k = 0; k < 3; ++k)
        twist_rad(k) = per_own2 / (per_own2 + per_prior2) *
                       (readout_s * change_radps * rng.normal() + noise_rad * rng.normal());
      readout.learn(change_radps, sigma_rad, twist_rad,
                    Eigen::Vector3d::Constant(1 / (per_own2 + per_prior2)));
    }
    CHECK(readout.readout_s() >= 0.7 * readout_s);
    CHECK(readout.readout_s() <= 1.3 * readout_s + 0.002);
    CHECK(readout.rolls() == (readout_s > 0));
    CHECK(readout.may_roll() == (readout_s > 0));
  }
}

}  // namespace row_twist_test
