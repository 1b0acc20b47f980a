// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/motion/patch_relief.hpp>
#include <limits>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"
#include "geometry/rigid_scene.hpp"

namespace patch_relief_test {

using namespace dynfilter;

namespace {

constexpr double kExact_m = 1e-6;

/// Left of column 50 at `left_m`, the rest at `right_m`.
cv::Mat step(float left_m, float right_m) {
  cv::Mat depth(80, 100, CV_32FC1, cv::Scalar(right_m));
  depth.colRange(0, 50).setTo(left_m);
  return depth;
}

}  // namespace

TEST_CASE("patch_relief: between two walls it is the difference of their inverse depths") {
  const PatchRelief relief(step(2, 4), 1);
  // One of both pixels of a pair is beyond the edge: |1/2 + 1/4 - 2/2| = 1/4, and 1/4 from the other side.
  for (const float x : {42.0F, 45.0F, 47.0F, 49.0F})
    CHECK(relief.per_m({x, 40}, 2, kExact_m) == doctest::Approx(0.25));
  for (const float x : {50.0F, 53.0F, 55.0F, 57.0F})
    CHECK(relief.per_m({x, 40}, 4, kExact_m) == doctest::Approx(0.25));
  CHECK(relief.per_m({41, 40}, 2, kExact_m) == 0);
  CHECK(relief.per_m({58, 40}, 4, kExact_m) == 0);
}

TEST_CASE("patch_relief: depths in any unit, of both types") {
  cv::Mat whole_mm, mm;
  step(2, 4).convertTo(whole_mm, CV_16UC1, 1000);
  step(2, 4).convertTo(mm, CV_32FC1, 1000);
  for (const cv::Mat& depth : {whole_mm, mm}) {
    CHECK(PatchRelief(depth, 0.001).per_m({45, 40}, 2, kExact_m) == doctest::Approx(0.25));
    CHECK(DepthImage(depth, 0.001).at(45, 40) == doctest::Approx(2.0));
    for (const cv::Point& outside : {cv::Point(-1, 5), {5, -1}, {100, 5}, {5, 80}})
      CHECK(DepthImage(depth, 0.001).at(outside.x, outside.y) == 0.0F);
  }
  CHECK(DepthImage(cv::Mat(9, 9, CV_8UC1, cv::Scalar(3)), 1).empty());
}

TEST_CASE("patch_relief: a plane has none, however steep") {
  cv::Mat depth(80, 100, CV_32FC1);
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x)
      depth.at<float>(y, x) = 1 / (0.2F + 0.004F * static_cast<float>(x) - 0.001F * static_cast<float>(y));
  const PatchRelief relief(depth, 1);
  CHECK(depth.at<float>(40, 20) / depth.at<float>(40, 80) > 1.9F);
  for (const float x : {10.0F, 37.0F, 90.0F})
    CHECK(relief.per_m({x, 40}, static_cast<double>(depth.at<float>(40, static_cast<int>(x))), kExact_m) ==
          0);
}

// The sum of three inverse depths has the noise sqrt(6) sigma / Z^2. A hand's breadth at 3 m is more, 2 cm
// are not.
TEST_CASE("patch_relief: depths within the noise are one surface") {
  const double sigma_m = 0.01, limit_per_m = 3 * std::sqrt(6.0) * sigma_m / 9;
  for (const double apart_m : {0.02, 0.10, 0.2, 0.3}) {
    const double there_m = 3 + apart_m, relief_per_m = 1.0 / 3 - 1 / there_m;
    const double found = PatchRelief(step(3, static_cast<float>(there_m)), 1).per_m({47, 40}, 3, sigma_m);
    CHECK(found == doctest::Approx(relief_per_m > limit_per_m ? relief_per_m : 0).epsilon(1e-4));
  }
  CHECK(PatchRelief(step(3, 3.02F), 1).per_m({47, 40}, 3, sigma_m) == 0);
  CHECK(PatchRelief(step(3, 3.3F), 1).per_m({47, 40}, 3, sigma_m) > 0);
}

TEST_CASE("patch_relief: integer depths, holes, borders, and what is no depth image") {
  cv::Mat depth;
  step(2, 4).convertTo(depth, CV_16U, 5000);
  CHECK(PatchRelief(depth, 1 / 5000.0).per_m({47, 40}, 2, kExact_m) == doctest::Approx(0.25));
  const cv::Mat left_only = step(2, 0);
  CHECK(PatchRelief(left_only, 1).per_m({47, 40}, 2, kExact_m) == 0);  // the other surface was not measured
  const PatchRelief relief(step(2, 4), 1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const cv::Point2f& px :
       {cv::Point2f(0, 0), {99, 79}, {-1, 40}, {100, 40}, {1e30F, 40}, {nan, 40}, {47, nan}})
    CHECK(relief.per_m(px, 2, kExact_m) == 0);
  CHECK(relief.per_m({47, 40}, static_cast<double>(nan), kExact_m) == 0);
  CHECK(relief.per_m({47, 40}, 0, kExact_m) == 0);
  CHECK(PatchRelief(cv::Mat(80, 100, CV_8UC1, cv::Scalar(9)), 1).per_m({47, 40}, 2, kExact_m) == 0);
  CHECK(PatchRelief(cv::Mat(), 1).per_m({47, 40}, 2, kExact_m) == 0);
}

TEST_CASE("patch_relief: the shift is that of a point whose depth is the other surface's") {
  const Camera camera = geometry_test::camera();
  const cv::Point2f px(400, 180);
  const Eigen::Vector3d ray((px.x - camera.cx_px) / camera.fx_px, (px.y - camera.cy_px) / camera.fy_px, 1);
  const auto seen = [&](const Pose& T, double depth_m) {
    const Eigen::Vector3d q = depth_m * (T.R() * ray) + T.t();
    return Eigen::Vector2d(camera.fx_px * q.x() / q.z(), camera.fy_px * q.y() / q.z());
  };
  // Small motions: the shift is of first order, and starts at the pixel itself.
  for (const Eigen::Vector3d& t_m : {Eigen::Vector3d(0.002, 0, 0), {0, -0.001, 0.002}, {0, 0, 0.003}}) {
    const Pose T = Pose::from(Eigen::Matrix3d::Identity(), t_m);
    const double truth_px = (seen(T, 2) - seen(T, 4)).norm();
    CHECK(relief_shift_px(camera, T, px, 0.25) == doctest::Approx(truth_px).epsilon(0.01));
  }
  const Pose turn =
      Pose::from(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix(), {0, 0, 0});
  CHECK(relief_shift_px(camera, turn, px, 0.25) == 0);
}

}  // namespace patch_relief_test
