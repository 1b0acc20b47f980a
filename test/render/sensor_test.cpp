// SPDX-License-Identifier: MIT
#include <cmath>

#include "doctest/doctest.h"
#include "render/calibration_error.hpp"
#include "render/colour_sensor.hpp"
#include "render/sequence_renderer.hpp"
#include "render/shutter.hpp"
#include "support/effort.hpp"

namespace sensor_test {

using namespace dynfilter;
using namespace dynfilter::render;

using dynfilter_test::kSlowBuild;

TEST_CASE("every row gets all of its light, and around its own time") {
  constexpr int kRows = 480;
  struct Case {
    double exposure_s, readout_s;
    int steps;
  };
  for (const Case& c : {Case{0, 0, 1},
                        {0.012, 0, 1},
                        {0.012, 0, 8},
                        {0, 0.02, 1},
                        {0, 0.02, 67},
                        {0, 0.02, 128},
                        {0.012, 0.02, 13},
                        {0.001, 0.02, 21},
                        {0.015, 0.018, 24}}) {
    CAPTURE(c.exposure_s);
    CAPTURE(c.readout_s);
    CAPTURE(c.steps);
    const Shutter shutter(c.exposure_s, c.readout_s, c.steps, kRows);
    const double step_s = (c.exposure_s + c.readout_s) / c.steps;
    double worst_sum = 0, worst_time_s = 0;
    int outside = 0;
    for (int row = 0; row < kRows; ++row) {
      double sum = 0, time_s = 0;
      for (int step = 0; step < c.steps; ++step) {
        const double weight = shutter.weight(step, row);
        sum += weight;
        time_s += weight * shutter.offset_s(step);
        const RowRange rows = shutter.rows(step);
        outside += weight > 0 && (row < rows.first || row > rows.last) ? 1 : 0;
      }
      worst_sum = std::max(worst_sum, std::abs(sum - 1));
      worst_time_s =
          std::max(worst_time_s, std::abs(time_s - (static_cast<double>(row) / kRows - 0.5) * c.readout_s));
    }
    CHECK(worst_sum < 1e-9);
    CHECK(worst_time_s <= 0.5001 * step_s);
    // Windows of several steps: losses at one end equal gains at the other.
    if (c.exposure_s > step_s) CHECK(worst_time_s <= step_s * step_s / (8 * c.exposure_s) + 1e-9);
    CHECK(outside == 0);
  }
}

TEST_CASE("as many sub-frames as the motion needs") {
  CHECK(Shutter::steps_for(0, 0, 0) == 1);
  CHECK(Shutter::steps_for(0.012, 0, 0) == 1);
  CHECK(Shutter::steps_for(0.012, 0, 1.4) == 1);
  CHECK(Shutter::steps_for(0.012, 0, 15) == 10);
  CHECK(Shutter::steps_for(0.012, 0, 300) == 24);
  CHECK(30.0 / Shutter::steps_for(0, 0.02, 30) <= 0.3);       // the edge between two bands
  CHECK(45.0 / Shutter::steps_for(0.012, 0.02, 45) <= 1.5);   // cross-faded, not an edge
  CHECK(12.0 / Shutter::steps_for(0.0001, 0.02, 12) <= 0.3);  // hardly any blur to hide an edge
}

TEST_CASE("light adds up, not grey levels") {
  LightSum sum;
  cv::Mat colour(1, 1, CV_8UC3, cv::Scalar(0, 100, 200)), out;
  sum.begin({1, 1});
  sum.add_row(colour, 0, 1);
  sum.write(out);
  CHECK(out.at<cv::Vec3b>(0, 0) == cv::Vec3b(0, 100, 200));
  sum.begin({1, 1});
  sum.add_row(colour, 0, 0.5);
  colour.setTo(0);
  sum.add_row(colour, 0, 0.5);
  sum.write(out);
  CHECK(out.at<cv::Vec3b>(0, 0) == cv::Vec3b(0, 71, 141));  // 1 / sqrt(2)
}

TEST_CASE("a calibration is off by what was asked for, in directions that the seed draws") {
  const Camera camera = freiburg3_camera();
  CHECK(with_calibration_error(camera, 0, 3) == camera);
  CHECK(with_calibration_error(camera, 1, 3) == with_calibration_error(camera, 1, 3));
  int longer = 0, right = 0, barrel = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    for (const double size : {1.0, 2.0}) {
      const Camera wrong = with_calibration_error(camera, size, seed);
      CHECK(std::abs(wrong.fx_px / camera.fx_px - 1) == doctest::Approx(0.005 * size));
      CHECK(wrong.fy_px / camera.fy_px == doctest::Approx(wrong.fx_px / camera.fx_px));
      CHECK(std::hypot(wrong.cx_px - camera.cx_px, wrong.cy_px - camera.cy_px) == doctest::Approx(3 * size));
      for (const auto& [x, y] : {std::pair{0, 0}, {639, 0}, {0, 479}, {639, 479}}) {
        const double nx = (x - camera.cx_px) / camera.fx_px, ny = (y - camera.cy_px) / camera.fy_px;
        const double k = wrong.distortion[0] * (nx * nx + ny * ny);
        CHECK(std::hypot(k * nx * camera.fx_px, k * ny * camera.fy_px) ==
              doctest::Approx(size).epsilon(0.15));
      }
      longer += wrong.fx_px > camera.fx_px ? 1 : 0;
      right += wrong.cx_px > camera.cx_px ? 1 : 0;
      barrel += wrong.distortion[0] < 0 ? 1 : 0;
    }
  }
  for (const int count : {longer, right, barrel}) {
    CHECK(count > 20);
    CHECK(count < 60);
  }
}

