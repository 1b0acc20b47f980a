// SPDX-License-Identifier: MIT
#include <odometry/bundle_adjustment.hpp>
#include <odometry/pose_refinement.hpp>
#include <random>

#include "test_images.hpp"

#include "doctest_beside_glog.hpp"

namespace pose_refinement_test {

using namespace dynfilter::odometry;

namespace {

const Pinhole kCamera(odometry_test::camera(), 40.0);

double between(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / 4294967295.0;
}

/// Points in view of the pose; every third one without depth. Noise in pixels.
std::vector<PosePoint> sightings(const Eigen::Isometry3d& T_camera_world, int n, double noise_px,
                                 unsigned seed) {
  std::mt19937 random(seed);
  std::vector<PosePoint> points;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d p =
        kCamera.back_project(between(random, 20, 620), between(random, 20, 460), between(random, 0.8, 5.0));
    PosePoint point;
    point.world_m = T_camera_world.inverse() * p;
    point.sighting.measured_px = kCamera.project(p);
    for (int k = 0; k < 3; ++k) point.sighting.measured_px[k] += between(random, -noise_px, noise_px);
    point.sighting.disparity_weight = i % 3 ? 2.0 : 0.0;
    points.push_back(point);
  }
  return points;
}

Eigen::Isometry3d pose(double angle_rad, const Eigen::Vector3d& t) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  T.translation() = t;
  return T;
}

double distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.matrix() - b.matrix()).norm();
}

}  // namespace

TEST_CASE("exact sightings give the exact pose") {
  const Eigen::Isometry3d truth = pose(0.3, {0.5, -0.2, 0.4});
  const auto points = sightings(truth, 60, 0, 1);
  Eigen::Isometry3d T = moved(truth, (Vector6d() << 0.05, -0.04, 0.06, 0.03, -0.02, 0.04).finished());
  std::vector<std::uint8_t> inlier;
  CHECK(PoseRefiner(kCamera).refine(points, T, inlier) == 60);
  CHECK(distance(T, truth) < 1e-7);
}

TEST_CASE("a third of wrong points is found out") {
  const Eigen::Isometry3d truth = pose(-0.2, {0.1, 0.2, -0.3});
  auto points = sightings(truth, 300, 0.5, 2);
  std::mt19937 random(3);
  for (std::size_t i = 0; i < 100; ++i) {
    points[i].sighting.measured_px.x() += between(random, 10, 60);
    points[i].sighting.measured_px.y() -= between(random, 10, 60);
  }
  Eigen::Isometry3d T = moved(truth, (Vector6d() << 0.02, -0.01, 0.02, 0.01, -0.01, 0.01).finished());
  std::vector<std::uint8_t> inlier;
  const int count = PoseRefiner(kCamera).refine(points, T, inlier);
  CHECK(count >= 190);
  CHECK(std::count(inlier.begin(), inlier.begin() + 100, 1) == 0);
  CHECK((T.translation() - truth.translation()).norm() < 0.003);
  CHECK(distance(T, truth) < 0.005);
}

/// Two dozen distant points in a corner of the view: translation is similar to rotation.
std::vector<PosePoint> few_far_sightings(const Eigen::Isometry3d& T_camera_world, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<PosePoint> points;
  for (int i = 0; i < 24; ++i) {
    const Eigen::Vector3d p =
        kCamera.back_project(between(random, 420, 540), between(random, 80, 200), between(random, 3.5, 4.5));
    PosePoint point;
    point.world_m = T_camera_world.inverse() * p;
    point.sighting.measured_px = kCamera.project(p);
    for (int k = 0; k < 3; ++k) point.sighting.measured_px[k] += between(random, -1, 1);
    point.sighting.disparity_weight = 2;
    points.push_back(point);
  }
  return points;
}

