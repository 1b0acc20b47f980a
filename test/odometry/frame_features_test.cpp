// SPDX-License-Identifier: MIT
#include <cmath>
#include <odometry/feature_grid.hpp>
#include <odometry/frame_features.hpp>
#include <random>
#include <set>

#include "doctest/doctest.h"
#include "test_images.hpp"

namespace frame_features_test {

using namespace dynfilter::odometry;

namespace {
float depth_of(const cv::Mat& depth, double unit_m, float x, float y) {
  std::vector<float> depth_m;
  sample_depth(depth, unit_m, DepthOptions{}, {cv::KeyPoint(x, y, 31.F)}, depth_m);
  return depth_m[0];
}
}  // namespace

TEST_CASE("depth is metres, and none at silhouettes, holes, borders and outside") {
  cv::Mat depth(100, 100, CV_16UC1, cv::Scalar(10000));  // 2 m
  depth(cv::Rect(50, 0, 50, 100)).setTo(cv::Scalar(15000));
  depth.at<std::uint16_t>(20, 20) = 0;
  const double unit = 1.0 / 5000;
  CHECK(depth_of(depth, unit, 30, 50) == doctest::Approx(2.0));
  CHECK(depth_of(depth, unit, 80, 50) == doctest::Approx(3.0));
  for (const float x : {48.F, 49.F, 50.F, 51.F}) CHECK(std::isnan(depth_of(depth, unit, x, 50)));
  CHECK(depth_of(depth, unit, 47, 50) == doctest::Approx(2.0));
  CHECK(std::isnan(depth_of(depth, unit, 20, 20)));
  CHECK(depth_of(depth, unit, 21, 20) == doctest::Approx(2.0));
  for (const float x : {-5.F, 0.F, 99.F, 100.F, 1e6F}) CHECK(std::isnan(depth_of(depth, unit, x, 50)));
  CHECK(std::isnan(depth_of(cv::Mat(), unit, 30, 50)));
}

TEST_CASE("depth images in metres work as well, NaN means none") {
  cv::Mat depth(50, 50, CV_32FC1, cv::Scalar(1.5));
  depth.at<float>(10, 10) = std::nanf("");
  CHECK(depth_of(depth, 1, 25, 25) == doctest::Approx(1.5));
  CHECK(std::isnan(depth_of(depth, 1, 10, 10)));
  CHECK(depth_of(depth, 1, 11, 10) == doctest::Approx(1.5));
  depth.setTo(cv::Scalar(50));  // beyond the range of any such camera
  CHECK(std::isnan(depth_of(depth, 1, 25, 25)));
}

TEST_CASE("undistortion inverts the camera's distortion") {
  dynfilter::Camera fr1;
  fr1.fx_px = 517.3;
  fr1.fy_px = 516.5;
  fr1.cx_px = 318.6;
  fr1.cy_px = 255.3;
  fr1.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};
  std::vector<cv::KeyPoint> distorted, undistorted;
  std::vector<cv::Point2f> ideal;
  for (int y = 40; y <= 440; y += 80)
    for (int x = 40; x <= 600; x += 80) {
      const double a = (x - fr1.cx_px) / fr1.fx_px, b = (y - fr1.cy_px) / fr1.fy_px, r2 = a * a + b * b;
      const auto& k = fr1.distortion;
      const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
      const double u = a * radial + 2 * k[2] * a * b + k[3] * (r2 + 2 * a * a);
      const double v = b * radial + k[2] * (r2 + 2 * b * b) + 2 * k[3] * a * b;
      ideal.emplace_back(static_cast<float>(x), static_cast<float>(y));
      distorted.emplace_back(static_cast<float>(fr1.fx_px * u + fr1.cx_px),
                             static_cast<float>(fr1.fy_px * v + fr1.cy_px), 31.F);
    }
  undistort(fr1, distorted, undistorted);
  double worst = 0;
  for (std::size_t i = 0; i < ideal.size(); ++i)
    worst = std::max(worst, cv::norm(undistorted[i].pt - ideal[i]));
  CHECK(worst < 0.02);
}

TEST_CASE("compaction keeps the arrays together") {
  FrameFeatures f;
  for (int i = 0; i < 5; ++i) {
    f.keypoints.emplace_back(static_cast<float>(i), 0.F, 1.F);
    f.descriptors.push_back({static_cast<std::uint64_t>(i), 0, 0, 0});
    f.depth_m.push_back(static_cast<float>(i));
    f.map_point.push_back(i);
    f.extracted.push_back(i);
  }
  f.keypoints_undistorted = f.keypoints;
  const std::vector<std::uint8_t> rejected{0, 1, 0, 0, 1};
  f.compact(rejected);
  REQUIRE(f.size() == 3);
  const int kept[] = {0, 2, 3};
  for (int i = 0; i < 3; ++i) {
    CHECK(f.keypoints[i].pt.x == static_cast<float>(kept[i]));
    CHECK(f.keypoints_undistorted[i].pt.x == static_cast<float>(kept[i]));
    CHECK(f.descriptors[i][0] == static_cast<std::uint64_t>(kept[i]));
    CHECK(f.depth_m[i] == static_cast<float>(kept[i]));
    CHECK(f.map_point[i] == kept[i]);
    CHECK(f.extracted[i] == kept[i]);
  }
}

TEST_CASE("a window of the grid holds all that a brute search finds, once") {
  std::mt19937 random(1);
  std::vector<cv::KeyPoint> keypoints;
  for (int i = 0; i < 500; ++i)  // some of them outside the image, as undistortion makes them
    keypoints.emplace_back(static_cast<float>(random() % 740) - 50.F,
                           static_cast<float>(random() % 580) - 50.F, 31.F);
  FeatureGrid grid;
  grid.build(keypoints, {640, 480});
  for (int trial = 0; trial < 200; ++trial) {
    const double x = static_cast<double>(random() % 800) - 80, y = static_cast<double>(random() % 600) - 60;
    const double radius = 1 + static_cast<double>(random() % 60);
    std::multiset<int> seen;
    grid.visit(x, y, radius, [&](std::int32_t i) { seen.insert(i); });
    for (int i = 0; i < 500; ++i) {
      const bool inside =
          std::abs(keypoints[i].pt.x - x) <= radius && std::abs(keypoints[i].pt.y - y) <= radius;
      if (inside)
        CHECK(seen.count(i) == 1);
      else
        CHECK(seen.count(i) <= 1);
    }
  }
}

}  // namespace frame_features_test