TEST_CASE("stepwise exposure jumps about once a second by a factor of 1.25 to 1.5") {
  ColourSensor::Options options;
  options.exposure_steps = true;
  for (const std::uint64_t seed : {1, 2}) {
    const ColourSensor sensor(options, seed);
    int jumps = 0;
    double last = sensor.gain(0);
    for (int ms = 1; ms < 60000; ++ms) {
      const double now = sensor.gain(ms / 1e3), factor = std::max(now, last) / std::min(now, last);
      if (now != last) {
        ++jumps;
        CHECK(factor >= 1.25);
        CHECK(factor <= 1.5);
      }
      last = now;
    }
    CHECK(jumps >= 55);
    CHECK(jumps <= 65);
  }
  options.exposure_steps = false;
  CHECK(ColourSensor(options, 1).gain(17.3) == 1);
}

namespace {

double angle_rad(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

}  // namespace

TEST_CASE("a turning camera reaches the rate that its scene is named after, and hardly moves otherwise") {
  for (const std::string kind : {"turn_", "near_turn_", "walking_turn_"}) {
    for (const int rate_deg_s : {30, 60, 100, 150}) {
      if (kind == "near_turn_" && rate_deg_s != 60 && rate_deg_s != 100) continue;
      for (const std::uint64_t seed : {1, 12}) {
        if (kSlowBuild && (rate_deg_s != 100 || seed != 12)) continue;
        CAPTURE(kind);
        CAPTURE(rate_deg_s);
        CAPTURE(seed);
        const Scene scene = make_scene(kind + std::to_string(rate_deg_s), seed);
        constexpr double kStep_s = 1 / 200.0;
        double peak = 0, mean = 0, fastest_mps = 0;
        for (int i = 0; i < 600; ++i) {  // the 90 frames of a short sequence
          const Eigen::Isometry3d a = scene.camera->pose(i * kStep_s),
                                  b = scene.camera->pose((i + 1) * kStep_s);
          const double rate = angle_rad(a, b) / kStep_s * 180 / M_PI;
          peak = std::max(peak, rate);
          mean += rate / 600;
          fastest_mps = std::max(fastest_mps, (a.translation() - b.translation()).norm() / kStep_s);
        }
        CHECK(peak == doctest::Approx(rate_deg_s).epsilon(0.01));
        CHECK(mean > 0.4 * rate_deg_s);
        CHECK(fastest_mps < 0.25);
        CHECK(scene.exposure_ms == 12);
        CHECK(scene.movers.empty() == (kind != "walking_turn_"));
      }
    }
  }
}

TEST_CASE("a shaken camera jitters quickly by tens of pixels a frame, one on a tripod not at all") {
  const Scene shaken = make_scene("shake", 4);
  CHECK(shaken.movers.empty());
  double largest_px = 0;
  int turns = 0, last_sign = 0;
  constexpr double kSeconds = 20;
  for (int i = 0; i < 30 * kSeconds; ++i) {
    const Eigen::Isometry3d a = shaken.camera->pose(i / 30.0), b = shaken.camera->pose((i + 1) / 30.0);
    largest_px = std::max(largest_px, angle_rad(a, b) * freiburg3_camera().fx_px);
  }
  for (int i = 0; i < 200 * kSeconds; ++i) {
    const Eigen::Isometry3d a = shaken.camera->pose(i / 200.0), b = shaken.camera->pose((i + 1) / 200.0);
    const int sign = (a.linear().transpose() * b.linear())(0, 2) > 0 ? 1 : -1;  // of the yaw's rate
    turns += sign != last_sign ? 1 : 0;
    last_sign = sign;
  }
  CHECK(largest_px > 25);
  CHECK(largest_px < 70);
  CHECK(turns / kSeconds > 10);  // two a period: 5 to 8 Hz
  CHECK(turns / kSeconds < 16);
  const Scene standing = make_scene("standing_camera", 4);
  CHECK(standing.camera->pose(0).isApprox(standing.camera->pose(7.77), 0));
}

}  // namespace sensor_test
