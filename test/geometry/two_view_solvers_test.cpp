// SPDX-License-Identifier: MIT
#include <dynfilter/geometry/detail/two_view_refine.hpp>
#include <dynfilter/geometry/detail/two_view_solvers.hpp>
#include <numeric>

#include "doctest/doctest.h"
#include "geometry/two_view_scene.hpp"

namespace two_view_solvers_test {

using namespace dynfilter;
using namespace dynfilter::detail;

TEST_CASE("cubic: roots that were put in come out") {
  SampleGenerator rng(3);
  for (int trial = 0; trial < 200; ++trial) {
    const double a = rng.uniform(-3, 3), b = rng.uniform(-3, 3), c = rng.uniform(-3, 3);
    double roots[3];
    REQUIRE(real_cubic_roots(2, -2 * (a + b + c), 2 * (a * b + b * c + c * a), -2 * a * b * c, roots) == 3);
    CHECK(roots[0] + roots[1] + roots[2] == doctest::Approx(a + b + c).epsilon(1e-6));
    CHECK(roots[0] * roots[1] * roots[2] == doctest::Approx(a * b * c).epsilon(1e-5));
  }
  double roots[3];
  REQUIRE(real_cubic_roots(1, 0, 0, -8, roots) == 1);
  CHECK(roots[0] == doctest::Approx(2));
  REQUIRE(real_cubic_roots(0, 1, -5, 6, roots) == 2);
  CHECK(roots[0] + roots[1] == doctest::Approx(5));
  REQUIRE(real_cubic_roots(0, 0, 2, 4, roots) == 1);
  CHECK(roots[0] == doctest::Approx(-2));
  CHECK(real_cubic_roots(0, 0, 0, 1, roots) == 0);
  CHECK(real_cubic_roots(0, 1, 0, 1, roots) == 0);
}

TEST_CASE("seven points: one of the solutions is the true F, also for pure translations along an axis") {
  const Eigen::Vector3d translations[] = {{0.1, 0.02, 0.05}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.2}};
  for (const Eigen::Vector3d& t : translations) {
    for (double turn : {0.0, 2.0}) {
      const Eigen::Matrix3d R = geometry_test::motion(turn, {0.3, 1, 0.2}, t).R();
      for (int seed = 1; seed <= 20; ++seed) {
        SampleGenerator rng(seed);
        Eigen::Vector2d p[7], q[7];
        for (int i = 0; i < 7; ++i) {
          const double z = rng.uniform(1, 4);
          const Eigen::Vector3d X(rng.uniform(-1, 1) * z, rng.uniform(-1, 1) * z, z);
          p[i] = X.hnormalized(), q[i] = (R * X + t).hnormalized();
        }
        const Eigen::Matrix3d truth = (cross_matrix(t) * R).normalized();
        Eigen::Matrix3d F[4];
        const int n = solve_seven(p, q, F);
        REQUIRE(n >= 1);
        double best = 1;
        for (int i = 0; i < n; ++i) {
          best = std::min(best, std::min((F[i] - truth).norm(), (F[i] + truth).norm()));
          CHECK(std::abs(F[i].determinant()) < 1e-6);
          if (best < 1e-6) CHECK((oriented(F[i], p, q) || (F[i] - truth).norm() > 1e-6));
        }
        CHECK(best < 1e-5);
      }
    }
  }
}

TEST_CASE("four points: the homography that made them; none from collinear ones") {
  SampleGenerator rng(5);
  for (int trial = 0; trial < 50; ++trial) {
    Eigen::Matrix3d truth = Eigen::Matrix3d::Identity();
    for (int i = 0; i < 8; ++i) truth(i / 3, i % 3) += rng.uniform(-0.1, 0.1);
    const Eigen::Vector2d p[4] = {{-1, -1}, {1, -0.9}, {1.1, 1}, {-0.8, 1}};
    Eigen::Vector2d q[4];
    for (int i = 0; i < 4; ++i) q[i] = (truth * p[i].homogeneous()).hnormalized();
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    REQUIRE(solve_four(p, q, H));
    CHECK((H - truth).norm() < 1e-9);
  }
  const Eigen::Vector2d line[4] = {{0, 0}, {1, 1}, {2, 2}, {1, 0}};
  Eigen::Matrix3d H;
  CHECK_FALSE(solve_four(line, line, H));
}

TEST_CASE("refinement: a disturbed model returns to the exact one") {
  geometry_test::TwoViewRecipe recipe;
  recipe.motion = geometry_test::motion(2, {0.3, 1, 0.2}, {0.08, 0.02, 0.05});
  const geometry_test::TwoViewScene scene(recipe);
  TwoViewPoints points;
  points.pack(scene.reference, scene.current, scene.all());
  const Eigen::Matrix3d K = camera_matrix(geometry_test::camera());
  const Calibration calibration{(points.T1() * K).inverse(), (points.T2() * K).inverse()};
  Essential e{recipe.motion.R(), recipe.motion.t().normalized()};
  const Eigen::Matrix3d truth = calibration.fundamental(e).normalized();
  const double wide = 1e-2, tau2 = std::pow(0.02 * points.scale(), 2);
  Eigen::Matrix3d F = (truth + 0.01 * Eigen::Matrix3d::Random()).normalized();
  refine_fundamental(points, wide, std::vector<double>(10, 1.0), {}, F);
  CHECK(points.inliers(FundamentalError(F), tau2) == 1000);
  e.R = exp_so3({0.002, -0.001, 0.003}) * e.R;
  e.t = (e.t + Eigen::Vector3d(0.05, 0.05, -0.05)).normalized();
  CHECK(points.inliers(FundamentalError(calibration.fundamental(e)), tau2) < 200);
  refine_essential(points, calibration, wide, 10, {}, e);
  CHECK(points.inliers(FundamentalError(calibration.fundamental(e)), tau2) == 1000);
}

TEST_CASE("bail-out: a cost that is returned is the full cost, and none better than the best is lost") {
  geometry_test::TwoViewRecipe recipe;
  recipe.motion = geometry_test::motion(2, {0.3, 1, 0.2}, {0.08, 0.02, 0.05});
  recipe.noise_px = 0.3, recipe.mismatch_count = 300;
  const geometry_test::TwoViewScene scene(recipe);
  TwoViewPoints points;
  points.pack(scene.reference, scene.current, scene.all());
  const double tau2 = std::pow(points.scale(), 2), inf = std::numeric_limits<double>::infinity();
  const Matrix9 in_px = geometry_test::fundamental_from_pose(geometry_test::camera(), recipe.motion);
  const Eigen::Matrix3d px = detail::rows(in_px);
  const Eigen::Matrix3d F = points.T2().inverse().transpose() * px * points.T1().inverse();
  double twin = 0;
  for (std::size_t i = 0; i < points.count(); ++i) {
    const Eigen::Vector3d p = points.reference(i).homogeneous(), q = points.current(i).homogeneous();
    const double e = q.dot(F * p);
    const double den = (F * p).head<2>().squaredNorm() + (F.transpose() * q).head<2>().squaredNorm();
    twin += std::min(1.0, e * e / den / tau2);
  }
  const double full = points.cost(FundamentalError(F), tau2, inf);
  CHECK(full == doctest::Approx(twin).epsilon(0.01));  // up to seven repeated matches
  CHECK(points.cost(FundamentalError(F), tau2, 1.2 * full) == full);
  CHECK(points.cost(FundamentalError(F), tau2, 0.5 * full) == inf);
}

}  // namespace two_view_solvers_test
