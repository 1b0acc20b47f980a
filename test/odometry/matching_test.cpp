// SPDX-License-Identifier: MIT
#include <odometry/matching.hpp>
#include <odometry/recovery.hpp>
#include <random>

#include "doctest/doctest.h"
#include "test_images.hpp"

namespace matching_test {

using namespace dynfilter::odometry;

namespace {

const Pinhole kCamera(odometry_test::camera(), 40.0);

Descriptor descriptor(std::mt19937& random) {
  Descriptor d;
  for (auto& word : d) word = (static_cast<std::uint64_t>(random()) << 32) | random();
  return d;
}

struct Scene {
  std::vector<SearchPoint> points;
  FrameFeatures features;
  FeatureGrid grid;
};

/// n points of one octave, observed exactly from T, in another order.
Scene scene(const Eigen::Isometry3d& T_camera_world, int n) {
  Scene s;
  std::mt19937 random(3);
  for (int i = 0; i < n; ++i) {
    const double u = 30 + static_cast<double>(random() % 580), v = 30 + static_cast<double>(random() % 420);
    const double depth = 1 + static_cast<double>(random() % 300) / 100;
    s.points.push_back(
        {T_camera_world.inverse() * kCamera.back_project(u, v, depth), descriptor(random), 0, i});
    cv::KeyPoint keypoint(static_cast<float>(u), static_cast<float>(v), 31.F);
    keypoint.octave = 0;
    s.features.keypoints.insert(s.features.keypoints.begin(), keypoint);
    s.features.descriptors.insert(s.features.descriptors.begin(), s.points.back().descriptor);
    s.features.depth_m.insert(s.features.depth_m.begin(), static_cast<float>(depth));
  }
  s.features.keypoints_undistorted = s.features.keypoints;
  s.features.map_point.assign(n, -1);
  s.grid.build(s.features.keypoints_undistorted, {640, 480});
  return s;
}

Eigen::Isometry3d pose(double x_m) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(0.2, Eigen::Vector3d(0, 1, 1).normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(x_m, -0.2, 0.3);
  return T;
}

ProjectionMatcher matcher() {
  ProjectionMatcher m(kCamera, 1.2, 8);
  m.set_image({640, 480});
  return m;
}

}  // namespace

TEST_CASE("counting bits, known answers") {
  CHECK(count_bits(0) == 0);
  CHECK(count_bits(~0ULL) == 64);
  CHECK(count_bits(0x8000000000000001ULL) == 2);
  CHECK(hamming({1, 2, 4, 8}, {0, 0, 0, 8}) == 3);
}

TEST_CASE("every point is found where it is, and only within the window") {
  Scene s = scene(pose(0.1), 300);
  std::vector<std::int32_t> feature;
  matcher().match(s.points, pose(0.1), s.features, s.grid, {10, 1, 80, 0.9}, feature);
  int right = 0;
  for (int i = 0; i < 300; ++i) right += feature[i] == 299 - i;
  CHECK(right == 300);
  // 39 px off at 4 m.
  matcher().match(s.points, pose(0.4), s.features, s.grid, {5, 1, 80, 0.9}, feature);
  for (int i = 0; i < 300; ++i) CHECK(feature[i] == -1);
}

TEST_CASE("octave, depth, distance and ownership are respected") {
  Scene s = scene(pose(0), 3);
  std::vector<std::int32_t> feature;
  const Window window{10, 1, 80, 0.9};
  s.points[0].octave = 2;
  s.features.depth_m[1] *= 0.3F;                                  // feature of points[1]
  for (auto& word : s.points[2].descriptor) word ^= 0xffffffULL;  // 96 bits differ
  matcher().match(s.points, pose(0), s.features, s.grid, window, feature);
  CHECK(feature == std::vector<std::int32_t>{-1, -1, -1});
  s.features.map_point[1] = 77;
  // An unknown depth does not prevent a match, a map point does.
  s.features.depth_m[1] = std::nanf("");
  matcher().match(s.points, pose(0), s.features, s.grid, window, feature);
  CHECK(feature[1] == -1);
  s.features.map_point[1] = -1;
  matcher().match(s.points, pose(0), s.features, s.grid, window, feature);
  CHECK(feature[1] == 1);
}

TEST_CASE("two points that want one feature: the closer descriptor has it") {
  Scene s = scene(pose(0), 1);
  s.points.push_back(s.points[0]);
  s.points[0].descriptor[2] ^= 7;
  std::vector<std::int32_t> feature;
  matcher().match(s.points, pose(0), s.features, s.grid, {10, 1, 80, 0.9}, feature);
  CHECK(feature == std::vector<std::int32_t>{-1, 0});
}

TEST_CASE("recovery finds a pose without prediction, among wrong matches, and none in unrelated frames") {
  const Eigen::Isometry3d truth = pose(0.5);
  Scene s = scene(truth, 100);
  for (int i = 0; i < 40; ++i) s.points[i].world_m += Eigen::Vector3d(0.5 + 0.01 * i, -0.4, 0.3 + 0.02 * i);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  PoseRecovery recovery(kCamera);
  CHECK(recovery.recover(s.points, s.features, 12, T) >= 60);
  CHECK((T.matrix() - truth.matrix()).norm() < 1e-3);

  std::mt19937 random(9);
  for (auto& point : s.points) point.descriptor = descriptor(random);
  Eigen::Isometry3d untouched = Eigen::Isometry3d::Identity();
  CHECK(recovery.recover(s.points, s.features, 12, untouched) == 0);
  CHECK(untouched.matrix() == Eigen::Matrix4d::Identity());
  CHECK(recovery.recover({}, s.features, 12, untouched) == 0);
}

}  // namespace matching_test
