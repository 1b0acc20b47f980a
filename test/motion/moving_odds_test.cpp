// SPDX-License-Identifier: MIT
#include <Eigen/Core>
#include <cmath>
#include <dynfilter/motion/moving_odds.hpp>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"

namespace moving_odds_test {

using namespace dynfilter;

namespace {

constexpr double kSlow_mps = 0.05, kFast_mps = 1.0;

/// A miss by its parts: across the edge and along it [px], and in depth [m].
struct Case {
  Eigen::Vector3d miss, variance;
  double px_per_m, elapsed_s;
  int axes;  // 1: on a line, 2: in the image, 3: in space

  MovingOddsInput input() const {
    MovingOddsInput in;
    in.across2_px2 = miss[0] * miss[0];
    in.along2_px2 = axes > 1 ? miss[1] * miss[1] : 0;
    in.sigma_px = std::sqrt(variance[0]);
    in.along = variance[1] / variance[0];
    in.sigma_depth_m = std::sqrt(variance[2] / 2);  // two depths are compared
    in.px_per_m = px_per_m, in.elapsed_s = elapsed_s;
    in.image_axes = axes == 1 ? 1 : 2;
    in.depth_axis = axes == 3;
    for (int k = 0; k < axes; ++k) in.chi2 += miss[k] * miss[k] / variance[k];
    return in;
  }
  /// Logarithm of a multivariate Student t density of six degrees of freedom, by definition.
  double log_density(double speed_mps) const {
    constexpr double kNu = 6, kPi = 3.14159265358979323846;
    double chi2 = 0, log_determinant = 0;
    for (int k = 0; k < axes; ++k) {
      const double moved = speed_mps * elapsed_s * (k < 2 ? px_per_m : 1);
      const double wide = variance[k] + moved * moved;
      chi2 += miss[k] * miss[k] / wide, log_determinant += std::log(wide);
    }
    return std::lgamma((kNu + axes) / 2) - std::lgamma(kNu / 2) - axes / 2.0 * std::log(kNu * kPi) -
           log_determinant / 2 - (kNu + axes) / 2 * std::log1p(chi2 / kNu);
  }
  /// From the densities, three of five movers being fast.
  double log_odds() const {
    const double moves = 0.4 * std::exp(log_density(kSlow_mps)) + 0.6 * std::exp(log_density(kFast_mps));
    return std::log(moves) - log_density(0);
  }
};

Case random_case(cv::RNG& rng, int axes) {
  Case c{};
  c.axes = axes;
  c.variance = {std::pow(rng.uniform(0.1, 1.0), 2), 0, std::pow(rng.uniform(0.005, 0.1), 2)};
  // Without a depth the whole chi2 is compared, whatever the edge.
  c.variance[1] = c.variance[0] * (axes == 3 ? rng.uniform(1.0, 100.0) : 1.0);
  for (int k = 0; k < axes; ++k) c.miss[k] = rng.gaussian(4 * std::sqrt(c.variance[k]));
  c.px_per_m = rng.uniform(50.0, 500.0);
  c.elapsed_s = rng.uniform(0.01, 0.3);
  return c;
}

}  // namespace

TEST_CASE("odds of motion are a ratio of Student t densities, two of movers to that of rest") {
  const MovingOdds odds;
  cv::RNG rng(7);
  for (const int axes : {1, 2, 3})
    for (int k = 0; k < 300; ++k) {
      const Case c = random_case(rng, axes);
      CAPTURE(axes);
      CAPTURE(k);
      CHECK(odds(c.input()) == doctest::Approx(c.log_odds()).epsilon(1e-6));
    }
}

TEST_CASE("odds of motion: where the noise hides all motion, nothing is said, whatever is missed") {
  const MovingOdds odds;
  cv::RNG rng(8);
  for (int k = 0; k < 100; ++k) {
    Case c = random_case(rng, 3);
    c.variance *= 1e12;
    c.miss *= 1e6;
    CHECK(std::abs(odds(c.input())) < 1e-6);
  }
}

TEST_CASE("odds of motion: a large miss accuses, none acquits, noise beyond any motion says nothing") {
  const MovingOdds odds;
  MovingOddsInput in;
  in.sigma_px = 0.2, in.sigma_depth_m = 0.02, in.px_per_m = 250, in.elapsed_s = 0.2;
  CHECK(odds(in) < -1);
  in.across2_px2 = 100, in.chi2 = 2500;
  CHECK(odds(in) > 5);
  in.sigma_px = in.sigma_depth_m = 1e6, in.chi2 = 1e-10;
  CHECK(std::abs(odds(in)) < 1e-3);
}

TEST_CASE("odds of motion: along an edge on which the match slides, a miss says nothing; across it, all") {
  const MovingOdds odds;
  MovingOddsInput in;
  in.sigma_px = 0.2, in.sigma_depth_m = 0.02, in.px_per_m = 250, in.elapsed_s = 0.2, in.along = 1e4;
  const double rest = odds(in);
  in.along2_px2 = 100, in.chi2 = 100 / (0.04 * 1e4);
  CHECK(odds(in) == doctest::Approx(rest).epsilon(0.05));
  in.along = 1, in.chi2 = 2500;
  const double corner = odds(in);
  in.along2_px2 = 0, in.across2_px2 = 100;
  CHECK(odds(in) == corner);  // a corner knows no direction
  in.along = 1e4;
  CHECK(odds(in) > 5);
}

}  // namespace moving_odds_test
