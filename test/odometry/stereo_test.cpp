// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/core/frame_inputs.hpp>
#include <filesystem>
#include <odometry/odometry.hpp>
#include <odometry/orb_extractor.hpp>
#include <odometry/stereo_matcher.hpp>

#include "eval/ate.hpp"
#include "test_images.hpp"

#include "doctest/doctest.h"

namespace stereo_test {

using namespace dynfilter;
using namespace dynfilter::odometry;
using odometry_test::frame_at;

namespace {

constexpr double kBaseline_m = 0.1;

Camera stereo_camera() {
  Camera camera = odometry_test::camera();
  camera.baseline_fx_px_m = camera.fx_px * kBaseline_m;
  return camera;
}

io::SequenceFrame stereo_frame(double x_m, double y_m, double timestamp_s) {
  io::SequenceFrame frame = frame_at(x_m, y_m, timestamp_s);
  frame.right = frame_at(x_m + kBaseline_m, y_m, timestamp_s).grey;
  return frame;
}

OdometryOptions stereo() {
  OdometryOptions options;
  options.sensor = Sensor::Stereo;
  return options;
}

}  // namespace

TEST_CASE("matches in the right image have the disparity of the depth, to a fraction of a pixel") {
  const io::SequenceFrame frame = stereo_frame(0.03, 0.01, 0);
  const Camera camera = stereo_camera();
  const OdometryOptions options = stereo();
  OrbExtractor extractor(options.extractor);
  FrameFeatures features;
  extractor.extract(frame.grey, features.keypoints, features.descriptors);
  StereoMatcher matcher(options.extractor, options.stereo);
  matcher.match(extractor, frame.right, camera.fx_px, camera.baseline_fx_px_m, features);
  int matched = 0, close = 0;
  double sum = 0;
  for (std::size_t i = 0; i < features.size(); ++i) {
    const cv::KeyPoint& keypoint = features.keypoints[i];
    const float right_u_px = features.right_u_px[i];
    CHECK(std::isnan(right_u_px) == std::isnan(features.depth_m[i]));  // nothing here is far
    if (std::isnan(right_u_px)) continue;
    ++matched;
    const double depth_m =
        frame.depth.at<std::uint16_t>(cvRound(keypoint.pt.y), cvRound(keypoint.pt.x)) / 5000.0;
    const double miss_px = keypoint.pt.x - right_u_px - camera.baseline_fx_px_m / depth_m;
    const double miss = miss_px / std::pow(options.extractor.scale_factor, keypoint.octave);
    close += std::abs(miss) < 0.5;
    sum += std::clamp(miss, -0.5, 0.5);
    CHECK(features.depth_m[i] ==
          doctest::Approx(camera.baseline_fx_px_m / (keypoint.pt.x - right_u_px)).epsilon(1e-4));
  }
  CHECK(matched > 300);
  CHECK(close > 0.9 * matched);          // a parabola over whole pixels errs by less than half of one
  CHECK(std::abs(sum / matched) < 0.1);  // and to both sides
}

TEST_CASE("without a right image nothing has a match, and a flat grey one matches nothing") {
  const io::SequenceFrame frame = stereo_frame(0, 0, 0);
  const OdometryOptions options = stereo();
  OrbExtractor extractor(options.extractor);
  FrameFeatures features;
  extractor.extract(frame.grey, features.keypoints, features.descriptors);
  StereoMatcher matcher(options.extractor, options.stereo);
  for (const cv::Mat& right : {cv::Mat(), cv::Mat(480, 640, CV_8UC1, cv::Scalar(90))}) {
    matcher.match(extractor, right, 525, 52.5, features);
    REQUIRE(features.right_u_px.size() == features.size());
    for (std::size_t i = 0; i < features.size(); ++i) {
      CHECK(std::isnan(features.right_u_px[i]));
      CHECK(std::isnan(features.depth_m[i]));
    }
  }
}

namespace {

/// Checks what a stereo host hands over.
class StereoJudge : public FeatureJudge {
 public:
  Flags before_pose(const FrameView& view) override {
    check(view);
    flags.assign(view.size(), 0);
    for (std::size_t i = 0; i < view.size(); ++i) flags[i] = view.keypoints[i].pt.x < 200;
    return flags;
  }
  Flags after_pose(const FrameView& view) override {
    check(view);
    return {};
  }
  Flags at_keyframe(const FrameView& view) override {
    check(view);
    return {};
  }
  void reset() override {}
  std::vector<std::uint8_t> flags;

 private:
  static void check(const FrameView& view) {
    CHECK(view.right_u_px.size() == view.size());
    CHECK(view.depth.empty());
    REQUIRE(view.camera);
    CHECK(view.camera->baseline_m() == doctest::Approx(kBaseline_m));
    // Compacted with the keypoints: each column still belongs to its feature.
    for (std::size_t i = 0; i < view.size(); ++i) {
      if (!valid_right(view.right_u_px[i])) continue;
      const float disparity_px = view.keypoints_undistorted[i].pt.x - view.right_u_px[i];
      CHECK(disparity_px > 20.0F);  // 26 px for the wall, 33 px for the board
      CHECK(disparity_px < 40.0F);
    }
  }
};

}  // namespace

TEST_CASE("a swaying stereo camera is followed to millimetres, in metres") {
  cv::setNumThreads(1);
  StereoJudge judge;
  Odometry odometry(stereo_camera(), stereo(), &judge);
  for (int i = 0; i < 25; ++i) {
    io::SequenceFrame frame =
        stereo_frame(0.15 * std::sin(0.07 * i), 0.08 * (1 - std::cos(0.05 * i)), i / 30.0);
    frame.depth = cv::Mat();
    CHECK(odometry.process(frame).state == TrackState::Tracked);
  }
  const io::Trajectory poses = odometry.trajectory();
  REQUIRE(poses.size() == 25);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double k = static_cast<double>(i);
    const Eigen::Vector3d truth(0.15 * std::sin(0.07 * k), 0.08 * (1 - std::cos(0.05 * k)), 0);
    CHECK((poses[i].T_world_camera.t() - truth).norm() < 0.004);
  }
}

TEST_CASE("real frames: a street, with both cameras and with the left one alone" *
          doctest::test_suite("shared_data")) {
  if (!std::filesystem::exists(DYNFILTER_DATA_DIR)) {
    MESSAGE("skipped: no ../shared/data");
    return;
  }
  const io::Sequence sequence =
      io::Sequence::open(std::filesystem::path(DYNFILTER_DATA_DIR) / "kitti_stereo");
  for (const Sensor sensor : {Sensor::Stereo, Sensor::Mono}) {
    CAPTURE(to_string(sensor));
    OdometryOptions options;
    options.sensor = sensor;
    Odometry odometry(sequence.camera(), options, nullptr);
    for (std::size_t i = 0; i < sequence.size(); ++i) odometry.process(sequence.load(i));
    const io::Trajectory poses = odometry.trajectory();
    CHECK(poses.size() >= 48);  // a mono map begins with the second or third frame
    eval::AteOptions ate;
    ate.with_scale = sensor == Sensor::Mono;
    // 60 m of driving; an error of a fifth of a per cent of the way is usual for such systems.
    CHECK(eval::absolute_trajectory_error(*sequence.ground_truth(), poses, ate).error_m.rmse < 0.12);
  }
}

}  // namespace stereo_test
