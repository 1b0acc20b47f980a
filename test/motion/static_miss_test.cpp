// SPDX-License-Identifier: MIT
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/motion/static_miss.hpp>
#include <limits>

#include "doctest/doctest.h"
#include "geometry/rigid_scene.hpp"

namespace static_miss_test {

using namespace dynfilter;
using Axes = StaticMiss::Axes;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Pose motion() {
  return Pose::from(Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix(),
                    {0.2, -0.1, 0.4});
}

RigidResidualNoise noise() {
  RigidResidualNoise noise;
  noise.pixel_sigma_px = 0.5;
  noise.depth_noise = DepthNoise::of_stereo(50);
  return noise;
}

cv::Point2f pixel(const Eigen::Vector3d& p) {
  const Camera c = geometry_test::camera();
  return {static_cast<float>(c.fx_px * p.x() / p.z() + c.cx_px),
          static_cast<float>(c.fy_px * p.y() / p.z() + c.cy_px)};
}
Eigen::Vector3d point(const cv::Point2f& px, double depth_m) {
  const Camera c = geometry_test::camera();
  return {(px.x - c.cx_px) / c.fx_px * depth_m, (px.y - c.cy_px) / c.fy_px * depth_m, depth_m};
}

/// A static point, seen before and after the motion. `off_px`: error of the second position.
struct Pair {
  SeenPoint then, now;

  explicit Pair(SampleGenerator& rng, const cv::Point2f& off_px = {}) {
    then.px = {static_cast<float>(rng.uniform(40, 600)), static_cast<float>(rng.uniform(40, 440))};
    then.depth_m = static_cast<float>(rng.uniform(1.5, 12));
    const Eigen::Vector3d q = motion().R() * point(then.px, then.depth_m) + motion().t();
    now.px = pixel(q) + off_px;
    now.depth_m = static_cast<float>(q.z());
  }
};

}  // namespace

TEST_CASE("static miss: nothing is left of a static point, whichever depths are known") {
  const StaticMissModel model(geometry_test::camera(), motion(), noise());
  SampleGenerator rng(1);
  for (int k = 0; k < 200; ++k) {
    const Pair pair(rng);
    for (const bool then_known : {true, false})
      for (const bool now_known : {true, false}) {
        SeenPoint then = pair.then, now = pair.now;
        if (!then_known) then.depth_m = kNan;
        if (!now_known) now.depth_m = kNan;
        const StaticMiss miss = model(then, now);
        CHECK(miss.axes == (then_known && now_known   ? Axes::Space
                            : then_known || now_known ? Axes::Image
                                                      : Axes::Line));
        CHECK(miss.image_px < 2e-3F);
        CHECK(miss.chi2 < 1e-4F);
        // Where the miss is measured. Without a depth the point is triangulated.
        const float there_m = !then_known && now_known ? pair.then.depth_m : pair.now.depth_m;
        CHECK(static_cast<double>(miss.px_per_m * there_m) == doctest::Approx(535.4).epsilon(0.02));
      }
  }
}

// The prediction moves with the depth's error, to first order: the covariance by numerical differentiation.
TEST_CASE("static miss: with one depth, chi2 is that of the full covariance") {
  const StaticMissModel model(geometry_test::camera(), motion(), noise());
  SampleGenerator rng(2);
  for (int k = 0; k < 200; ++k) {
    const auto off_y_px = static_cast<float>(rng.uniform(-6, 6));
    const cv::Point2f off_px(static_cast<float>(rng.uniform(-6, 6)), off_y_px);
    Pair pair(rng, off_px);
    const auto predicted = [&](double depth_m) {
      return pixel(motion().R() * point(pair.then.px, depth_m) + motion().t());
    };
    const double z_m = pair.then.depth_m, step_m = 0.01;
    const cv::Point2f d = (predicted(z_m + step_m) - predicted(z_m - step_m)) / (2 * step_m);
    const Eigen::Vector2d g = Eigen::Vector2d(d.x, d.y) * noise().depth_noise.sigma_m(z_m);
    const Eigen::Matrix2d S = 0.25 * Eigen::Matrix2d::Identity() + g * g.transpose();
    const Eigen::Vector2d r(off_px.x, off_px.y);
    pair.now.depth_m = kNan;
    const StaticMiss miss = model(pair.then, pair.now);
    CHECK(static_cast<double>(miss.chi2) == doctest::Approx(r.dot(S.inverse() * r)).epsilon(0.02));
    CHECK(static_cast<double>(miss.image_px) == doctest::Approx(r.norm()).epsilon(0.01));
  }
}

TEST_CASE("static miss: without depths, the distance from the nearest point that the ray may hold") {
  const StaticMissModel model(geometry_test::camera(), motion(), noise());
  SampleGenerator rng(3);
  for (int k = 0; k < 200; ++k) {
    const auto off_y_px = static_cast<float>(rng.uniform(-9, 9));
    const cv::Point2f off_px(static_cast<float>(rng.uniform(-9, 9)), off_y_px);
    Pair pair(rng, off_px);
    pair.then.depth_m = pair.now.depth_m = kNan;
    double nearest_px = std::numeric_limits<double>::infinity();
    for (double per_m = 0; per_m <= 2; per_m += 0.0005) {
      const cv::Point2f d = pixel(motion().R() * point(pair.then.px, 1) + per_m * motion().t()) - pair.now.px;
      nearest_px = std::min(nearest_px, std::hypot(static_cast<double>(d.x), static_cast<double>(d.y)));
    }
    const StaticMiss miss = model(pair.then, pair.now);
    // The linear triangulation weights the two equations by the depth, so it may miss the nearest point a
    // little.
    CHECK(static_cast<double>(miss.image_px) >= nearest_px - 0.01);
    CHECK(static_cast<double>(miss.image_px) <= 1.05 * nearest_px + 0.05);
    CHECK(static_cast<double>(miss.chi2) == doctest::Approx(std::pow(miss.image_px / 0.5, 2)).epsilon(1e-4));
  }
}

