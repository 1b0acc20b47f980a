// SPDX-License-Identifier: MIT
#include <dynfilter/motion/prior_evidence.hpp>

#include <cmath>
#include <dynfilter/geometry/sampling.hpp>
#include <vector>

#include "doctest/doctest.h"
#include "geometry/rigid_scene.hpp"

namespace prior_evidence_test {

using namespace dynfilter;

namespace {

/// Points in a window of the image whose sides have this share of it, 1 to 4 m away.
std::vector<cv::Point3f> points_in(double share, double far_m = 4) {
  const Camera c = geometry_test::camera();
  SampleGenerator rng(5);
  std::vector<cv::Point3f> points;
  for (int i = 0; i < 120; ++i) {
    const double z = rng.uniform(1, far_m), u = 320 + share * rng.uniform(-320, 320),
                 v = 240 + share * rng.uniform(-240, 240);
    points.emplace_back((u - c.cx_px) / c.fx_px * z, (v - c.cy_px) / c.fy_px * z, z);
  }
  return points;
}

MotionPrior prior_of(const Pose& T, double sigma_rad, double sigma_m = 0) {
  MotionPrior prior = MotionPrior::turn(T.R(), sigma_rad * sigma_rad * Eigen::Matrix3d::Identity());
  prior.T_current_reference = T;
  prior.has_translation = sigma_m > 0;
  for (std::size_t k = 0; k < 3; ++k) prior.covariance[7 * k] = sigma_m * sigma_m;
  return prior;
}

double distance2(const MotionPrior& prior, const std::vector<cv::Point3f>& points, const Pose& T) {
  const Camera camera = geometry_test::camera();
  PriorEvidence evidence(prior, camera);
  for (const cv::Point3f& p : points) evidence.add(p);
  return evidence.distance2(T, 1);
}

/// Mean squared distance in the image of points and of the same after `delta`, by its definition.
double image_miss2(const std::vector<cv::Point3f>& points, const Pose& delta) {
  const Camera c = geometry_test::camera();
  double sum = 0;
  for (const cv::Point3f& p : points) {
    const Eigen::Vector3d q = delta.R() * Eigen::Vector3d(p.x, p.y, p.z) + delta.t();
    sum += std::pow(c.fx_px * (q.x() / q.z() - static_cast<double>(p.x / p.z)), 2) +
           std::pow(c.fy_px * (q.y() / q.z() - static_cast<double>(p.y / p.z)), 2);
  }
  return sum / static_cast<double>(points.size());
}

Pose turned(const Eigen::Vector3d& w, const Eigen::Vector3d& t = Eigen::Vector3d::Zero()) {
  return Pose::from(exp_so3(w), t);
}

}  // namespace

TEST_CASE("prior evidence: with a translation it is the mean squared distance in the image") {
  const std::vector<cv::Point3f> points = points_in(1);
  const Pose T = turned({0.02, -0.01, 0.005}, {0.03, 0.01, -0.02});
  const Pose delta = turned({1e-3, -2e-3, 5e-4}, {1e-3, 2e-3, -1e-3});
  // s = 1 px, and a prior that is sure.
  CHECK(distance2(prior_of(delta * T, 1e-9, 1e-9), points, T) ==
        doctest::Approx(image_miss2(points, delta)).epsilon(0.02));
}

TEST_CASE("prior evidence: without one the translation is the best for the points") {
  const std::vector<cv::Point3f> points = points_in(0.6);
  const Eigen::Vector3d w(1e-3, 3e-3, -1e-3);
  double best = HUGE_VAL;  // by descent on the definition, in shrinking steps
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  for (double step = 0.02; step > 1e-6; step *= 0.7)
    for (int k = 0; k < 60; ++k) {
      const Eigen::Vector3d other = t + step * (k % 2 == 0 ? 1 : -1) * Eigen::Vector3d::Unit(k / 2 % 3);
      const double miss2 = image_miss2(points, turned(w, other));
      if (miss2 < best) best = miss2, t = other;
    }
  CHECK(distance2(prior_of(turned(w), 1e-9), points, Pose()) == doctest::Approx(best).epsilon(0.03));
}

TEST_CASE("prior evidence: a small object contradicts no turn, a whole view does") {
  const MotionPrior prior = prior_of(turned({0, 0.01, 0}), 1e-4);
  CHECK(distance2(prior, points_in(1), Pose()) > 4);
  CHECK(distance2(prior, points_in(0.1, 1.2), Pose()) < 0.1);
  CHECK(distance2(prior, {}, Pose()) == 0);
}

TEST_CASE("prior evidence: an unsure prior contradicts less, one that agrees not at all") {
  const std::vector<cv::Point3f> points = points_in(1);
  const Pose T = turned({0.02, 0, 0}, {0.1, 0, 0});
  CHECK(distance2(prior_of(T, 1e-4), points, T) < 1e-9);
  const double sure = distance2(prior_of(turned({0.03, 0, 0}), 1e-4), points, T),
               unsure = distance2(prior_of(turned({0.03, 0, 0}), 0.01), points, T);
  CHECK(sure > 4);
  CHECK(unsure < 1.5);
}

TEST_CASE("prior evidence: motions within two deviations are equally likely") {
  for (const double distance : {0.0, 1.0, 1.9})
    CHECK(PriorEvidence::log_likelihood(distance * distance, 0.1) == doctest::Approx(0));
  CHECK(PriorEvidence::log_likelihood(1e9, 0.1) == doctest::Approx(std::log(0.1)));
  CHECK(PriorEvidence::log_likelihood(10, 0) == doctest::Approx(2 - 10.0 / 2));
  CHECK(PriorEvidence::contradiction(4) == doctest::Approx(0));
}

TEST_CASE("prior evidence: at first it is as likely wrong as right, so it halves a likelihood at most") {
  const double wrong = PriorWatch().wrong();
  CHECK(wrong == doctest::Approx(0.5));
  CHECK(PriorEvidence::log_likelihood(1e9, wrong) == doctest::Approx(-std::log(2.0)));
}

TEST_CASE("prior watch: what lies is noticed within half a second at every rate, a jerk is not a lie") {
  for (const double rate_hz : {10.0, 30.0, 60.0}) {
    CAPTURE(rate_hz);
    PriorWatch watch;
    CHECK(watch.trusts());
    const auto see = [&](double distance2, double over_s) {
      for (int k = 0; k < static_cast<int>(std::lround(over_s * rate_hz)); ++k)
        watch.observe(distance2, 1 / rate_hz);
    };
    see(0.5, 2);  // it has proved itself
    CHECK(watch.wrong() < 0.01);
    see(100, 0.1);
    CHECK(watch.trusts());
    see(0.5, 0.5);
    see(12, 0.5);
    CHECK_FALSE(watch.trusts());
    see(0.5, 1.5);
    CHECK(watch.trusts());
    watch.reset();
    CHECK(watch.wrong() == doctest::Approx(PriorWatch().wrong()));
  }
}

}  // namespace prior_evidence_test
