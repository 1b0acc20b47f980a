// SPDX-License-Identifier: MIT
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"
#include "render/rasteriser.hpp"
#include "render/sequence_renderer.hpp"

namespace rasteriser_test {

using namespace dynfilter;
using namespace dynfilter::render;

namespace {

/// Renders models given in the camera frame.
GeometryImage draw(const std::vector<Model>& models, const cv::Scalar& colour = {40, 90, 200}) {
  Rasteriser rasteriser(freiburg3_camera());
  MaterialSet set;
  set.add(cv::Mat(cv::Mat(8, 8, CV_8UC3, colour)));
  rasteriser.begin();
  for (std::size_t i = 0; i < models.size(); ++i) {
    rasteriser.draw(models[i], Eigen::Isometry3f::Identity(), static_cast<int>(i) + 1);
  }
  GeometryImage out;
  rasteriser.resolve(set, out);
  return out;
}

Model box(const Eigen::Vector3f& centre, const Eigen::Vector3f& size, float turn_rad = 0, float cell_m = 10) {
  Model model;
  Eigen::Isometry3f frame = Eigen::Isometry3f::Identity();
  frame.linear() =
      Eigen::AngleAxisf(turn_rad, Eigen::Vector3f(0.3F, 1, 0.2F).normalized()).toRotationMatrix();
  frame.translation() = centre;
  add_box(model, frame, size, BoxSkin::all({0}), cell_m);
  model.finish();
  return model;
}

/// Distance along the optical axis to a turned box by slabs, 0 where the ray misses it.
double box_depth(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, double turn_rad, int x, int y) {
  const Camera c = freiburg3_camera();
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(turn_rad, Eigen::Vector3d(0.3, 1, 0.2).normalized()).toRotationMatrix();
  const Eigen::Vector3d d =
      R.transpose() * Eigen::Vector3d((x - c.cx_px) / c.fx_px, (y - c.cy_px) / c.fy_px, 1);
  const Eigen::Vector3d o = -(R.transpose() * centre);
  double near = 0, far = 1e9;
  for (int a = 0; a < 3; ++a) {
    const double s0 = (-size[a] / 2 - o[a]) / d[a], s1 = (size[a] / 2 - o[a]) / d[a];
    near = std::max(near, std::min(s0, s1));
    far = std::min(far, std::max(s0, s1));
  }
  return near < far ? near : 0;
}

}  // namespace

TEST_CASE("a wall across the view has its distance in every pixel") {
  const GeometryImage image = draw({box({0, 0, 3.5F}, {9, 9, 1}, 0, 0.3F)});
  double low, high;
  cv::minMaxLoc(image.depth_m, &low, &high);
  CHECK(low == doctest::Approx(3.0).epsilon(1e-5));
  CHECK(high == doctest::Approx(3.0).epsilon(1e-5));
  CHECK(cv::countNonZero(image.item == 1) == 640 * 480);
  CHECK(image.colour.at<cv::Vec3b>(240, 320) == cv::Vec3b(40, 90, 200));
  CHECK(image.facing.at<float>(248, 320) == doctest::Approx(1.0).epsilon(1e-4));
  // At the picture's left edge the ray leans by atan(cx / fx).
  CHECK(image.facing.at<float>(248, 0) == doctest::Approx(std::cos(std::atan(320.1 / 535.4))).epsilon(1e-3));
}

TEST_CASE("the depth of a turned box is that of the ray, pixel by pixel") {
  for (const double turn : {0.4, 1.1, 2.3}) {
    CAPTURE(turn);
    const GeometryImage image =
        draw({box({0.2F, -0.1F, 2.2F}, {0.9F, 0.7F, 0.8F}, static_cast<float>(turn), 0.11F)});
    int agree = 0, inside = 0, wrong_cover = 0;
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        const double expected = box_depth({0.2, -0.1, 2.2}, {0.9, 0.7, 0.8}, turn, x, y);
        const double got = image.depth_m.at<float>(y, x);
        wrong_cover += (expected > 0) != (got > 0) ? 1 : 0;
        if (expected <= 0 || got <= 0) continue;
        ++inside;
        agree += std::abs(expected - got) < 1e-3 ? 1 : 0;
      }
    }
    CHECK(inside > 20000);
    // At the box's edges the pixel may belong to the other face.
    CHECK(agree > inside - inside / 200);
    CHECK(wrong_cover < 700);  // half covered pixels of the outline
  }
}

TEST_CASE("the nearer surface wins whatever the order of drawing") {
  const Model near = box({0, 0, 2.5F}, {1, 1, 1}), far = box({0, 0, 4.5F}, {8, 8, 1});
  const GeometryImage a = draw({near, far}), b = draw({far, near});
  CHECK(a.item.at<std::uint16_t>(240, 320) == 1);
  CHECK(b.item.at<std::uint16_t>(240, 320) == 2);
  CHECK(cv::norm(a.depth_m, b.depth_m, cv::NORM_INF) == 0);
  CHECK(a.depth_m.at<float>(240, 320) == doctest::Approx(2.0));
  CHECK(a.depth_m.at<float>(10, 10) == doctest::Approx(4.0));
}

TEST_CASE("a surface that passes the camera is cut, not dropped or mirrored") {
  // A floor one metre below the camera, from behind it to the horizon.
  const GeometryImage image = draw({box({0, 1.5F, 0}, {60, 1, 60})});
  const Camera c = freiburg3_camera();
  for (const int y : {270, 300, 400, 479}) {
    const double expected = 1.0 / ((y - c.cy_px) / c.fy_px);
    CHECK(image.depth_m.at<float>(y, 320) == doctest::Approx(expected).epsilon(1e-3));
  }
  CHECK(image.depth_m.at<float>(200, 320) == 0.0F);
}

TEST_CASE("a closed mesh has no cracks") {
  Model ball;
  add_loft(ball, Eigen::Isometry3f(Eigen::Translation3f(0.03F, 0.02F, 2)),
           ellipsoid_rings({0, 0, 0}, {0.6F, 0.6F, 0.6F}, 24), {0, 1, 1, 48});
  ball.finish();
  const GeometryImage image = draw({ball});
  cv::Mat inside = image.item == 1, filled = inside.clone();
  cv::floodFill(filled, {0, 0}, 255);  // what stays black is enclosed by the ball but not covered
  CHECK(cv::countNonZero(filled) == 640 * 480);
  CHECK(cv::countNonZero(inside) > 70000);
}

TEST_CASE("silhouettes are mixed from both sides") {
  const GeometryImage image = draw({box({0, 0, 2}, {0.8F, 0.8F, 0.2F}, 0.3F)}, {0, 0, 200});
  int mixed = 0;
  for (int x = 0; x < 640; ++x) {
    const int red = image.colour.at<cv::Vec3b>(240, x)[2];
    CHECK(red <= 200);
    mixed += red > 0 && red < 200 ? 1 : 0;
  }
  for (int y = 0; y < 480; ++y) {
    const int red = image.colour.at<cv::Vec3b>(y, 320)[2];
    mixed += red > 0 && red < 200 ? 1 : 0;
  }
  CHECK(mixed >= 1);
  CHECK(mixed <= 8);
}

}  // namespace rasteriser_test