// Under a rotation alone every static point is where the infinite homography puts it.
TEST_CASE("static miss: without translation a direction counts in both coordinates") {
  const Pose turn = Pose::from(motion().R(), {0, 0, 0});
  const StaticMissModel model(geometry_test::camera(), turn, noise());
  const SeenPoint then{{300, 200}, kNan};
  const cv::Point2f there = pixel(turn.R() * point(then.px, 1));
  for (const cv::Point2f& off_px : {cv::Point2f(3, 0), cv::Point2f(0, 3), cv::Point2f(-2, 2)}) {
    const StaticMiss miss = model(then, {there + off_px, kNan});
    CHECK(static_cast<double>(miss.image_px) == doctest::Approx(cv::norm(off_px)).epsilon(1e-3));
  }
}

TEST_CASE("static miss: what cannot be predicted says nothing") {
  const Pose through = Pose::from(Eigen::Matrix3d::Identity(), {0, 0, -5});
  const StaticMissModel model(geometry_test::camera(), through, noise());
  CHECK(model({{320, 240}, 2}, {{320, 240}, kNan}).axes == Axes::None);  // behind the camera now
  CHECK(model({{kNan, 240}, 8}, {{320, 240}, kNan}).axes == Axes::None);
  CHECK(model({{kNan, 240}, kNan}, {{320, 240}, kNan}).axes == Axes::None);
}

TEST_CASE(
    "static miss: the fast form is the whole one where a depth is missing, and has the same miss where none "
    "is") {
  const StaticMissModel model(geometry_test::camera(), motion(), noise());
  SampleGenerator rng(4);
  for (int k = 0; k < 50; ++k) {
    const Pair pair(rng, {3, -2});
    for (const bool then_known : {true, false})
      for (const bool now_known : {true, false}) {
        SeenPoint then = pair.then, now = pair.now;
        if (!then_known) then.depth_m = kNan;
        if (!now_known) now.depth_m = kNan;
        const StaticMiss fast = model.miss(then, now), whole = model(then, now);
        CHECK(fast.axes == whole.axes);
        CHECK(fast.miss_px == whole.miss_px);
        CHECK(fast.px_per_m == whole.px_per_m);
        if (!then_known || !now_known) CHECK(fast.chi2 == whole.chi2);
      }
  }
}

TEST_CASE("static miss: chi2 is that of the whole covariance, with what a match slides") {
  const Camera camera = geometry_test::camera();
  const StaticMissModel model(camera, motion(), noise());
  SampleGenerator rng(5);
  for (int k = 0; k < 300; ++k) {
    Pair pair(rng, {2.5F, -1.5F});
    pair.now.depth_m *= 1.02F;
    MatchSpread spread;
    const double angle = rng.uniform(0, 3), s2 = noise().pixel_sigma_px * noise().pixel_sigma_px;
    spread.edge = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
    spread.across = static_cast<float>(rng.uniform(1, 3));
    spread.along = static_cast<float>(rng.uniform(3, 500));
    spread.depth_per_px = static_cast<float>(rng.uniform(-0.02, 0.02));
    const Eigen::Vector3d p = point(pair.then.px, pair.then.depth_m);
    const Eigen::Vector3d ray = motion().R() * p, q = ray + motion().t();
    const double sigma_then = noise().depth_noise.sigma_m(pair.then.depth_m) / pair.then.depth_m;
    const double sigma_now = noise().depth_noise.sigma_m(pair.now.depth_m);
    const Eigen::Vector3d g =
        sigma_then * Eigen::Vector3d(camera.fx_px * (ray.x() - q.x() / q.z() * ray.z()) / q.z(),
                                     camera.fy_px * (ray.y() - q.y() / q.z() * ray.z()) / q.z(), ray.z());
    const Eigen::Vector3d v(spread.edge.x, spread.edge.y, spread.depth_per_px);
    const Eigen::Matrix3d S = Eigen::Vector3d(s2 * spread.across, s2 * spread.across, sigma_now * sigma_now)
                                  .asDiagonal()
                                  .toDenseMatrix() +
                              s2 * (spread.along - spread.across) * v * v.transpose() + g * g.transpose();
    const cv::Point2f off = pair.now.px - pixel(q);
    const Eigen::Vector3d r(off.x, off.y, pair.now.depth_m - q.z());
    CHECK(static_cast<double>(model(pair.then, pair.now, spread).chi2) ==
          doctest::Approx(r.dot(S.inverse() * r)).epsilon(1e-3));
    pair.now.depth_m = kNan;  // the image alone
    const Eigen::Matrix2d image = S.topLeftCorner<2, 2>();
    CHECK(static_cast<double>(model(pair.then, pair.now, spread).chi2) ==
          doctest::Approx(r.head<2>().dot(image.inverse() * r.head<2>())).epsilon(1e-3));
    pair.then.depth_m = kNan;  // across the line: the variance in the direction of the miss
    const StaticMiss line = model(pair.then, pair.now, spread);
    const Eigen::Vector2d miss(line.miss_px.x, line.miss_px.y), n = miss.normalized();
    const Eigen::Matrix2d M = s2 * (spread.across * Eigen::Matrix2d::Identity() +
                                    (spread.along - spread.across) * v.head<2>() * v.head<2>().transpose());
    CHECK(static_cast<double>(line.chi2) == doctest::Approx(miss.squaredNorm() / n.dot(M * n)).epsilon(1e-3));
  }
}

}  // namespace static_miss_test
