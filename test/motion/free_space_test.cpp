// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/motion/free_space.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <random>

#include "doctest/doctest.h"

namespace free_space_test {

using namespace dynfilter;

namespace {

constexpr int kWidth_px = 120, kHeight_px = 90;

Camera camera() {
  Camera camera;
  camera.fx_px = camera.fy_px = 100;
  camera.cx_px = 60;
  camera.cy_px = 45;
  return camera;
}
cv::Mat wall(float depth_m) {
  return cv::Mat(kHeight_px, kWidth_px, CV_32FC1, cv::Scalar(depth_m));
}
Pose shifted(double x_m) {
  return Pose::from(Eigen::Matrix3d::Identity(), Eigen::Vector3d(x_m, 0, 0));
}
FreeSpaceView::Model exact() {
  FreeSpaceView::Model model;
  model.sigma_px = 0.1;
  return model;
}
double odds(const cv::Mat& depth, const cv::Point3f& point_m, const Pose& T_view_current = Pose()) {
  return FreeSpaceView(camera(), depth, 1, T_view_current, exact()).odds(point_m);
}

/// The window test, pixel by pixel: every rule looked at for itself.
std::optional<float> nearest_by_rules(const cv::Mat& depth_m, const cv::Point2f& px, int radius_px,
                                      float beyond_m) {
  const cv::Point centre(cvRound(px.x), cvRound(px.y));
  float nearest_m = std::numeric_limits<float>::infinity();
  int known = 0, all = 0;
  for (int y = centre.y - radius_px; y <= centre.y + radius_px; ++y)
    for (int x = centre.x - radius_px; x <= centre.x + radius_px; ++x) {
      if (x < 0 || y < 0 || x >= depth_m.cols || y >= depth_m.rows) return std::nullopt;
      ++all;
      const float z_m = depth_m.at<float>(y, x);
      if (!(z_m > 0) || std::isinf(z_m)) continue;
      ++known;
      nearest_m = std::min(nearest_m, z_m);
    }
  if (2 * known < all || nearest_m <= beyond_m) return std::nullopt;
  return nearest_m;
}

}  // namespace

TEST_CASE("free_space: a window gives what a search by the rules gives, for both types of depth") {
  std::mt19937 random(3);
  const auto uniform = [&](float from, float to) {
    return std::uniform_real_distribution<float>(from, to)(random);
  };
  cv::Mat depth_mm(kHeight_px, kWidth_px, CV_16UC1), depth_m(kHeight_px, kWidth_px, CV_32FC1);
  for (int y = 0; y < kHeight_px; ++y)
    for (int x = 0; x < kWidth_px; ++x) {
      const bool hole = uniform(0, 1) < (x < kWidth_px / 2 ? 0.1F : 0.5F);
      const int mm = hole ? 0 : 1000 + static_cast<int>(uniform(0, 2000));
      depth_mm.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(mm);
      depth_m.at<float>(y, x) = static_cast<float>(mm) * 0.001F;
    }
  int free = 0, none = 0;
  for (int k = 0; k < 4000; ++k) {
    // At whole pixels a window is inside or not; between them the margin is at most half a pixel wider.
    const cv::Point2f px(std::floor(uniform(-3, kWidth_px + 3)), std::floor(uniform(-3, kHeight_px + 3)));
    const int radius_px = static_cast<int>(uniform(0, 4));
    const float beyond_m = uniform(0.9F, 1.6F);
    const std::optional<float> expected = nearest_by_rules(depth_m, px, radius_px, beyond_m);
    CHECK(nearest_depth_m(DepthImage(depth_m, 1), px, radius_px, beyond_m) == expected);
    CHECK(nearest_depth_m(DepthImage(depth_mm, 0.001), px, radius_px, beyond_m) == expected);
    (expected ? free : none) += 1;
  }
  CHECK(free > 500);
  CHECK(none > 500);
}

TEST_CASE("free_space: no image, another type, places that are none: nothing") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK_FALSE(nearest_depth_m(DepthImage(cv::Mat(), 1), {5, 5}, 1, 0));
  CHECK_FALSE(nearest_depth_m(DepthImage(cv::Mat(9, 9, CV_8UC1, cv::Scalar(3)), 1), {5, 5}, 1, 0));
  CHECK_FALSE(nearest_depth_m(DepthImage(wall(2), 1), {nan, 5}, 1, 0));
  CHECK_FALSE(nearest_depth_m(DepthImage(wall(2), 1), {1e30F, 5}, 1, 0));
  CHECK(nearest_depth_m(DepthImage(wall(2), 1), {5, 5}, 1, 0) == 2.0F);
  CHECK(odds(wall(4), {nan, nan, nan}) == 0);
  CHECK(odds(wall(4), {0, 0, -1}) == 0);
  CHECK(odds(cv::Mat(), {0, 0, 2}) == 0);
  // Behind the earlier camera.
  CHECK(odds(wall(4), {0, 0, 2}, Pose::from(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, -3))) == 0);
}

