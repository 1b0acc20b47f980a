// SPDX-License-Identifier: MIT
#include <cmath>
#include <odometry/odometry.hpp>
#include <odometry/recovery.hpp>
#include <odometry/triangulation.hpp>
#include <odometry/two_view_start.hpp>
#include <random>

#include "eval/ate.hpp"
#include "test_images.hpp"

#include "doctest/doctest.h"

namespace mono_test {

using namespace dynfilter;
using namespace dynfilter::odometry;
using odometry_test::frame_at;

namespace {

const Pinhole kCamera(odometry_test::camera(), 40.0);

OdometryOptions mono() {
  OdometryOptions options;
  options.sensor = Sensor::Mono;
  return options;
}

double between(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / 4294967295.0;
}

/// A step along a plane. Of the two motions that a homography allows, only one has its points in front of
/// both cameras (Faugeras and Lustman 1988).
Eigen::Isometry3d beside() {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.linear() = Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitX()).toRotationMatrix();
  T_world_camera.translation() = Eigen::Vector3d(0.5, 0, 0);
  return T_world_camera.inverse();
}

Eigen::Isometry3d second_camera() {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.linear() =
      Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.2, 1, 0.1).normalized()).toRotationMatrix();
  T_world_camera.translation() = Eigen::Vector3d(0.4, 0.05, 0.1);
  return T_world_camera.inverse();
}

/// Features of points, as a camera at T_camera_world sees them. Equal descriptors belong together.
FrameFeatures features_of(const std::vector<Eigen::Vector3d>& points,
                          const Eigen::Isometry3d& T_camera_world) {
  FrameFeatures features;
  std::mt19937 random(3);
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d px = kCamera.project(T_camera_world * point);
    const cv::KeyPoint keypoint(static_cast<float>(px.x()), static_cast<float>(px.y()), 31);
    features.keypoints.push_back(keypoint);
    features.keypoints.back().octave = 0;
    Descriptor descriptor;
    for (auto& word : descriptor)
      word = static_cast<std::uint64_t>(random()) << 32U | static_cast<std::uint64_t>(random());
    features.descriptors.push_back(descriptor);
    features.extracted.push_back(static_cast<std::int32_t>(features.extracted.size()));
  }
  features.keypoints_undistorted = features.keypoints;
  features.depth_m.assign(points.size(), NAN);
  features.map_point.assign(points.size(), -1);
  return features;
}

std::vector<Eigen::Vector3d> cloud(bool plane) {
  std::mt19937 random(5);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 300; ++i) {
    const double x = between(random, -1.5, 1.5), y = between(random, -1.1, 1.1);
    points.emplace_back(x, y, plane ? 3 + 0.3 * y : between(random, 2.2, 6));
  }
  return points;
}

}  // namespace

TEST_CASE("a triangulated point is where it was; one behind a camera or off its pixel is none") {
  const Eigen::Isometry3d T = second_camera();
  const Eigen::Vector3d point(0.3, -0.2, 2.5);
  const ViewOfPoint a{Eigen::Isometry3d::Identity(), kCamera.project(point).head<2>()};
  ViewOfPoint b{T, kCamera.project(T * point).head<2>()};
  CHECK((triangulate(kCamera, a, b) - point).norm() < 1e-9);
  REQUIRE(confirmed_point(kCamera, a, b, 0.9998));
  CHECK_FALSE(confirmed_point(kCamera, a, b, 0.5));  // less parallax than 60 degrees
  b.px.y() += 8;
  CHECK_FALSE(confirmed_point(kCamera, a, b, 0.9998));
  const Eigen::Vector3d behind(0.3, -0.2, -2.5);
  const ViewOfPoint c{Eigen::Isometry3d::Identity(), kCamera.project(behind).head<2>()},
      d{T, kCamera.project(T * behind).head<2>()};
  CHECK_FALSE(confirmed_point(kCamera, c, d, 0.9998));
}

