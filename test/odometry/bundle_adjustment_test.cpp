// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <odometry/bundle_adjustment.hpp>
#include <random>
#include <string>

#include "test_images.hpp"

#include "doctest_beside_glog.hpp"

namespace bundle_adjustment_test {

using namespace dynfilter::odometry;

namespace {

const Pinhole kCamera(odometry_test::camera(), 40.0);
constexpr int kKeyframes = 5, kPoints = 80;

double between(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / 4294967295.0;
}

Eigen::Isometry3d camera_at(int k) {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.linear() = Eigen::AngleAxisd(0.03 * k, Eigen::Vector3d::UnitY()).toRotationMatrix();
  T_world_camera.translation() = Eigen::Vector3d(0.1 * k, 0.02 * k, 0.05 * k);
  return T_world_camera.inverse();
}

struct Scene {
  Map map;
  std::vector<Eigen::Vector3d> truth;
  Sighting sighting(const Observation& o) const {
    Sighting s;
    s.measured_px = kCamera.project(camera_at(o.keyframe) * truth[o.feature]);
    s.disparity_weight = o.feature % 2 ? 2.0 : 0.0;
    return s;
  }
};

/// Every keyframe observes every point as the feature with the same number.
Scene scene() {
  Scene s;
  std::mt19937 random(7);
  for (int k = 0; k < kKeyframes; ++k) {
    Keyframe keyframe;
    keyframe.set_pose(camera_at(k));
    keyframe.features.map_point.assign(kPoints, -1);
    s.map.keyframes.push_back(keyframe);
  }
  for (int i = 0; i < kPoints; ++i) {
    s.truth.emplace_back(between(random, -0.8, 1.2), between(random, -0.7, 0.7), between(random, 1.5, 4));
    MapPoint point;
    point.world_m = s.truth.back();
    s.map.points.push_back(point);
    for (int k = 0; k < kKeyframes; ++k) s.map.observe(i, k, i);
  }
  return s;
}

}  // namespace

TEST_CASE("the derivatives are those of finite differences") {
  const Eigen::Isometry3d T = camera_at(3);
  const Eigen::Vector3d world(0.4, -0.3, 2.5);
  Sighting s;
  s.measured_px = Eigen::Vector3d(300, 200, 12);
  s.pixel_weight = 0.7;
  s.disparity_weight = 2;
  const SightingCost cost(kCamera, s);
  double x[7], r[3], Jx[21], Jp[9];
  PoseManifold::from_pose(T, x);
  const double* parameters[] = {x, world.data()};
  double* jacobians[] = {Jx, Jp};
  REQUIRE(cost.Evaluate(parameters, r, jacobians));
  const double h = 1e-6;
  for (int k = 0; k < 6; ++k) {
    double plus[7], minus[7], rp[3], rm[3];
    const Vector6d step = h * Vector6d::Unit(k), back = -step;
    REQUIRE(PoseManifold().Plus(x, step.data(), plus));
    REQUIRE(PoseManifold().Plus(x, back.data(), minus));
    const double *a[] = {plus, world.data()}, *b[] = {minus, world.data()};
    cost.Evaluate(a, rp, nullptr);
    cost.Evaluate(b, rm, nullptr);
    for (int i = 0; i < 3; ++i)
      CHECK(Jx[7 * i + k] == doctest::Approx((rp[i] - rm[i]) / (2 * h)).epsilon(1e-5));
  }
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d up = world + h * Eigen::Vector3d::Unit(k),
                          down = world - h * Eigen::Vector3d::Unit(k);
    double rp[3], rm[3];
    const double *a[] = {x, up.data()}, *b[] = {x, down.data()};
    cost.Evaluate(a, rp, nullptr);
    cost.Evaluate(b, rm, nullptr);
    for (int i = 0; i < 3; ++i)
      CHECK(Jp[3 * i + k] == doctest::Approx((rp[i] - rm[i]) / (2 * h)).epsilon(1e-5));
  }
}

