// SPDX-License-Identifier: MIT
// The terms of the background's score, with scenes in which each follows from geometry. Parts of constant
// depth are shifted sideways, with four points in each cell of the estimator's grid and no noise.
#include <algorithm>
#include <cmath>
#include <dynfilter/motion/rigid_background.hpp>
#include <vector>

#include "doctest/doctest.h"
#include "geometry/rigid_scene.hpp"
#include "motion/scene_of.hpp"

namespace background_score_test {

using namespace dynfilter;
using doctest::Approx;

namespace {

constexpr int kColumns = 16, kRows = 12;
constexpr double kUnknownMiss_px = 3;  ///< the usual distance, before one is known

Pose shift(double x_m, double y_m = 0) {
  return Pose::from(Eigen::Matrix3d::Identity(), {x_m, y_m, 0});
}

/// Distance of two shifts in the image at a depth [px].
double apart_px(const Pose& a, const Pose& b, double depth_m) {
  return geometry_test::camera().fx_px * (a.t() - b.t()).norm() / depth_m;
}

struct Cells {
  void fill(int from, int to, double depth_m, const Pose& T, float moved = 0.3F) {
    const Camera c = geometry_test::camera();
    const double width = 2 * c.cx_px / kColumns, height = 2 * c.cy_px / kRows;
    for (int row = 0; row < kRows; ++row)
      for (int column = from; column < to; ++column)
        for (int k = 0; k < 4; ++k) {
          const double u = (column + (k % 2 == 0 ? 0.35 : 0.65)) * width,
                       v = (row + (k < 2 ? 0.35 : 0.65)) * height;
          const Eigen::Vector3d now((u - c.cx_px) / c.fx_px * depth_m, (v - c.cy_px) / c.fy_px * depth_m,
                                    depth_m);
          const Eigen::Vector3d then = now - T.t();
          reference_m.emplace_back(then.x(), then.y(), then.z());
          current_m.emplace_back(now.x(), now.y(), now.z());
          pixels.emplace_back(u, v);
          mobility.push_back(moved);
          seeds.push_back(static_cast<int>(seeds.size()));
        }
  }
  RigidBackgroundScene scene() const { return motion_test::scene_of(*this); }