TEST_CASE("two views start a map: rotation, direction and points up to a scale, by the right model") {
  for (const bool plane : {false, true}) {
    CAPTURE(plane);
    const std::vector<Eigen::Vector3d> points = cloud(plane);
    TwoViewStart views(kCamera, StartOptions());
    CHECK_FALSE(views.add(4, features_of(points, Eigen::Isometry3d::Identity()), {640, 480}));
    const Eigen::Isometry3d truth = plane ? beside() : second_camera();
    const auto start = views.add(9, features_of(points, truth), {640, 480});
    REQUIRE(start);
    CHECK(start->planar == plane);
    CHECK(start->reference_id == 4);
    CHECK(Eigen::AngleAxisd(start->T_current_reference.linear().transpose() * truth.linear()).angle() < 1e-3);
    CHECK(start->T_current_reference.translation().normalized().dot(truth.translation().normalized()) >
          0.9999);
    const double scale = truth.translation().norm() / start->T_current_reference.translation().norm();
    CHECK(start->points.size() > 150);
    for (const auto& point : start->points) {
      CHECK(point.reference == point.current);
      const Eigen::Vector3d& expected = points[static_cast<std::size_t>(point.reference)];
      CHECK((scale * point.reference_m - expected).norm() < 0.02 * expected.z());
    }
  }
}

TEST_CASE("no map starts without parallax: the same view, a turn, or too few matches") {
  const std::vector<Eigen::Vector3d> points = cloud(false);
  Eigen::Isometry3d turned = Eigen::Isometry3d::Identity();
  turned.linear() = Eigen::AngleAxisd(0.06, Eigen::Vector3d::UnitY()).toRotationMatrix();
  for (const Eigen::Isometry3d& T : {Eigen::Isometry3d::Identity(), turned}) {
    TwoViewStart views(kCamera, StartOptions());
    CHECK_FALSE(views.add(0, features_of(points, Eigen::Isometry3d::Identity()), {640, 480}));
    CHECK_FALSE(views.add(1, features_of(points, T), {640, 480}));
  }
  const std::vector<Eigen::Vector3d> few(points.begin(), points.begin() + 99);
  TwoViewStart views(kCamera, StartOptions());
  views.add(0, features_of(points, Eigen::Isometry3d::Identity()), {640, 480});
  CHECK_FALSE(views.add(1, features_of(few, second_camera()), {640, 480}));
}

TEST_CASE("a pose from pixels alone: mismatches do not matter") {
  const std::vector<Eigen::Vector3d> points = cloud(false);
  const FrameFeatures features = features_of(points, second_camera());
  std::vector<SearchPoint> known;
  for (std::size_t i = 0; i < points.size(); ++i) {
    // A fifth of the points is elsewhere.
    const Eigen::Vector3d off = i % 5 == 0 ? Eigen::Vector3d(0.5, -0.4, 0.7) : Eigen::Vector3d::Zero();
    known.push_back({points[i] + off, features.descriptors[i], 0, static_cast<std::int64_t>(i)});
  }
  PoseRecovery recovery(kCamera, false);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  CHECK(recovery.recover(known, features, 100, T) >= 230);
  CHECK((T.translation() - second_camera().translation()).norm() < 0.01);
  CHECK(Eigen::AngleAxisd(T.linear().transpose() * second_camera().linear()).angle() < 0.005);
  CHECK(recovery.recover(known, features, 290, T) == 0);
}

TEST_CASE("a mono camera is followed up to a scale, twice the same; without motion there is no map") {
  cv::setNumThreads(1);
  const auto x_at = [](int i) { return 0.25 * std::sin(0.08 * i); };
  const auto y_at = [](int i) { return 0.12 * (1 - std::cos(0.06 * i)); };
  io::Trajectory runs[2], truth;
  for (int i = 0; i < 45; ++i)
    truth.push_back({i / 30.0, Pose::from(Eigen::Matrix3d::Identity(), {x_at(i), y_at(i), 0})});
  for (auto& run : runs) {
    Odometry odometry(odometry_test::camera(), mono(), nullptr);
    for (int i = 0; i < 45; ++i) {
      const TrackResult result = odometry.process(frame_at(x_at(i), y_at(i), i / 30.0));
      CHECK(result.state != TrackState::Lost);
    }
    run = odometry.trajectory();
  }
  REQUIRE(runs[0].size() > 30);
  REQUIRE(runs[0].size() == runs[1].size());
  for (std::size_t i = 0; i < runs[0].size(); ++i)
    CHECK(runs[0][i].T_world_camera.translation_m == runs[1][i].T_world_camera.translation_m);
  eval::AteOptions options;
  options.with_scale = true;
  CHECK(eval::absolute_trajectory_error(truth, runs[0], options).error_m.rmse < 0.005);

  Odometry still(odometry_test::camera(), mono(), nullptr);
  for (int i = 0; i < 5; ++i) CHECK(still.process(frame_at(0, 0, i / 30.0)).state == TrackState::NoMap);
}

}  // namespace mono_test
