// SPDX-License-Identifier: MIT
#include <cmath>
#include <set>

#include "doctest/doctest.h"
#include "render/depth_sensor.hpp"
#include "render/sequence_renderer.hpp"

namespace depth_sensor_test {

using namespace dynfilter;
using namespace dynfilter::render;

namespace {

/// A wall that is looked at squarely, with nothing shiny about it.
GeometryImage wall(double depth_m) {
  GeometryImage scene;
  scene.create({640, 480});
  scene.depth_m.setTo(depth_m);
  scene.material.setTo(0);
  scene.facing.setTo(1);
  return scene;
}

MaterialSet matt() {
  MaterialSet set;
  set.add(cv::Mat(cv::Mat(4, 4, CV_8UC3, cv::Scalar::all(128))));
  return set;
}

cv::Mat measure(const GeometryImage& scene, const DepthSensor::Options& options = {}) {
  DepthSensor sensor(freiburg3_camera(), options, 5);
  Random random(7);
  cv::Mat out;
  sensor.measure(scene, matt(), random, out);
  return out;
}

}  // namespace

TEST_CASE("noise grows with distance as published") {
  for (const double z : {1.0, 2.0, 3.0, 4.5}) {
    CAPTURE(z);
    const cv::Mat depth = measure(wall(z));
    CHECK(cv::countNonZero(depth) == 640 * 480);
    cv::Scalar mean, deviation;
    cv::meanStdDev(depth, mean, deviation);
    CHECK(mean[0] / 5000 == doctest::Approx(z).epsilon(0.003));
    const double sigma_m = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
    CHECK(deviation[0] / 5000 == doctest::Approx(sigma_m).epsilon(0.3));
  }
}

TEST_CASE("depth comes in steps of disparity") {
  const cv::Mat depth = measure(wall(3.0));
  std::set<int> values;
  for (int y = 0; y < 480; ++y) values.insert(depth.ptr<std::uint16_t>(y), depth.ptr<std::uint16_t>(y) + 640);
  CHECK(values.size() < 20);
  const double fb = 535.4 * 0.075;
  for (const int value : values) {
    const double eighths = 8 * fb / (value / 5000.0);
    CHECK(std::abs(eighths - std::round(eighths)) < 0.02);
  }
}

TEST_CASE("there is nothing too near, too far, or grazed") {
  CHECK(cv::countNonZero(measure(wall(0.3))) == 0);
  CHECK(cv::countNonZero(measure(wall(11))) == 0);
  GeometryImage grazed = wall(2);
  grazed.facing.setTo(0.04);
  CHECK(cv::countNonZero(measure(grazed)) == 0);
}

TEST_CASE("a thing before a wall throws the projector's shadow to one side and frays at its outline") {
  GeometryImage scene = wall(4);
  scene.depth_m(cv::Rect(250, 100, 120, 300)).setTo(1.5);
  const cv::Mat depth = measure(scene);
  // The shadow is as wide as the disparities differ: 535.4 * 0.075 * (1 / 1.5 - 1 / 4) = 16.7 px.
  const auto holes = [&](const cv::Rect& area) {
    return 1.0 - cv::countNonZero(depth(area)) / static_cast<double>(area.area());
  };
  CHECK(holes({374, 120, 9, 260}) > 0.9);
  CHECK(holes({392, 120, 100, 260}) < 0.01);
  CHECK(holes({100, 120, 140, 260}) < 0.01);
  int frayed = 0;
  for (int y = 120; y < 380; ++y)
    frayed +=
        (depth.at<std::uint16_t>(y, 249) < 2 * 5000) != (depth.at<std::uint16_t>(y, 247) < 2 * 5000) ? 1 : 0;
  CHECK(frayed > 20);
}

TEST_CASE("dark surfaces lose some of their depth, a perfect sensor none") {
  MaterialSet dark;
  dark.add(cv::Mat(cv::Mat(4, 4, CV_8UC3, cv::Scalar::all(20))), 0.4F);
  Random random(7);
  cv::Mat depth;
  DepthSensor(freiburg3_camera(), {}, 5).measure(wall(2), dark, random, depth);
  CHECK(cv::countNonZero(depth) / (640.0 * 480) == doctest::Approx(0.6).epsilon(0.08));
  DepthSensor::Options options;
  options.perfect = true;
  DepthSensor(freiburg3_camera(), options, 5).measure(wall(2), dark, random, depth);
  CHECK(cv::countNonZero(depth == 10000) == 640 * 480);
}

}  // namespace depth_sensor_test
