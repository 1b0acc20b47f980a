// SPDX-License-Identifier: MIT
#include <cmath>

#include "doctest/doctest.h"
#include "render/camera_path.hpp"
#include "render/motion.hpp"

namespace motion_test {

using namespace dynfilter;
using namespace dynfilter::render;

namespace {

WalkPath ring(double radius_m) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 12; ++i)
    points.emplace_back(radius_m * std::cos(i * M_PI / 6), radius_m * std::sin(i * M_PI / 6));
  return WalkPath(points);
}

double angle_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

}  // namespace

TEST_CASE("a walk path is measured by its length, round and round") {
  const WalkPath path = ring(2);
  CHECK(path.length_m() == doctest::Approx(4 * M_PI).epsilon(0.01));
  for (const double s : {-20.0, -0.3, 0.0, 1.0, 5.5, 12.0, 40.0}) {
    CAPTURE(s);
    CHECK(path.at(s).norm() == doctest::Approx(2).epsilon(0.01));
    CHECK((path.at(s + 0.1) - path.at(s)).norm() == doctest::Approx(0.1).epsilon(0.02));
    CHECK((path.at(s) - path.at(s + path.length_m())).norm() < 1e-9);
    CHECK(path.heading(s).dot(path.at(s)) == doctest::Approx(0).epsilon(0.05));  // along the circle
  }
}

TEST_CASE("bones keep their lengths and join at every moment of a walk") {
  const BodyShape shape;
  Walking::Options options;
  options.carries_box = true;
  const Walking walk(shape, ring(1.5), options);
  std::vector<Eigen::Isometry3d> parts;
  for (double t = -1; t < 3; t += 0.037) {
    walk.pose(t, parts);
    REQUIRE(parts.size() == kBodyPartCount + 1);
    for (int side = 0; side < 2; ++side) {
      const Eigen::Vector3d knee = parts[kLeftThigh + side] * Eigen::Vector3d(0, 0, -shape.thigh());
      CHECK((knee - parts[kLeftShin + side].translation()).norm() < 1e-9);
      const Eigen::Vector3d ankle = parts[kLeftShin + side] * Eigen::Vector3d(0, 0, -shape.shin());
      CHECK((ankle - parts[kLeftFoot + side].translation()).norm() < 0.03);  // reach is limited
      const Eigen::Vector3d elbow = parts[kLeftUpperArm + side] * Eigen::Vector3d(0, 0, -shape.upper_arm());
      CHECK((elbow - parts[kLeftForearm + side].translation()).norm() < 1e-9);
    }
    for (const Eigen::Isometry3d& part : parts) {
      CHECK((part.linear() * part.linear().transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9);
      CHECK(part.linear().determinant() == doctest::Approx(1));
    }
  }
}

TEST_CASE("a foot that stands does not slide while the body walks on") {
  const BodyShape shape;
  Walking::Options options;
  options.speed_mps = 1.0;
  const Walking walk(shape, ring(3), options);
  std::vector<Eigen::Isometry3d> last, now;
  const double step_s = 1.0 / 90;
  double planted_s[2] = {0, 0}, worst_m = 0;
  for (double t = 0; t < 4; t += step_s) {
    walk.pose(t, last);
    walk.pose(t + step_s, now);
    CHECK((now[kPelvis].translation() - last[kPelvis].translation()).norm() ==
          doctest::Approx(step_s).epsilon(0.25));
    for (int side = 0; side < 2; ++side) {
      const Eigen::Vector3d sole(0, 0.05, -shape.ankle_height());
      const Eigen::Vector3d a = last[kLeftFoot + side] * sole, b = now[kLeftFoot + side] * sole;
      const bool flat = std::abs(last[kLeftFoot + side].linear()(2, 1)) < 1e-6 &&
                        std::abs(now[kLeftFoot + side].linear()(2, 1)) < 1e-6;
      if (!flat) continue;
      planted_s[side] += step_s;
      worst_m = std::max(worst_m, (b - a).norm());
    }
  }
  CHECK(planted_s[0] > 0.6);
  CHECK(planted_s[1] > 0.6);
  CHECK(worst_m < 0.002);
}

TEST_CASE("who waits for the start stands exactly still until then") {
  Walking::Options options;
  options.start_s = 0.5;
  const Walking walk(BodyShape{}, ring(1), options);
  Gesturing::Options gestures;
  gestures.start_s = 0.5;
  const Gesturing talk(BodyShape{}, gestures);
  for (const Animation* animation :
       {static_cast<const Animation*>(&walk), static_cast<const Animation*>(&talk)}) {
    std::vector<Eigen::Isometry3d> before, start, later;
    animation->pose(-1, before);
    animation->pose(0.5, start);
    animation->pose(0.9, later);
    double moved_m = 0;
    for (std::size_t i = 0; i < start.size(); ++i) {
      CHECK(before[i].isApprox(start[i], 1e-12));
      moved_m = std::max(moved_m, (later[i].translation() - start[i].translation()).norm());
    }
    CHECK(moved_m > 0.05);
  }
}

TEST_CASE("cameras move smoothly at the speeds of hands") {
  struct Expectation {
    CameraStyle style;
    double most_mps, least_max_mps, most_degps, least_max_degps;
  };
  for (const Expectation& e :
       {Expectation{CameraStyle::Static, 0.06, 0, 3, 0}, Expectation{CameraStyle::Xyz, 0.5, 0.15, 8, 0.5},
        Expectation{CameraStyle::Rpy, 0.3, 0, 60, 20}, Expectation{CameraStyle::Halfsphere, 0.9, 0.2, 25, 4},
        Expectation{CameraStyle::Sideways, 0.5, 0.3, 1e-6, 0}}) {
    CAPTURE(static_cast<int>(e.style));
    CameraMotion::Options options;
    options.style = e.style;
    Random random(4);
    const CameraMotion motion(options, random);
    double fastest = 0, fastest_turn = 0;
    for (double t = 0; t < 10; t += 1 / 30.0) {
      const Eigen::Isometry3d a = motion.pose(t), b = motion.pose(t + 1 / 30.0);
      fastest = std::max(fastest, 30 * (b.translation() - a.translation()).norm());
      fastest_turn = std::max(fastest_turn, 30 * 180 / M_PI * angle_between(a, b));
    }
    CHECK(fastest <= e.most_mps);
    CHECK(fastest >= e.least_max_mps);
    CHECK(fastest_turn <= e.most_degps + 1e-4);
    CHECK(fastest_turn >= e.least_max_degps);
  }
}

TEST_CASE("a camera looks at its target with the horizon level") {
  const Eigen::Isometry3d pose = look_at({1, 2, 1.5}, {3, 1, 0.5});
  const Eigen::Vector3d seen = pose.inverse() * Eigen::Vector3d(3, 1, 0.5);
  CHECK(seen.head<2>().norm() < 1e-12);
  CHECK(seen.z() == doctest::Approx(std::sqrt(6.0)));
  CHECK(pose.linear()(2, 0) == doctest::Approx(0));  // x is horizontal
  CHECK(pose.linear()(2, 1) < 0);                    // y points down
}

}  // namespace motion_test