TEST_CASE("free_space: only depth behind the place is evidence, and it has a ceiling") {
  CHECK(odds(wall(2), {0, 0, 2}) == 0);     // the surface was there
  CHECK(odds(wall(1.5F), {0, 0, 2}) == 0);  // hidden by something nearer
  CHECK(odds(wall(3), {0, 0, 2}) > 0);      // seen through
  // Far behind, the density of an error vanishes: log(0.5 / 0.005).
  CHECK(odds(wall(4), {0, 0, 2}) == doctest::Approx(std::log(100.0)).epsilon(0.01));
  // Less so a little behind, and not at all within the noise (7 mm at 2 m).
  CHECK(odds(wall(2.08F), {0, 0, 2}) < odds(wall(2.3F), {0, 0, 2}));
  CHECK(odds(wall(2.02F), {0, 0, 2}) == 0);
}

TEST_CASE("free_space: the place is looked up where the earlier camera saw it") {
  // A point at 2 m that stood 0.2 m to the right in the earlier view: 10 px.
  cv::Mat depth = wall(4);
  depth(cv::Rect(66, 41, 9, 9)).setTo(2.0F);
  CHECK(odds(depth, {0, 0, 2}) > 0);
  CHECK(odds(depth, {0, 0, 2}, shifted(0.2)) == 0);
  // Distorted pixels: the view is looked up in the image as it was taken.
  // 50 px from the centre become 50 (1 - 0.5 0.25) = 43.75.
  Camera bent = camera();
  bent.distortion[0] = -0.5;
  cv::Mat post = wall(4);
  post(cv::Rect(104, 40, 1, 11)).setTo(2.0F);
  CHECK(FreeSpaceView(camera(), post, 1, Pose(), exact()).odds({1, 0, 2}) > 0);
  CHECK(FreeSpaceView(bent, post, 1, Pose(), exact()).odds({1, 0, 2}) == 0);
}

TEST_CASE("free_space: silhouettes within the uncertainty of the place take the evidence away") {
  // The nearer surface ends 6 px left of the place.
  cv::Mat depth = wall(4);
  depth(cv::Rect(0, 0, 55, kHeight_px)).setTo(2.0F);
  FreeSpaceView::Model model = exact();
  CHECK(FreeSpaceView(camera(), depth, 1, Pose(), model).odds({0, 0, 2}) > 0);
  model.sigma_px = 1;  // 3 sigma and 3 px reach it
  CHECK(FreeSpaceView(camera(), depth, 1, Pose(), model).odds({0, 0, 2}) == 0);
  model.sigma_px = 100;  // a place that may be anywhere
  CHECK(FreeSpaceView(camera(), wall(4), 1, Pose(), model).odds({0, 0, 2}) == 0);
  // The depth's own error moves the place when the camera has moved: 0.4 m are 20 px, 10 % of them 2 px.
  model = exact();
  cv::Mat beside = wall(4);
  beside(cv::Rect(0, 0, 73, kHeight_px)).setTo(2.0F);
  CHECK(FreeSpaceView(camera(), beside, 1, shifted(0.4), model).odds({0, 0, 2}) > 0);
  model.depth_noise.base_m = 0.2;
  cv::Mat far = wall(40);
  far(cv::Rect(0, 0, 73, kHeight_px)).setTo(2.0F);
  CHECK(FreeSpaceView(camera(), far, 1, shifted(0.4), model).odds({0, 0, 2}) == 0);
}

// Noise on both depths, and places that are off by the stated noise: over a room with steps in depth.
TEST_CASE("free_space: a static world with noise is never seen through") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const DepthNoise noise;
  cv::Mat truth(kHeight_px, kWidth_px, CV_32FC1);
  for (int y = 0; y < kHeight_px; ++y)
    for (int x = 0; x < kWidth_px; ++x)
      truth.at<float>(y, x) =
          1.5F + static_cast<float>((x / 15 + y / 15) % 3) + 0.004F * static_cast<float>(x);
  const auto noisy = [&](float z_m) { return z_m + static_cast<float>(noise.sigma_m(z_m) * normal(random)); };
  cv::Mat seen = truth.clone();
  for (auto it = seen.begin<float>(); it != seen.end<float>(); ++it) *it = noisy(*it);
  FreeSpaceView::Model model;
  model.sigma_px = 0.5;
  const FreeSpaceView view(camera(), seen, 1, Pose(), model);
  int fired = 0, looked = 0;
  for (int y = 10; y < kHeight_px - 10; ++y)
    for (int x = 10; x < kWidth_px - 10; ++x) {
      const cv::Point2f px(static_cast<float>(x + model.sigma_px * normal(random)),
                           static_cast<float>(y + model.sigma_px * normal(random)));
      ++looked;
      fired += view.odds(back_project(camera(), px, noisy(truth.at<float>(y, x)))) > 0 ? 1 : 0;
    }
  CHECK(looked == 7000);
  CHECK(fired == 0);
}

}  // namespace free_space_test