TEST_CASE("an expected pose holds few far points, and many points do not mind a wrong one") {
  const Eigen::Isometry3d truth = pose(0.2, {0.1, -0.1, 0.2});
  const auto off = [&](double m, double rad) {
    return moved(truth, (Vector6d() << m, -m, m, rad, rad, -rad).finished());
  };
  const auto centre = [](const Eigen::Isometry3d& T) -> Eigen::Vector3d { return T.inverse().translation(); };
  std::vector<std::uint8_t> inlier;
  PoseRefiner free(kCamera), held(kCamera), long_ago(kCamera);
  held.expect(off(0.004, 0.002), 1.0 / 30);
  long_ago.expect(off(0.1, 0.05), 1);
  double free_m = 0, held_m = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto points = few_far_sightings(truth, seed);
    Eigen::Isometry3d T = off(0.004, 0.002), with = T, later = T;
    free.refine(points, T, inlier);
    held.refine(points, with, inlier);
    long_ago.refine(points, later, inlier);
    free_m += (centre(T) - centre(truth)).norm() / 20;
    held_m += (centre(with) - centre(truth)).norm() / 20;
    CHECK((centre(later) - centre(T)).norm() < 0.01);  // sigma is 9 m after a second
  }
  CHECK(held_m < 0.02);  // about the sigma of 0.01 m an axis
  CHECK(free_m > 2 * held_m);

  const auto many = sightings(truth, 300, 0.5, 5);
  Eigen::Isometry3d T = off(0.03, 0.01), with = T;
  free.refine(many, T, inlier);
  held.expect(off(0.03, 0.01), 1.0 / 30);
  held.refine(many, with, inlier);
  CHECK((centre(with) - centre(T)).norm() < 0.002);
  held.expect_nothing();
  Eigen::Isometry3d again = off(0.03, 0.01);
  held.refine(many, again, inlier);
  CHECK(distance(again, T) == 0);
}

TEST_CASE("one round is the minimum that ceres::Problem finds") {
  const Eigen::Isometry3d truth = pose(0.4, {-0.3, 0.1, 0.2});
  auto points = sightings(truth, 200, 1.5, 4);
  for (std::size_t i = 0; i < 40; ++i)
    points[i].sighting.measured_px.x() += 12;  // in the linear part of Huber
  const Eigen::Isometry3d start =
      moved(truth, (Vector6d() << 0.03, 0.02, -0.03, 0.02, 0.01, -0.02).finished());

  RefinementOptions options;
  options.rounds = 1;
  options.iterations = 50;
  Eigen::Isometry3d ours = start;
  std::vector<std::uint8_t> inlier;
  const PoseRefiner refiner(kCamera, options);
  refiner.refine(points, ours, inlier);

  double x[7];
  PoseManifold::from_pose(start, x);
  ceres::Problem problem;
  problem.AddParameterBlock(x, 7, new PoseManifold);
  for (PosePoint& point : points) {
    problem.AddResidualBlock(new SightingCost(kCamera, point.sighting), new ceres::HuberLoss(options.huber),
                             x, point.world_m.data());
    problem.SetParameterBlockConstant(point.world_m.data());
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.function_tolerance = solver.gradient_tolerance = solver.parameter_tolerance = 1e-14;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  const std::vector<std::uint8_t> all(points.size(), 1);
  CHECK(refiner.cost(points, all, ours) == doctest::Approx(summary.final_cost).epsilon(1e-6));
  CHECK(distance(ours, PoseManifold::to_pose(x)) < 1e-4);
}

TEST_CASE("too few points, and points behind the camera, leave a finite pose") {
  const Eigen::Isometry3d truth = pose(0.1, {0, 0, 0});
  std::vector<std::uint8_t> inlier;
  Eigen::Isometry3d T = truth;
  CHECK(PoseRefiner(kCamera).refine({}, T, inlier) == 0);
  auto points = sightings(truth, 30, 0, 5);
  for (std::size_t i = 0; i < 10; ++i) points[i].world_m = truth.inverse() * Eigen::Vector3d(0.1, 0, -1);
  CHECK(PoseRefiner(kCamera).refine(points, T, inlier) == 20);
  CHECK(T.matrix().allFinite());
  CHECK(distance(T, truth) < 1e-6);
}

TEST_CASE("whitening: the inverse of the covariance, with what a sighting slides along an edge") {
  Sighting s;
  s.pixel_weight = 0.8, s.disparity_weight = 2;
  CHECK(s.whitening().isApprox(Eigen::Vector3d(0.8, 0.8, 2).asDiagonal().toDenseMatrix()));
  s.slide_px = {3, -4, 0.5};
  Eigen::Matrix3d S = Eigen::Vector3d(1 / 0.64, 1 / 0.64, 0.25).asDiagonal();
  S += s.slide_px * s.slide_px.transpose();
  CHECK((s.whitening().transpose() * s.whitening()).isApprox(S.inverse(), 1e-9));
  s.disparity_weight = 0;  // no depth: the image alone
  const Eigen::Matrix2d image = S.topLeftCorner<2, 2>();
  const Eigen::Matrix3d information = s.whitening().transpose() * s.whitening();
  CHECK(information.topLeftCorner<2, 2>().isApprox(image.inverse(), 1e-9));
  CHECK(information.row(2).isZero());
}

}  // namespace pose_refinement_test
