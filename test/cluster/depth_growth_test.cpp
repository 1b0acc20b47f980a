// SPDX-License-Identifier: MIT
#include <dynfilter/cluster/depth_growth.hpp>
#include <limits>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"

namespace depth_growth_test {

using namespace dynfilter;

namespace {

/// A box at 2 m before a wall at 3 m.
cv::Mat box_before_wall() {
  cv::Mat depth(120, 160, CV_32FC1, cv::Scalar(3));
  depth(cv::Rect(40, 30, 50, 60)).setTo(2);
  return depth;
}
cv::Mat grown(const cv::Mat& depth, std::vector<cv::Point2f> seeds, const DepthGrowthParams& params = {},
              double unit_m = 1) {
  Camera camera;
  camera.fx_px = camera.fy_px = 100;
  camera.cx_px = 80, camera.cy_px = 60;
  cv::Mat mask;
  DepthGrowth(params).grow(depth, unit_m, camera, seeds, mask);
  return mask;
}
DepthGrowthParams no_limit() {
  DepthGrowthParams params;
  params.max_reach_m = 0;
  return params;
}

}  // namespace

TEST_CASE("growth takes the object and stops at its silhouette") {
  const cv::Mat mask = grown(box_before_wall(), {{60, 50}}, no_limit());
  CHECK(cv::countNonZero(mask) == 50 * 60);
  CHECK(cv::countNonZero(mask(cv::Rect(40, 30, 50, 60))) == 50 * 60);
}

TEST_CASE("depth as TUM stores it grows the same") {
  cv::Mat raw;
  box_before_wall().convertTo(raw, CV_16UC1, 5000);
  CHECK(cv::countNonZero(grown(raw, {{60, 50}}, no_limit(), 1.0 / 5000)) == 50 * 60);
}

TEST_CASE("the reach is a distance in 3-D from the seed") {
  // At 3 m and 100 px of focal length 0.3 m are 10 px.
  DepthGrowthParams params;
  params.max_reach_m = 0.3;
  const cv::Mat wall(120, 160, CV_32FC1, cv::Scalar(3));
  const cv::Mat mask = grown(wall, {{80, 60}}, params);
  int wrong = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const int d2 = (x - 80) * (x - 80) + (y - 60) * (y - 60);
      if (d2 < 99) wrong += mask.at<std::uint8_t>(y, x) != 255;
      if (d2 > 101) wrong += mask.at<std::uint8_t>(y, x) != 0;
    }
  CHECK(wrong == 0);
}

TEST_CASE("a surface is shared with rivals at the line half way, whatever is behind a jump is nobody's") {
  Camera camera;
  camera.fx_px = camera.fy_px = 100, camera.cx_px = 80, camera.cy_px = 60;
  cv::Mat depth = box_before_wall(), mask;
  const std::vector<cv::Point2f> seeds{{50, 60}}, rivals{{80, 60}};
  DepthGrowth(no_limit()).grow(depth, 1, camera, seeds, mask, rivals);
  // Steps count along rows and columns: x = 65 is 15 away from both, and the seed comes first.
  CHECK(cv::countNonZero(mask) == (66 - 40) * 60);
  CHECK(cv::countNonZero(mask(cv::Rect(40, 30, 26, 60)) == 255) == 26 * 60);
  DepthGrowth(no_limit()).grow(depth, 1, camera, {}, mask, rivals);
  CHECK(cv::countNonZero(mask) == 0);
}

TEST_CASE("a slope is followed, holes are not crossed") {
  cv::Mat slope(40, 100, CV_32FC1);
  for (int x = 0; x < 100; ++x) slope.col(x).setTo(2 + 0.01 * x);
  slope.col(50).setTo(0);
  const cv::Mat mask = grown(slope, {{10, 10}}, no_limit());
  CHECK(cv::countNonZero(mask) == 50 * 40);
  slope.col(50).setTo(std::numeric_limits<float>::quiet_NaN());
  CHECK(cv::countNonZero(grown(slope, {{10, 10}}, no_limit())) == 50 * 40);
}

TEST_CASE("seeds outside, without depth or odd grow nothing; so does another type of image") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  cv::Mat depth = box_before_wall();
  depth.at<float>(0, 0) = 0;
  CHECK(cv::countNonZero(grown(depth, {{0, 0}, {-5, 3}, {160, 3}, {3, 120}, {nan, 3}, {1e9F, 1e9F}})) == 0);
  CHECK(cv::countNonZero(grown(depth, {})) == 0);
  CHECK(cv::countNonZero(grown(cv::Mat(10, 10, CV_8UC1, cv::Scalar(1)), {{3, 3}})) == 0);
  CHECK(grown(cv::Mat(), {{3, 3}}).empty());
}

}  // namespace depth_growth_test