TEST_CASE("disturbed poses and points return to where the sightings put them") {
  Scene s = scene();
  std::mt19937 random(8);
  for (int k = 1; k < kKeyframes; ++k)
    s.map.keyframes[k].set_pose(
        moved(camera_at(k), (Vector6d() << 0.01, -0.01, 0.02, 0.004, 0.003, -0.005).finished()));
  for (int i = 0; i < kPoints; ++i)
    for (int axis = 0; axis < 3; ++axis) s.map.points[i].world_m[axis] += between(random, -0.02, 0.02);
  BundleOptions options;
  options.max_iterations = 20;
  BundleAdjuster(kCamera, options).adjust(s.map, {0, 1, 2, 3, 4}, [&](const Observation& o) {
    return s.sighting(o);
  });
  for (int k = 0; k < kKeyframes; ++k)
    CHECK((s.map.keyframes[k].T_camera_world.matrix() - camera_at(k).matrix()).norm() < 1e-3);
  double worst = 0;
  for (int i = 0; i < kPoints; ++i) worst = std::max(worst, (s.map.points[i].world_m - s.truth[i]).norm());
  CHECK(worst < 5e-3);
}

TEST_CASE("keyframes outside the window stay, and hold it") {
  Scene s = scene();
  const Eigen::Matrix4d first = s.map.keyframes[1].T_camera_world.matrix();
  s.map.keyframes[4].set_pose(moved(camera_at(4), (Vector6d() << 0.02, 0, 0.01, 0, 0.01, 0).finished()));
  BundleAdjuster(kCamera, {}).adjust(s.map, {3, 4}, [&](const Observation& o) { return s.sighting(o); });
  CHECK(s.map.keyframes[1].T_camera_world.matrix() == first);
  CHECK((s.map.keyframes[4].T_camera_world.matrix() - camera_at(4).matrix()).norm() < 2e-3);
}

TEST_CASE("a wrong sighting is dropped, on both sides") {
  Scene s = scene();
  const auto wrong = [&](const Observation& o) {
    Sighting sighting = s.sighting(o);
    if (o.keyframe == 2 && o.feature == 5) sighting.measured_px.x() += 40;
    return sighting;
  };
  BundleAdjuster(kCamera, {}).adjust(s.map, {0, 1, 2, 3, 4}, wrong);
  CHECK(s.map.points[5].observations.size() == kKeyframes - 1);
  CHECK(s.map.keyframes[2].features.map_point[5] == -1);
  CHECK(s.map.points[6].observations.size() == kKeyframes);
  CHECK((s.map.points[5].world_m - s.truth[5]).norm() < 0.01);
}

/// What is written to stderr in its lifetime.
class CapturedErrors {
 public:
  CapturedErrors() : file_(std::tmpfile()), before_(dup(STDERR_FILENO)) {
    dup2(fileno(file_), STDERR_FILENO);
  }
  CapturedErrors(const CapturedErrors&) = delete;
  CapturedErrors& operator=(const CapturedErrors&) = delete;
  ~CapturedErrors() { end(), std::fclose(file_); }
  std::string end() {
    if (before_ >= 0) dup2(before_, STDERR_FILENO), close(before_);
    before_ = -1;
    std::string text;
    std::rewind(file_);
    for (int c = std::fgetc(file_); c != EOF; c = std::fgetc(file_)) text += static_cast<char>(c);
    return text;
  }

 private:
  std::FILE* file_;
  int before_;
};

TEST_CASE("a point behind a camera neither ends the adjustment nor is logged") {
  Scene s = scene();
  s.map.points[9].world_m.z() = -1;
  s.map.keyframes[4].set_pose(moved(camera_at(4), (Vector6d() << 0.02, 0, 0.01, 0, 0.01, 0).finished()));
  CapturedErrors errors;
  BundleAdjuster(kCamera, {}).adjust(s.map, {3, 4}, [&](const Observation& o) { return s.sighting(o); });
  CHECK(errors.end() == "");
  CHECK((s.map.keyframes[4].T_camera_world.matrix() - camera_at(4).matrix()).norm() < 2e-3);
  CHECK(s.map.points[9].observations.empty());
}

TEST_CASE("Ceres writes nothing, not even where it fails, and others may log again after it") {
  const int before = FLAGS_minloglevel;
  Scene s = scene();
  const auto broken = [&](const Observation& o) {
    Sighting sighting = s.sighting(o);
    if (o.feature == 3) sighting.measured_px.x() = NAN;
    return sighting;
  };
  CapturedErrors errors;
  BundleAdjuster(kCamera, {}).adjust(s.map, {0, 1, 2, 3, 4}, broken);
  CHECK(errors.end() == "");
  CHECK(FLAGS_minloglevel == before);
}

}  // namespace bundle_adjustment_test
