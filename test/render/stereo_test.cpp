// SPDX-License-Identifier: MIT
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "doctest/doctest.h"
#include "io/sequence.hpp"
#include "render/sequence_renderer.hpp"
#include "render/sequence_writer.hpp"

namespace stereo_test {

using namespace dynfilter;
using namespace dynfilter::render;

namespace {

SequenceOptions with_right(const char* scene) {
  SequenceOptions options;
  options.scene = scene;
  options.right_images = true;
  options.image_noise = 0;
  options.frames = 4;
  return options;
}

cv::Mat grey(const cv::Mat& colour) {
  cv::Mat out;
  cv::cvtColor(colour, out, cv::COLOR_BGR2GRAY);
  return out;
}

/// Share of the pixels that the right image has where depth and baseline say.
/// Not those that the left camera sees beside something nearer.
double share_found(const RenderedFrame& frame, const Camera& camera) {
  const cv::Mat left = grey(frame.colour), right = grey(frame.right);
  int seen = 0, found = 0;
  constexpr int kStep = 5, kMargin = 8, kTolerance = 12;
  for (int y = kMargin; y < left.rows - kMargin; y += kStep)
    for (int x = kMargin; x < left.cols - kMargin; x += kStep) {
      const float z = frame.true_depth_m.at<float>(y, x);
      if (!(z > 0)) continue;
      const double u = x - camera.baseline_fx_px_m / static_cast<double>(z);
      if (u < kMargin || u > left.cols - kMargin) continue;
      const int u0 = static_cast<int>(u);
      const double t = u - u0,
                   value = (1 - t) * right.at<std::uint8_t>(y, u0) + t * right.at<std::uint8_t>(y, u0 + 1);
      ++seen;
      found += std::abs(value - left.at<std::uint8_t>(y, x)) < kTolerance;
    }
  return static_cast<double>(found) / seen;
}

}  // namespace

TEST_CASE("the right image shows each point at its disparity; the left one does not change") {
  SequenceRenderer stereo(with_right("static_desk"));
  CHECK(stereo.camera().baseline_m() == doctest::Approx(0.11));
  const RenderedFrame frame = stereo.frame(2);
  REQUIRE(frame.right.size() == frame.colour.size());
  CHECK(share_found(frame, stereo.camera()) > 0.85);
  Camera mirrored = stereo.camera();  // the same test with the right camera on the left
  mirrored.baseline_fx_px_m *= -1;
  CHECK(share_found(frame, mirrored) < 0.7);

  SequenceOptions options = with_right("static_desk");
  options.right_images = false;
  SequenceRenderer alone(options);
  const RenderedFrame same = alone.frame(2);
  CHECK(same.right.empty());
  CHECK(alone.camera().baseline_fx_px_m == 0);
  CHECK(cv::norm(same.colour, frame.colour, cv::NORM_INF) == 0);
  CHECK(cv::norm(same.depth, frame.depth, cv::NORM_INF) == 0);
}

TEST_CASE("a street: KITTI's camera, depth to 100 m, boxes of parked cars, nothing moves") {
  SequenceOptions options = with_right("street");
  options.detector.missed_share = 0;
  SequenceRenderer renderer(options);
  CHECK(renderer.rate_hz() == 10);
  CHECK(renderer.camera().baseline_m() == doctest::Approx(0.54));
  CHECK(renderer.camera().fx_px == 718);
  const RenderedFrame frame = renderer.frame(1);
  CHECK(frame.colour.size() == cv::Size(1241, 376));
  CHECK(share_found(frame, renderer.camera()) > 0.8);
  double farthest = 0;
  cv::minMaxLoc(frame.depth, nullptr, &farthest);
  CHECK(farthest <= 100 * renderer.scene().camera_model.depth_units_per_m);
  CHECK(farthest > 90 * renderer.scene().camera_model.depth_units_per_m);
  CHECK(cv::countNonZero(frame.truth.labels) == 0);
  CHECK(cv::countNonZero(frame.truth.dynamic) == 0);
  REQUIRE(frame.detections);
  int cars = 0;
  for (const Detection& d : *frame.detections) cars += d.class_name == "car";
  CHECK(cars >= 4);
  // 8 to 14 m/s at 10 Hz.
  for (int i = 0; i < 100; i += 7) {
    const double step_m = (renderer.pose(i + 1).t() - renderer.pose(i).t()).norm();
    CHECK(step_m > 0.8);
    CHECK(step_m < 1.4);
  }
}

TEST_CASE("the car ahead keeps its distance, and moves") {
  SequenceRenderer renderer(with_right("street_follow"));
  std::vector<Eigen::Isometry3d> poses;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  for (int i = 0; i < 60; i += 10) {
    item_poses(renderer.scene(), renderer.time_s(i), poses);
    REQUIRE(poses.size() == 2);
    const Eigen::Vector3d seen = renderer.pose(i).isometry().inverse() * poses[1].translation();
    if (i == 0) first = seen;
    CHECK((seen - first).norm() < 0.15);  // the own car heaves and pitches
    CHECK(seen.z() > 8.5);
    CHECK(seen.z() < 11.5);
  }
  const RenderedFrame frame = renderer.frame(3);
  CHECK(cv::countNonZero(frame.truth.dynamic == 255) > 0.5 * cv::countNonZero(frame.truth.labels));
}

TEST_CASE("at the junction the camera stands and traffic fills more than half of the view") {
  SequenceRenderer renderer(with_right("junction"));
  CHECK(renderer.pose(0).translation_m[1] == renderer.pose(50).translation_m[1]);
  double share = 0;
  constexpr int kLooks = 6, kEvery = 11;
  std::vector<Eigen::Isometry3d> poses;
  for (int k = 0; k < kLooks; ++k) {
    const cv::Mat labels = renderer.frame(kEvery * k).truth.labels;
    share += static_cast<double>(cv::countNonZero(labels)) / static_cast<double>(labels.total()) / kLooks;
  }
  CHECK(share > 0.5);
}

TEST_CASE("a right turn of 90 degrees; lanes are straight pieces and arcs") {
  const Route left({1, 2}, 0, {{10}, {4 * M_PI / 2, 1 / 4.0}});
  CHECK((left.at(10) - Eigen::Vector2d(1, 12)).norm() < 1e-12);
  CHECK((left.at(10 + 2 * M_PI) - Eigen::Vector2d(-3, 16)).norm() < 1e-9);
  CHECK(left.heading_rad(10 + 2 * M_PI) == doctest::Approx(M_PI / 2));
  CHECK((left.at(13 + 2 * M_PI) - Eigen::Vector2d(-6, 16)).norm() < 1e-9);
  CHECK((left.at(-1) - Eigen::Vector2d(1, 1)).norm() < 1e-12);

  const SequenceRenderer renderer(with_right("street_turn"));
  const Eigen::Vector3d before = renderer.pose(0).R().col(2), after = renderer.pose(110).R().col(2);
  CHECK(before.y() > 0.99);
  CHECK(after.x() > 0.99);
}

TEST_CASE("a street is written as a stereo sequence, which a reader recognises") {
  std::random_device device;
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("dynfilter-street-" + std::to_string(device()));
  SequenceOptions options = with_right("street");
  options.frames = 2;
  write_sequence(options, folder);
  {
    const io::Sequence sequence = io::Sequence::open(folder);
    CHECK(sequence.sensor() == "stereo");
    CHECK(sequence.has_stereo());
    CHECK(sequence.has_depth());
    CHECK(sequence.timestamp_s(1) - sequence.timestamp_s(0) == doctest::Approx(0.1).epsilon(1e-4));
    CHECK(sequence.load(1).right.size() == cv::Size(1241, 376));
    CHECK(sequence.load(1).depth_unit_m == doctest::Approx(1 / 500.0));
  }
  std::filesystem::remove_all(folder);
}

TEST_CASE("hall: EuRoC's camera flies fast") {
  const SequenceRenderer renderer(with_right("hall_people"));
  CHECK(renderer.rate_hz() == 20);
  CHECK(renderer.camera().width_px == 752);
  CHECK(renderer.exposure_ms() == 8);
  double fastest_mps = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d at = renderer.pose(i).t();
    fastest_mps = std::max(fastest_mps, 20 * (renderer.pose(i + 1).t() - at).norm());
    CHECK(std::abs(at.x()) < 5);
    CHECK(at.z() > 1);
  }
  CHECK(fastest_mps > 1.2);
}

}  // namespace stereo_test
