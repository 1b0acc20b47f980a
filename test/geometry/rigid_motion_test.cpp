// SPDX-License-Identifier: MIT
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <dynfilter/geometry/detail/rigid_points.hpp>
#include <dynfilter/geometry/rigid_least_squares.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/rigid_residual.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/geometry/undistort.hpp>

#include "doctest/doctest.h"
#include "geometry/rigid_scene.hpp"

namespace rigid_motion_test {

using namespace dynfilter;
using geometry_test::camera;
using geometry_test::normal_vector;
using geometry_test::pose_error;
using geometry_test::RigidScene;

TEST_CASE("rigid motion: exact points give the exact pose, as Eigen::umeyama does") {
  for (int seed = 1; seed <= 5; ++seed) {
    const RigidScene scene(200, 0, seed, /*noise=*/0);
    RigidMotionEstimator estimator;
    const RigidMotion motion = estimator.estimate(camera(), scene.reference, scene.current, scene.all());
    REQUIRE(motion.ok);
    CHECK(motion.inliers == 200);
    Eigen::Matrix3Xd p(3, 200), c(3, 200);
    for (int i = 0; i < 200; ++i) {
      p.col(i) << scene.reference[i].x, scene.reference[i].y, scene.reference[i].z;
      c.col(i) << scene.current[i].x, scene.current[i].y, scene.current[i].z;
    }
    const Eigen::Isometry3d twin(Eigen::umeyama(p, c, false));
    CHECK(pose_error(motion.T_current_reference, Pose::from(twin)) < 1e-6);
    CHECK(pose_error(motion.T_current_reference, scene.truth) < 1e-6);
  }
}

TEST_CASE("rigid motion: noise and outliers") {
  for (double outliers : {0.0, 0.3, 0.5, 0.6}) {
    const RigidScene scene(1000, outliers, 7, 1);
    RigidMotionEstimator estimator;
    const RigidMotion motion = estimator.estimate(camera(), scene.reference, scene.current, scene.all());
    CAPTURE(outliers);
    REQUIRE(motion.ok);
    CHECK(pose_error(motion.T_current_reference, scene.truth) < 0.004);
    CHECK(motion.inliers > 0.93 * (1 - outliers) * 1000);
    CHECK(motion.inliers < (1 - outliers) * 1000 + 20);
    CHECK(motion.sigma0 > 0.6);
    CHECK(motion.sigma0 < 1.2);
  }
}

TEST_CASE("rigid motion: the covariance is that of the errors") {
  // Sum of the Mahalanobis errors of 200 scenes: chi-square with 1200 degrees of freedom, sd 49.
  // A Tukey loss at 3.5 sigma loses some efficiency, so one without effect is used.
  double sum = 0;
  for (int seed = 1; seed <= 200; ++seed) {
    const RigidScene scene(100, 0, seed, 1);
    RigidMotionOptions options;
    options.loss_scale = 1e6;
    options.pixel_sigma_px = geometry_test::kPixelSigma;
    RigidMotionEstimator estimator(options);
    const RigidMotion motion =
        estimator.refine(camera(), scene.reference, scene.current, scene.all(), scene.truth);
    REQUIRE(motion.ok);
    const Eigen::Matrix3d dR = motion.T_current_reference.R() * scene.truth.R().transpose();
    const Eigen::AngleAxisd turn(dR);
    Eigen::Matrix<double, 6, 1> error;
    error << motion.T_current_reference.t() - dR * scene.truth.t(), turn.angle() * turn.axis();
    const Eigen::Map<const Eigen::Matrix<double, 6, 6>> C(motion.covariance.data());
    sum += error.dot(C.llt().solve(error));
  }
  CHECK(sum > 1200 - 4 * 49);
  CHECK(sum < 1200 + 6 * 49);
}

TEST_CASE("rigid motion: a refinement may end within a share of its standard deviation from the optimum") {
  for (int seed = 1; seed <= 20; ++seed) {
    const RigidScene scene(100, 0, seed, 1);
    RigidMotionOptions options;
    options.pixel_sigma_px = geometry_test::kPixelSigma;
    options.refine_iterations = 50;
    options.loss_scale = 1e6;  // reweighting converges slowly: the step says less about the distance
    const auto refined = [&](double until_sigmas) {
      options.refine_until_sigmas = until_sigmas;
      const Pose start = Pose::from(scene.truth.R(), scene.truth.t() + Eigen::Vector3d(0.01, -0.01, 0.01));
      return RigidMotionEstimator(options).refine(camera(), scene.reference, scene.current, scene.all(),
                                                  start);
    };
    const RigidMotion best = refined(0), near = refined(0.1);
    Eigen::Matrix<double, 6, 1> error;
    const Eigen::AngleAxisd turn(near.T_current_reference.R() * best.T_current_reference.R().transpose());
    error << near.T_current_reference.t() - best.T_current_reference.t(), turn.angle() * turn.axis();
    const Eigen::Map<const Eigen::Matrix<double, 6, 6>> C(best.covariance.data());
    const double sigmas = std::sqrt(error.dot(C.llt().solve(error)));
    CHECK(sigmas > 0);  // it did end earlier
    CHECK(sigmas < 0.1);
  }
}

TEST_CASE("rigid motion: degenerate and odd data abstain") {
  RigidMotionEstimator estimator;
  const RigidScene scene(50, 0, 3, 0);
  for (int n = 0; n <= 5; ++n) {
    std::vector<int> few = scene.all();
    few.resize(n);
    CHECK_FALSE(estimator.estimate(camera(), scene.reference, scene.current, few).ok);
  }
  const std::vector<cv::Point3f> same(50, {0.1F, 0.2F, 2.0F});
  CHECK_FALSE(estimator.estimate(camera(), same, same, scene.all()).ok);
  std::vector<cv::Point3f> line;
  for (int i = 0; i < 50; ++i)
    line.emplace_back(0.02F * static_cast<float>(i), 0.01F * static_cast<float>(i), 2.0F);
  const RigidMotion on_line = estimator.estimate(camera(), line, line, scene.all());
  CHECK_FALSE(on_line.ok);
  CHECK(on_line.note == RigidMotionNote::Degenerate);
  CHECK_FALSE(estimator.estimate(camera(), line, line, scene.all(), Pose{}).ok);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (cv::Point3f odd : {cv::Point3f(nan, nan, nan), cv::Point3f(0, 0, 0), cv::Point3f(0, 0, -1),
                          cv::Point3f(0, 0, std::numeric_limits<float>::infinity())}) {
    const std::vector<cv::Point3f> none(50, odd);
    CHECK_FALSE(estimator.estimate(camera(), scene.reference, none, scene.all()).ok);
    std::vector<cv::Point3f> some = scene.current;
    for (int i = 0; i < 20; ++i) some[i] = odd;
    const RigidMotion motion = estimator.estimate(camera(), scene.reference, some, scene.all());
    REQUIRE(motion.ok);
    CHECK(motion.points == 30);
    CHECK(pose_error(motion.T_current_reference, scene.truth) < 1e-6);
  }
  const std::vector<int> wild{-1, 50, 1000000, 0, 1, 2};
  CHECK_FALSE(estimator.estimate(camera(), scene.reference, scene.current, wild).ok);
  const RigidScene chaos(200, 1.0, 5, 1);
  CHECK_FALSE(estimator.estimate(camera(), chaos.reference, chaos.current, chaos.all()).ok);
}

TEST_CASE("rigid motion: a prior lets the background win over a majority of movers") {
  RigidScene scene(400, 0, 11, 1);
  scene.move_rigidly(0, 220, Pose::from(Eigen::Matrix3d::Identity(), {0.15, 0, 0}));
  RigidMotionEstimator estimator;
  const RigidMotion heads = estimator.estimate(camera(), scene.reference, scene.current, scene.all());
  REQUIRE(heads.ok);
  CHECK(pose_error(heads.T_current_reference, scene.truth) > 0.1);
  Pose prior = scene.truth;
  prior.translation_m[0] += 0.01;
  const RigidMotion with = estimator.estimate(camera(), scene.reference, scene.current, scene.all(), prior);
  REQUIRE(with.ok);
  CHECK(with.from_prior);
  CHECK(pose_error(with.T_current_reference, scene.truth) < 0.01);
  // A wrong prior does not win.
  prior.translation_m[0] += 3;
  const RigidMotion wrong = estimator.estimate(camera(), scene.reference, scene.current, scene.all(), prior);
  CHECK_FALSE(wrong.from_prior);
}

TEST_CASE("rigid motion: wider registers score and add up to the same bits") {
  using dynfilter::detail::RigidNormal;
  const RigidScene scene(203, 0.3, 5, 1);
  SampleGenerator rng(8);
  dynfilter::detail::RigidPoints wide, narrow;
  narrow.wide = false;
  for (auto* points : {&wide, &narrow})
    points->pack(camera(), {1.0, DepthNoise()}, scene.reference, scene.current, scene.all());
  int above_none = 0;
  for (int k = 0; k < 200; ++k) {
    dynfilter::detail::RigidTransform T{scene.truth.R(), scene.truth.t()};
    T.t += 0.002 * k * normal_vector(rng);
    for (const double floor : {0.0, 20.0, 100.0})
      CHECK(wide.score(T, 11.34F, floor) == narrow.score(T, 11.34F, floor));
    above_none += wide.score(T, 11.34F, 0) > 0 ? 1 : 0;
  }
  CHECK(above_none > 20);
  for (const double off_m : {0.0, 0.01, 5.0, 1e3})
    for (const std::size_t count : {std::size_t{64}, std::size_t{203}}) {
      dynfilter::detail::RigidTransform T{scene.truth.R(), scene.truth.t()};
      T.t += off_m * Eigen::Vector3d(1, -1, -1);
      const RigidNormal a = accumulate_rigid(wide, 12.25, count, T),
                        b = accumulate_rigid(narrow, 12.25, count, T);
      CHECK(a.matrix == b.matrix);
      CHECK(a.gradient == b.gradient);
      CHECK(a.cost == b.cost);
      CHECK(a.weight_sum == b.weight_sum);
      CHECK((off_m > 0 || a.weight_sum > 20));
    }
}

TEST_CASE("rigid motion: the same twice, and after other work") {
  const RigidScene scene(300, 0.4, 17, 1), other(800, 0.5, 19, 1);
  RigidMotionEstimator a, b;
  b.estimate(camera(), other.reference, other.current, other.all());
  const RigidMotion x = a.estimate(camera(), scene.reference, scene.current, scene.all());
  const RigidMotion y = b.estimate(camera(), scene.reference, scene.current, scene.all());
  CHECK(x.T_current_reference.rotation == y.T_current_reference.rotation);
  CHECK(x.T_current_reference.translation_m == y.T_current_reference.translation_m);
  CHECK(x.covariance == y.covariance);
}

TEST_CASE("rigid residual: hand-computed prediction") {
  // A quarter turn about the optical axis and 1 m forward: (0.5, 0, 3) -> (0, 0.5, 4).
  const Eigen::Matrix3d R = Eigen::AngleAxisd(CV_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Pose T = Pose::from(R, {0, 0, 1});
  const Camera cam = camera();
  const RigidResidual hit = rigid_residual(cam, T, {0.5F, 0, 3}, {0, 0.5F, 4});
  REQUIRE(hit.valid);
  CHECK(hit.predicted_px.x == doctest::Approx(cam.cx_px));
  CHECK(hit.predicted_px.y == doctest::Approx(cam.cy_px + cam.fy_px / 8));
  CHECK(hit.predicted_depth_m == doctest::Approx(4));
  CHECK(hit.chi2 < 1e-9);
  // Two pixels off along the axis without depth noise of the reference point.
  RigidResidualNoise noise;
  noise.pixel_sigma_px = 0.5;
  const float two_px = static_cast<float>(2 / cam.fx_px * 4);
  const RigidResidual miss = rigid_residual(cam, T, {0.5F, 0, 3}, {two_px, 0.5F, 4}, noise);
  CHECK(miss.image_px == doctest::Approx(2).epsilon(1e-4));
  CHECK(miss.chi2 == doctest::Approx(16).epsilon(1e-4));
  CHECK_FALSE(rigid_residual(cam, T, {0.5F, 0, 0}, {0, 0.5F, 4}).valid);
  CHECK_FALSE(rigid_residual(cam, T, {0.5F, 0, 3}, {0, 0.5F, -1}).valid);
  CHECK_FALSE(rigid_residual(cam, Pose::from(R, {0, 0, -5}), {0.5F, 0, 3}, {0, 0.5F, 4}).valid);
}

namespace {

/// chi2 as in the header's formula, with matrices.
double chi2_in_matrices(const Camera& cam, const Pose& T, const RigidResidualNoise& noise,
                        const Eigen::Matrix<double, 6, 6>& C, const Eigen::Vector3d& p,
                        const Eigen::Vector3d& c) {
  const Eigen::Vector3d q = T.R() * p + T.t();
  Eigen::Matrix3d G, qx;
  G << cam.fx_px / q.z(), 0, -cam.fx_px * q.x() / (q.z() * q.z()),  //
      0, cam.fy_px / q.z(), -cam.fy_px * q.y() / (q.z() * q.z()),   //
      0, 0, 1;
  qx << 0, -q.z(), q.y(), q.z(), 0, -q.x(), -q.y(), q.x(), 0;
  Eigen::Matrix<double, 3, 6> L;
  L << G, -G * qx;
  const Eigen::Vector3d ray = G * T.R() * p / p.z() * noise.depth_noise.sigma_m(p.z());
  const double su2 = std::pow(noise.pixel_sigma_px, 2), sz2 = std::pow(noise.depth_noise.sigma_m(c.z()), 2);
  Eigen::Matrix3d S = ray * ray.transpose() + L * C * L.transpose();
  S.diagonal() += Eigen::Vector3d(su2, su2, sz2);
  const Eigen::Vector3d r(cam.fx_px * (c.x() / c.z() - q.x() / q.z()),
                          cam.fy_px * (c.y() / c.z() - q.y() / q.z()), c.z() - q.z());
  return r.dot(S.ldlt().solve(r));
}

}  // namespace

TEST_CASE("rigid residual: chi2 is the one of the full covariance, with and without that of the motion") {
  SampleGenerator rng(7);
  const Camera cam = camera();
  for (int k = 0; k < 200; ++k) {
    CAPTURE(k);
    Eigen::Matrix<double, 6, 6> half;
    for (int i = 0; i < 36; ++i) half.data()[i] = 0.003 * rng.normal();
    const Eigen::Matrix<double, 6, 6> C = k % 4 == 0 ? Eigen::Matrix<double, 6, 6>::Zero()
                                                     : Eigen::Matrix<double, 6, 6>(half * half.transpose());
    const Eigen::Vector3d axis = normal_vector(rng);
    const Pose T = Pose::from(Eigen::AngleAxisd(0.3 * rng.normal(), axis.normalized()).toRotationMatrix(),
                              {0.1 * rng.normal(), 0.1 * rng.normal(), 0.1 * rng.normal()});
    const cv::Point3f p(static_cast<float>(rng.uniform(-1, 1)), static_cast<float>(rng.uniform(-1, 1)),
                        static_cast<float>(rng.uniform(1.5, 4)));
    const Eigen::Vector3d q = T.R() * Eigen::Vector3d(p.x, p.y, p.z) + T.t();
    const cv::Point3f c(static_cast<float>(q.x() + 0.02 * rng.normal()),
                        static_cast<float>(q.y() + 0.02 * rng.normal()),
                        static_cast<float>(q.z() + 0.05 * rng.normal()));
    RigidResidualNoise noise;
    noise.pixel_sigma_px = rng.uniform(0.2, 2);
    const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> rows = C;
    const RigidResidual judged = rigid_residual(cam, T, p, c, noise, k % 8 == 0 ? nullptr : rows.data());
    REQUIRE(judged.valid);
    CHECK(
        static_cast<double>(judged.chi2) ==
        doctest::Approx(chi2_in_matrices(cam, T, noise, C, {p.x, p.y, p.z}, {c.x, c.y, c.z})).epsilon(1e-5));
  }
}

TEST_CASE("rigid residual: static points follow chi-square with 3 degrees of freedom") {
  RigidResidualNoise noise;
  noise.pixel_sigma_px = geometry_test::kPixelSigma;
  double sum = 0;
  int n = 0, above = 0;
  for (int seed = 1; seed <= 10; ++seed) {
    const RigidScene scene(500, 0, seed, 1);
    RigidMotionOptions options;
    options.pixel_sigma_px = geometry_test::kPixelSigma;
    RigidMotionEstimator estimator(options);
    const RigidMotion motion = estimator.estimate(camera(), scene.reference, scene.current, scene.all());
    const RigidResidualModel judge(camera(), motion.T_current_reference, noise, motion.covariance.data());
    for (int i = 0; i < 500; ++i, ++n) {
      const double chi2 = judge(scene.reference[i], scene.current[i]).chi2;
      sum += chi2;
      above += chi2 > 7.815;
    }
  }
  CHECK(sum / n == doctest::Approx(3).epsilon(0.05));
  CHECK(above < 0.065 * n);
  CHECK(above > 0.035 * n);
}

}  // namespace rigid_motion_test