  std::vector<cv::Point3f> reference_m, current_m;
  std::vector<cv::Point2f> pixels;
  std::vector<float> mobility;
  std::vector<int> seeds;
};

/// The proposal with the largest area among those near to a motion.
MotionProposal near_to(const RigidBackgroundEstimator& estimator, const Pose& T) {
  MotionProposal best;
  for (const MotionProposal& p : estimator.proposals())
    if (geometry_test::pose_error(p.motion.T_current_reference, T) < 0.003 && p.area > best.area) best = p;
  return best;
}

/// The share of the neighbours within 50 px on other parts that are in front, of each part.
/// Part k has the points from begins[k] to begins[k + 1].
std::vector<double> brute_force_orders(const Cells& cells, const std::vector<std::size_t>& begins) {
  const auto part = [&](std::size_t i) {
    return static_cast<std::size_t>(std::upper_bound(begins.begin(), begins.end(), i) - begins.begin()) - 1;
  };
  std::vector<double> behind(begins.size(), 1), front(begins.size(), 1), orders;
  for (std::size_t a = 0; a < cells.pixels.size(); ++a)
    for (std::size_t b = 0; b < cells.pixels.size(); ++b) {
      if (part(a) == part(b) || !(cells.current_m[a].z > 1.08F * cells.current_m[b].z)) continue;
      if (cv::norm(cells.pixels[a] - cells.pixels[b]) > 50) continue;
      ++behind[part(a)];
      ++front[part(b)];
    }
  for (std::size_t k = 0; k < begins.size(); ++k) orders.push_back(behind[k] / (behind[k] + front[k]));
  return orders;
}

/// Points of so many columns.
constexpr std::size_t points_of(int columns) {
  return static_cast<std::size_t>(columns) * kRows * 4;
}

/// 10 of 16 columns follow the camera, the others a mover at the same depth.
Cells two_parts(const Pose& camera, const Pose& mover) {
  Cells cells;
  cells.fill(0, 10, 2, camera);
  cells.fill(10, 16, 2, mover);
  return cells;
}

/// The score of a motion of so many columns, `d` units of the usual distance from the expected one.
/// Half a point is added to both parts of the odds.
double score_of(const MotionProposal& p, double d, int columns) {
  const double mine = static_cast<double>(points_of(columns)) + 0.5,
               others = static_cast<double>(points_of(kColumns - columns)) + 0.5;
  return 2.5 * (std::log(p.area) + p.order + 0.1 * std::log(mine / others) - std::log1p(d * d));
}

}  // namespace

// Equal depths: no part is in front. 10 of 16 columns are 0.625 of the surface.
TEST_CASE("the area is the share of the visible surface, and scores give the confidence") {
  const Pose camera = shift(0.02), mover = shift(-0.02, 0.01);
  const Cells cells = two_parts(camera, mover);
  RigidBackgroundEstimator estimator;
  const RigidMotion motion = estimator.estimate(cells.scene());
  REQUIRE(motion.ok);
  CHECK(estimator.points() == kRows * kColumns * 4);
  CHECK(geometry_test::pose_error(motion.T_current_reference, camera) < 0.001);
  const MotionProposal background = near_to(estimator, camera), other = near_to(estimator, mover);
  CHECK(background.area == Approx(0.625).epsilon(0.005));
  CHECK(other.area == Approx(0.375).epsilon(0.005));
  CHECK(background.order == 0.5);
  CHECK(other.order == 0.5);
  CHECK(background.score == Approx(std::log(0.625) + 0.5).epsilon(0.01));
  CHECK(estimator.confidence() == Approx(0.625).epsilon(0.005));
}

// As above: the mover is the background with probability 0.375. What follows it may stand still. A point
// moved 20 px off both of them, or as the chosen motion says, follows no rival.
TEST_CASE("a feature that follows a rival may stand still, others may not") {
  const Pose camera = shift(0.02), mover = shift(-0.02, 0.01);
  const Cells cells = two_parts(camera, mover);
  RigidBackgroundEstimator estimator;
  const RigidBackgroundScene scene = cells.scene();
  REQUIRE(estimator.estimate(scene).ok);
  const cv::Point3f then(0.3F, -0.2F, 2.5F), lower(0, static_cast<float>(20 * 2.5 / scene.camera.fx_px), 0);
  const auto rest = [&](const cv::Point3f& now) { return estimator.rest_by_rivals(scene.camera, then, now); };
  const auto moved = [&](const Pose& T) { return to_point(T.R() * Eigen::Vector3d(0.3, -0.2, 2.5) + T.t()); };
  const cv::Point3f by_mover = moved(mover);
  CHECK(rest(by_mover) == Approx(0.375).epsilon(0.005));
  CHECK(rest(by_mover + lower) == 0);
  CHECK(rest(moved(camera)) == 0);
  estimator.reset();
  CHECK(rest(by_mover) == 0);
}

// A point of depth z and mobility m has the surface (1 - m) z^2, z at most 4 m. The mover is 1.8 m away.
TEST_CASE("surface grows with the square of the depth, up to 4 m, and counts as it stands still") {
  const Pose camera = shift(0.03), mover = shift(-0.02, 0.01);
  for (const double depth_m : {3.0, 4.0, 6.0}) {
    for (const float mobility : {0.3F, 0.6F}) {
      Cells cells;
      cells.fill(0, 10, depth_m, camera, mobility);
      cells.fill(10, 16, 1.8, mover, 0.3F);
      RigidBackgroundEstimator estimator;
      REQUIRE(estimator.estimate(cells.scene()).ok);
      const double seen_m = std::min(4.0, depth_m);
      const double first = 10 * (1 - static_cast<double>(mobility)) * seen_m * seen_m,
                   second = 6 * 0.7 * 1.8 * 1.8;
      CHECK(near_to(estimator, camera).area == Approx(first / (first + second)).epsilon(0.01));
      CHECK(near_to(estimator, mover).area == Approx(second / (first + second)).epsilon(0.01));
    }
  }
}

TEST_CASE("a scene that surely moves has no area, however little doubt is enough") {
  const Pose camera = shift(0.02);
  for (const float mobility : {1.0F, 0.9999F}) {
    Cells cells;
    cells.fill(0, 16, 2, camera, mobility);
    RigidBackgroundEstimator estimator;
    REQUIRE(estimator.estimate(cells.scene()).ok);
    const double area = mobility < 1 ? 1 : 0;
    CHECK(estimator.proposals()[estimator.chosen()].area == Approx(area).epsilon(0.001));
  }
}

TEST_CASE("the order is the share of the neighbours within 50 px that are in front") {
  const Pose camera = shift(0.03), mover = shift(-0.02, 0.01);
  for (const double depth_m : {3.0, 1.9}) {  // 1.9 m is not 8 % behind 1.8 m
    Cells cells;
    cells.fill(0, 10, depth_m, camera);
    cells.fill(10, 16, 1.8, mover);
    RigidBackgroundEstimator estimator;
    REQUIRE(estimator.estimate(cells.scene()).ok);
    const std::vector<double> expected = brute_force_orders(cells, {0, points_of(10)});
    CHECK((expected[0] > 0.9) == (depth_m == 3.0));
    CHECK(near_to(estimator, camera).order == Approx(expected[0]).epsilon(1e-9));
    CHECK(near_to(estimator, mover).order == Approx(expected[1]).epsilon(1e-9));
  }
}

// The middle part is beside both others.
TEST_CASE("three motions: the order of each is over both others, and all count against the best") {
  const Pose motions[] = {shift(0.03), shift(-0.02, 0.01), shift(0.01, -0.03)};
  const double depths_m[][3] = {{3, 2.4, 1.8}, {2.4, 3, 1.8}, {1.8, 2.4, 3}, {1.8, 3, 2.4}};
  for (const auto& depth_m : depths_m) {
    Cells cells;
    cells.fill(0, 6, depth_m[0], motions[0]);
    cells.fill(6, 11, depth_m[1], motions[1]);
    cells.fill(11, 16, depth_m[2], motions[2]);
    RigidBackgroundEstimator estimator;
    REQUIRE(estimator.estimate(cells.scene()).ok);
    const std::vector<double> expected = brute_force_orders(cells, {0, points_of(6), points_of(11)});
    double sum = 0, best = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const MotionProposal p = near_to(estimator, motions[k]);
      CHECK(p.order == Approx(expected[k]).epsilon(1e-9));
      sum += std::exp(p.score);
      best = std::max(best, std::exp(p.score));
    }
    CHECK(estimator.confidence() == Approx(best / sum).epsilon(1e-9));
  }
}

