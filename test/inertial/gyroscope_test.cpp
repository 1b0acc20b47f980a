// SPDX-License-Identifier: MIT
#include <dynfilter/inertial/gyroscope.hpp>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <dynfilter/core/pose.hpp>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "doctest/doctest.h"

namespace gyroscope_test {

using namespace dynfilter;

namespace {

constexpr double kRate_hz = 200, kFrame_s = 1.0 / 30, kDeg = M_PI / 180;

/// The sensor sits on its side: x of the camera is y of the sensor.
Eigen::Matrix3d mounting() {
  Eigen::Matrix3d R;
  R << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return R;
}

/// Rates of a hand that shakes a camera about all axes, in the camera's axes.
Eigen::Vector3d shaken(double t) {
  return {0.8 * std::sin(19 * t), 1.1 * std::cos(23 * t + 0.4), 0.5 * std::sin(31 * t + 1)};
}

using Rate = std::function<Eigen::Vector3d(double)>;

/// R_world_camera by steps of 50 us: the twin of the class's own integration.
Eigen::Quaterniond orientation(const Rate& rate, double from_s, double to_s) {
  constexpr double kStep_s = 5e-5;
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  const int steps = static_cast<int>(std::lround((to_s - from_s) / kStep_s));
  for (int k = 0; k < steps; ++k) {
    const Eigen::Vector3d w = kStep_s * rate(from_s + (k + 0.5) * kStep_s);
    q = q * Eigen::Quaterniond(Eigen::AngleAxisd(
                w.norm(), w.norm() > 0 ? Eigen::Vector3d(w.normalized()) : Eigen::Vector3d::UnitX()));
  }
  return q;
}
/// R_current_reference of the camera.
Eigen::Matrix3d turn(const Rate& rate, double from_s, double to_s) {
  return orientation(rate, from_s, to_s).toRotationMatrix().transpose();
}

struct Errors {
  Eigen::Vector3d bias_radps = Eigen::Vector3d::Zero();
  double late_s = 0, noise_radps = 0;
};

void feed(Gyroscope& gyroscope, const Rate& rate, double until_s, const Errors& errors = {}) {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  for (int k = 0; k <= static_cast<int>(until_s * kRate_hz); ++k) {
    const double t = k / kRate_hz;
    const Eigen::Vector3d noise(normal(engine), normal(engine), normal(engine));
    gyroscope.add({t + errors.late_s,
                   mounting().transpose() * rate(t) + errors.bias_radps + errors.noise_radps * noise});
  }
}

double angle_deg(const Eigen::Matrix3d& R) {
  return rotation_vector(R).norm() / kDeg;
}

Gyroscope mounted() {
  return Gyroscope({mounting(), {}, 100});
}

}  // namespace

TEST_CASE("gyroscope: a constant rate turns the view by its angle, the other way") {
  Gyroscope gyroscope = mounted();
  feed(
      gyroscope, [](double) { return Eigen::Vector3d(0, 0.3, 0); }, 1);
  const std::optional<MotionPrior> prior = gyroscope.prior(0.1, 0.6);
  REQUIRE(prior);
  CHECK(prior->valid());
  CHECK_FALSE(prior->has_translation);
  const Eigen::Vector3d vector = rotation_vector(prior->T_current_reference.R());
  CHECK((vector - Eigen::Vector3d(0, -0.15, 0)).norm() < 1e-9);
  // The camera turns to the right (y is down), so a point ahead moves to the left.
  CHECK((prior->T_current_reference.R() * Eigen::Vector3d(0, 0, 1)).x() < 0);
}

TEST_CASE("gyroscope: shaken, it agrees with an integration in steps of 50 us, on and between samples") {
  Gyroscope gyroscope = mounted();
  feed(gyroscope, shaken, 2);
  for (const double from_s : {0.1, 0.5013, 1.2})
    for (const double over_s : {0.005, 0.0333, 0.1, 0.5}) {
      CAPTURE(from_s);
      CAPTURE(over_s);
      const std::optional<MotionPrior> prior = gyroscope.prior(from_s, from_s + over_s);
      REQUIRE(prior);
      const Eigen::Matrix3d truth = turn(shaken, from_s, from_s + over_s);
      CHECK(angle_deg(prior->T_current_reference.R() * truth.transpose()) < 0.02);
    }
}

TEST_CASE("gyroscope: the errors are what the covariance says") {
  // Density d at 200 Hz: each sample has d sqrt(200). Over T the angle has d sqrt(T).
  GyroNoise noise;
  noise.density_radps_rthz = 0.002;
  noise.first_bias_radps = 1e-9;
  double sum2 = 0, claimed2 = 0;
  int n = 0;
  Gyroscope gyroscope({mounting(), noise, 100});
  feed(gyroscope, [](double) { return Eigen::Vector3d::Zero().eval(); }, 40,
       {Eigen::Vector3d::Zero(), 0, noise.density_radps_rthz * std::sqrt(kRate_hz)});
  for (double t = 0.1; t < 39; t += 0.2) {
    const std::optional<MotionPrior> prior = gyroscope.prior(t, t + 0.2);
    REQUIRE(prior);
    sum2 += rotation_vector(prior->T_current_reference.R()).squaredNorm();
    claimed2 += prior->covariance_matrix().bottomRightCorner<3, 3>().trace();
    ++n;
  }
  CHECK(std::sqrt(sum2 / claimed2) == doctest::Approx(1).epsilon(0.1));  // 3 n = 585 samples: 3 % each
  CHECK(n > 190);
}

TEST_CASE("gyroscope: bias and clock are learned from poses, and wrong poses do no harm") {
  const Eigen::Vector3d bias(0.03, -0.02, 0.01);
  for (const double late_s : {0.0, 0.02, -0.035}) {
    CAPTURE(late_s);
    Gyroscope gyroscope = mounted();
    feed(gyroscope, shaken, 8, {bias, late_s, 0.002});
    std::mt19937_64 engine(3);
    std::normal_distribution<double> normal;
    for (int k = 6; k < 150; ++k) {
      const double from_s = k * kFrame_s, to_s = from_s + kFrame_s;
      const Eigen::Vector3d error(normal(engine), normal(engine), normal(engine));
      Eigen::Matrix3d R = exp_so3(0.02 * kDeg * error) * turn(shaken, from_s, to_s);
      if (k % 7 == 0) R = exp_so3(Eigen::Vector3d(0.02, 0, -0.03)) * R;  // the host lost its way
      gyroscope.observe(from_s, to_s, R);
    }
    CHECK(gyroscope.offset_s() == doctest::Approx(late_s).epsilon(0).scale(1).epsilon(0.0015));
    CHECK(gyroscope.offset_sigma_s() < 0.002);
    CHECK((gyroscope.bias_radps() - bias).norm() < 0.004);
    CHECK(gyroscope.bias_sigma_radps() < 0.004);
    const std::optional<MotionPrior> prior = gyroscope.prior(4, 4 + kFrame_s);
    REQUIRE(prior);
    CHECK(angle_deg(prior->T_current_reference.R() * turn(shaken, 4, 4 + kFrame_s).transpose()) < 0.05);
  }
}

TEST_CASE("gyroscope: exchanged axes are found within a second, and then there is no prior") {
  const Rate exchanged = [](double t) -> Eigen::Vector3d {
    const Eigen::Vector3d w = shaken(t);
    return {w.y(), w.x(), w.z()};
  };
  for (const double noise_deg : {0.02, 0.2}) {
    CAPTURE(noise_deg);
    Gyroscope wrong = mounted(), right = mounted();
    feed(wrong, exchanged, 4);
    feed(right, shaken, 4);
    std::mt19937_64 engine(3);
    std::normal_distribution<double> normal;
    for (int k = 1; k < 60; ++k) {
      const double from_s = k * kFrame_s, to_s = from_s + kFrame_s;
      const Eigen::Vector3d error(normal(engine), normal(engine), normal(engine));
      const Eigen::Matrix3d R = exp_so3(noise_deg * kDeg * error) * turn(shaken, from_s, to_s);
      for (Gyroscope* gyroscope : {&wrong, &right}) gyroscope->observe(from_s, to_s, R);
      CHECK(right.axes_fit());
      if (k > 30) CHECK_FALSE(wrong.axes_fit());
    }
    CHECK_FALSE(wrong.prior(2, 2 + kFrame_s));
    CHECK(right.prior(2, 2 + kFrame_s));
  }
}

// A phone in a holder: with exact poses every degree is seen.
TEST_CASE("gyroscope: a mounting that is a few degrees off still gives priors") {
  for (const double off_deg : {1.0, 5.0, 15.0}) {
    CAPTURE(off_deg);
    const Eigen::Matrix3d off = exp_so3(off_deg * kDeg * Eigen::Vector3d(0.6, 0, 0.8));
    Gyroscope gyroscope = mounted();
    feed(
        gyroscope, [&](double t) -> Eigen::Vector3d { return off * shaken(t); }, 4);
    for (int k = 1; k < 100; ++k) {
      const double from_s = k * kFrame_s, to_s = from_s + kFrame_s;
      gyroscope.observe(from_s, to_s, turn(shaken, from_s, to_s));
      CHECK(gyroscope.axes_fit());
    }
    CHECK(gyroscope.prior(2, 2 + kFrame_s));
  }
}

TEST_CASE("gyroscope: where nothing turns the clock is not known, and stays as it was") {
  Gyroscope gyroscope = mounted();
  feed(gyroscope, [](double) { return Eigen::Vector3d::Zero().eval(); }, 4,
       {Eigen::Vector3d(0.01, 0, 0), 0, 0.002});
  for (int k = 1; k < 100; ++k)
    gyroscope.observe(k * kFrame_s, (k + 1) * kFrame_s, Eigen::Matrix3d::Identity());
  CHECK(std::abs(gyroscope.offset_s()) < 1e-9);
  CHECK((gyroscope.bias_radps() - Eigen::Vector3d(0.01, 0, 0)).norm() < 0.001);
}

TEST_CASE("gyroscope: repeats, disorder and what is not finite change nothing; gaps give no prior") {
  Gyroscope tidy = mounted(), untidy = mounted();
  feed(tidy, shaken, 1);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (int k = 0; k <= 200; ++k) {
    const int other = k % 2 == 0 && k < 200 ? k + 1 : k % 2 == 1 ? k - 1 : k;  // pairs change places
    const double t = other / kRate_hz;
    const GyroSample sample{t, mounting().transpose() * shaken(t)};
    untidy.add(sample);
    untidy.add({t, Eigen::Vector3d(9, 9, 9)});
    untidy.add({kNan, Eigen::Vector3d(1, 1, 1)});
    untidy.add({t + 0.001, Eigen::Vector3d(kNan, 0, 0)});
  }
  const std::optional<MotionPrior> a = tidy.prior(0.2, 0.7), b = untidy.prior(0.2, 0.7);
  REQUIRE(a);
  REQUIRE(b);
  CHECK(a->T_current_reference.rotation == b->T_current_reference.rotation);

  CHECK_FALSE(tidy.prior(0.7, 0.2));
  CHECK_FALSE(tidy.prior(0.9, 1 + 2 * Gyroscope::kMostGap_s));
  CHECK_FALSE(tidy.prior(-1, 0.5));
  CHECK_FALSE(mounted().prior(0, 1));
  Gyroscope gappy = mounted();
  for (const double t : {0.0, 0.005, 0.01, 0.2, 0.205}) gappy.add({t, Eigen::Vector3d::Zero()});
  CHECK(gappy.prior(0.001, 0.009));
  CHECK_FALSE(gappy.prior(0.001, 0.2));
}

TEST_CASE("gyroscope: old samples are forgotten") {
  Gyroscope gyroscope({mounting(), {}, 1});
  feed(gyroscope, shaken, 5);
  CHECK(gyroscope.prior(4.5, 4.6));
  CHECK_FALSE(gyroscope.prior(2, 2.1));
}

}  // namespace gyroscope_test
