// SPDX-License-Identifier: MIT
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "doctest/doctest.h"

namespace undistort_test {

using namespace dynfilter;

namespace {

Camera fr1() {
  Camera c;
  c.fx_px = 517.3, c.fy_px = 516.5, c.cx_px = 318.6, c.cy_px = 255.3;
  c.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};
  return c;
}

std::vector<cv::Point2f> grid() {
  std::vector<cv::Point2f> points;
  for (int y = 0; y <= 480; y += 20) {
    for (int x = 0; x <= 640; x += 20) points.emplace_back(static_cast<float>(x), static_cast<float>(y));
  }
  return points;
}

}  // namespace

TEST_CASE("undistort: agrees with OpenCV at convergence, over the whole image") {
  const Camera c = fr1();
  const std::vector<cv::Point2f> points = grid();
  std::vector<cv::Point2f> mine(points.size()), twin;
  undistort_points(c, points, mine);
  const cv::Matx33d K(c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1);
  cv::undistortPoints(points, twin, K, c.distortion, cv::noArray(), K,
                      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 1000, 1e-12));
  for (std::size_t i = 0; i < points.size(); ++i) CHECK(cv::norm(mine[i] - twin[i]) < 2e-4);
}

TEST_CASE("undistort: distort is its inverse") {
  const Camera c = fr1();
  const std::vector<cv::Point2f> points = grid();
  for (const cv::Point2f p : points) CHECK(cv::norm(p - distort_point(c, undistort_point(c, p))) < 2e-4);
}

TEST_CASE("undistort: no distortion is a copy, NaN stays NaN, no inverse is NaN") {
  Camera c = fr1();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(std::isnan(undistort_point(c, {nan, 5}).x));
  Camera barrel = fr1();
  barrel.distortion = {-0.3, 0, 0, 0, 0};  // the radius never exceeds 0.703 f
  CHECK(
      std::isnan(undistort_point(barrel, {static_cast<float>(barrel.cx_px + 0.8 * barrel.fx_px), 255.3F}).x));
  c.distortion = {};
  CHECK(undistort_point(c, {640, 480}) == cv::Point2f(640, 480));
}

TEST_CASE("back-projection: known point, no depth, inverse of projection") {
  const Camera c = fr1();
  const cv::Point3f p =
      back_project(c, {static_cast<float>(c.cx_px + c.fx_px / 2), static_cast<float>(c.cy_px)}, 3);
  CHECK(p.x == doctest::Approx(1.5));
  CHECK(p.y == doctest::Approx(0));
  CHECK(p.z == 3.0F);
  for (float none :
       {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    CHECK(std::isnan(back_project(c, {100, 100}, none).z));
  }
  CHECK(std::isnan(project(c, {1, 1, -1}).x));
  const cv::Point2f pixel(123, 77);
  CHECK(cv::norm(project(c, back_project(c, pixel, 2.5F)) - pixel) < 1e-3);
}

TEST_CASE("depth noise: the Kinect figures of Nguyen et al.") {
  const DepthNoise noise;
  CHECK(noise.sigma_m(0.4) == doctest::Approx(0.0012));
  CHECK(noise.sigma_m(3.4) == doctest::Approx(0.0012 + 0.0019 * 9));
}

}  // namespace undistort_test