// Each motion is compared where its own points are: the mover's at 1.8 m, where a shift is 3 / 1.8 times as
// long.
TEST_CASE("distance from what is expected costs, over a motion's own points and at most 20 px") {
  const Pose camera = shift(0.03), mover = shift(-0.02, 0.01);
  for (const double expected_x_m : {0.035, 0.1}) {
    Cells cells;
    cells.fill(0, 10, 3, camera);
    cells.fill(10, 16, 1.8, mover);
    RigidBackgroundScene scene = cells.scene();
    scene.expected = shift(expected_x_m);
    RigidBackgroundEstimator estimator;
    REQUIRE(estimator.estimate(scene).ok);
    const auto distance = [&](const Pose& T, double depth_m) {
      return std::min(20.0, apart_px(T, *scene.expected, depth_m)) / (2 * kUnknownMiss_px);
    };
    const MotionProposal of_camera = near_to(estimator, camera), of_mover = near_to(estimator, mover);
    CHECK(of_camera.score == Approx(score_of(of_camera, distance(camera, 3), 10)).epsilon(0.01));
    CHECK(of_mover.score == Approx(score_of(of_mover, distance(mover, 1.8), 6)).epsilon(0.01));
  }
}

namespace {

/// The units of the expectation's distance d in the score of a view of one motion.
double distance_of(RigidBackgroundEstimator& estimator, const Cells& cells, const Pose& expected) {
  RigidBackgroundScene scene = cells.scene();
  scene.expected = expected;
  REQUIRE(estimator.estimate(scene).ok);
  const MotionProposal& p = estimator.proposals()[estimator.chosen()];
  double low = 0, high = 20;  // the score falls with the distance
  for (int k = 0; k < 60; ++k)
    (score_of(p, (low + high) / 2, kColumns) > p.score ? low : high) = (low + high) / 2;
  return low;
}

}  // namespace

// The unit is twice the usual distance u, at least 0.15 px. u starts at 3 px and moves by a fifth of the way
// to each frame's distance, of which at most 6 px count.
TEST_CASE("the usual distance from the expected motion is learned") {
  const Pose camera = shift(0.02);
  Cells cells;
  cells.fill(0, 16, 2, camera);
  const auto off_by = [&](double px) { return shift(0.02 + px * 2 / geometry_test::camera().fx_px); };
  RigidBackgroundEstimator estimator;
  for (int k = 0; k < 4; ++k)
    REQUIRE(estimator.estimate(cells.scene()).ok);  // nothing is expected: nothing is learned
  double usual_px = kUnknownMiss_px;
  for (const double px : {12.0, 12.0, 4.0, 4.0, 1.0, 9.0}) {
    CHECK(distance_of(estimator, cells, off_by(px)) == Approx(px / (2 * usual_px)).epsilon(0.01));
    usual_px += 0.2 * (std::min(6.0, px) - usual_px);
  }
  for (int k = 0; k < 40; ++k) distance_of(estimator, cells, camera);
  CHECK(distance_of(estimator, cells, off_by(0.3)) == Approx(0.3 / 0.15).epsilon(0.05));
  estimator.reset();
  CHECK(distance_of(estimator, cells, off_by(12)) == Approx(12 / (2 * kUnknownMiss_px)).epsilon(0.01));
}

}  // namespace background_score_test
