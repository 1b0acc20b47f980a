// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"
#include "render/sequence_renderer.hpp"
#include "support/effort.hpp"

namespace sensor_sequence_test {

using namespace dynfilter;
using namespace dynfilter::render;

namespace {

using dynfilter_test::kSlowBuild;

SequenceOptions quiet(const std::string& scene) {
  SequenceOptions options;
  options.scene = scene;
  options.image_noise = 0;
  options.perfect_depth = true;
  return options;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

/// Mean absolute difference in grey levels.
double difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / (static_cast<double>(a.total()) * a.channels());
}

/// The light between two times, from many more instants than the renderer uses.
cv::Mat light(SequenceRenderer& renderer, double middle_s, double exposure_s, int instants) {
  cv::Mat sum(480, 640, CV_32FC3, cv::Scalar::all(0)), colour, squares;
  for (int i = 0; i < instants; ++i) {
    renderer.instant(middle_s + exposure_s * ((i + 0.5) / instants - 0.5), colour);
    colour.convertTo(squares, CV_32F);
    sum += squares.mul(squares) / instants;
  }
  cv::sqrt(sum, sum);
  sum.convertTo(colour, CV_8U);
  return colour;
}

constexpr int kFrame = 20;

}  // namespace

TEST_CASE("blur is the mean of the light along the exposure, around the time stamp") {
  for (const std::string scene : {"turn_100", "walking_turn_60"}) {
    if (kSlowBuild && scene != "turn_100") continue;
    CAPTURE(scene);
    SequenceRenderer renderer(quiet(scene));
    CHECK(renderer.exposure_ms() == 12);
    const cv::Mat blurred = renderer.frame(kFrame).colour;
    cv::Mat sharp;
    renderer.instant(kFrame / 30.0, sharp);
    const cv::Mat twin = light(renderer, kFrame / 30.0, 0.012, 40);
    const cv::Mat early = light(renderer, kFrame / 30.0 - 0.006, 0.012, 20);
    CHECK(difference(blurred, twin) < 0.5);
    CHECK(difference(blurred, twin) < 0.2 * difference(blurred, sharp));
    CHECK(difference(blurred, twin) < 0.2 * difference(blurred, early));
  }
}

TEST_CASE("options override the exposure that a scene's camera has") {
  SequenceOptions options = quiet("turn_100");
  options.exposure_ms = 0;
  SequenceRenderer sharp(options);
  CHECK(sharp.exposure_ms() == 0);
  cv::Mat instant;
  sharp.instant(kFrame / 30.0, instant);
  CHECK(same(sharp.frame(kFrame).colour, instant));
  options = quiet("static_desk");
  CHECK(SequenceRenderer(options).exposure_ms() == 0);
  options.motion_blur = true;
  CHECK(SequenceRenderer(options).exposure_ms() == kBlurExposure_ms);
  options.exposure_ms = 5;
  CHECK(SequenceRenderer(options).exposure_ms() == 5);
}

TEST_CASE("rows of a rolling shutter are exposed one after the other") {
  SequenceOptions options = quiet("turn_100");
  options.exposure_ms = 0;
  options.rolling_shutter_ms = 20;
  SequenceRenderer rolling(options);
  const RenderedFrame frame = rolling.frame(kFrame);
  cv::Mat twin, together;
  rolling.instant(kFrame / 30.0, together);
  for (const int row : {0, 1, 77, 150, 240, 333, 478, 479}) {
    CAPTURE(row);
    rolling.instant(kFrame / 30.0 + (row / 480.0 - 0.5) * 0.020, twin);
    const double miss = difference(frame.colour.row(row), twin.row(row));
    CHECK(miss < 3);
    if (std::abs(row - 240) > 150) CHECK(miss < 0.3 * difference(together.row(row), twin.row(row)));
  }
  options.rolling_shutter_ms = 0;
  SequenceRenderer global(options);
  CHECK(same(frame.truth.labels, global.frame(kFrame).truth.labels));
  CHECK(same(frame.depth, global.frame(kFrame).depth));
}

TEST_CASE("rolling shutter and blur together: a row is the mean of the light around its own time") {
  SequenceOptions options = quiet("walking_turn_100");
  options.rolling_shutter_ms = 16;
  SequenceRenderer renderer(options);
  const cv::Mat colour = renderer.frame(kFrame).colour;
  for (const int row : {20, 401}) {
    CAPTURE(row);
    const double middle_s = kFrame / 30.0 + (row / 480.0 - 0.5) * 0.016;
    const cv::Mat twin = light(renderer, middle_s, 0.012, 30).row(row);
    const cv::Mat elsewhere = light(renderer, kFrame / 30.0, 0.012, 30).row(row);
    CHECK(difference(colour.row(row), twin) < 1);
    CHECK(difference(colour.row(row), twin) < 0.3 * difference(elsewhere, twin));
  }
}

TEST_CASE("depth that is a frame late is the depth of the next frame; everything else stays") {
  SequenceOptions options = quiet("walking_rpy");
  SequenceRenderer on_time(options);
  const RenderedFrame now = on_time.frame(kFrame), next = on_time.frame(kFrame + 1);
  options.depth_offset_ms = 1000 / 30.0;
  SequenceRenderer late(options);
  const RenderedFrame frame = late.frame(kFrame);
  CHECK(cv::countNonZero(frame.depth != next.depth) < 0.001 * 640 * 480);
  CHECK(cv::countNonZero(frame.depth != now.depth) > 0.5 * 640 * 480);
  CHECK(same(frame.colour, now.colour));
  CHECK(same(frame.true_depth_m, now.true_depth_m));
  CHECK(same(frame.truth.labels, now.truth.labels));
  CHECK(same(frame.truth.dynamic, now.truth.dynamic));
  CHECK(same(frame.truth.motion, now.truth.motion));
  CHECK(frame.timestamp_s == now.timestamp_s);
}

TEST_CASE("the frame rate moves time stamps and poses; what counts as dynamic is the same") {
  SequenceOptions options = quiet("walking_xyz");
  SequenceRenderer usual(options);
  options.rate_hz = 60;
  SequenceRenderer fast(options);
  options.rate_hz = 10;
  SequenceRenderer slow(options);
  const RenderedFrame a = usual.frame(30), b = fast.frame(60), c = slow.frame(10);
  for (const RenderedFrame* other : {&b, &c}) {
    CHECK(other->timestamp_s == a.timestamp_s);
    CHECK(same(other->colour, a.colour));
    CHECK(same(other->depth, a.depth));
    CHECK(same(other->truth.labels, a.truth.labels));
    CHECK(same(other->truth.dynamic, a.truth.dynamic));
    CHECK((other->T_world_camera.t() - a.T_world_camera.t()).norm() == 0);
  }
  CHECK(a.timestamp_s == doctest::Approx(1.7e9 + 1).epsilon(1e-15));
  CHECK(fast.timestamp_s(1) - fast.timestamp_s(0) == doctest::Approx(1 / 60.0).epsilon(1e-4));
  CHECK(slow.timestamp_s(1) - slow.timestamp_s(0) == doctest::Approx(0.1).epsilon(1e-4));
  CHECK(slow.time_s(7) == doctest::Approx(0.7));
  // motion/ is per frame.
  const double per_frame = cv::sum(a.truth.motion)[0];
  CHECK(cv::sum(b.truth.motion)[0] == doctest::Approx(per_frame / 2).epsilon(0.05));
  CHECK(cv::sum(c.truth.motion)[0] == doctest::Approx(3 * per_frame).epsilon(0.1));
}

TEST_CASE("a calibration error is in what users are told, not in the images") {
  SequenceOptions options = quiet("static_desk");
  SequenceRenderer right(options);
  options.calibration_error = 1;
  SequenceRenderer wrong(options);
  CHECK(right.calibration() == freiburg3_camera());
  CHECK(wrong.camera() == freiburg3_camera());
  CHECK_FALSE(wrong.calibration() == freiburg3_camera());
  CHECK(same(right.frame(kFrame).colour, wrong.frame(kFrame).colour));
}

TEST_CASE("nothing is dynamic where only the camera moves, however fast") {
  for (const std::string scene : {"turn_150", "shake"}) {
    CAPTURE(scene);
    SequenceRenderer renderer(quiet(scene));
    const RenderedFrame frame = renderer.frame(kFrame);
    for (const cv::Mat* image : {&frame.truth.labels, &frame.truth.dynamic, &frame.truth.motion})
      CHECK(cv::countNonZero(*image) == 0);
  }
}

TEST_CASE("people fill more than half of the view of the standing camera") {
  double share = 0;
  SequenceRenderer renderer(quiet("standing_camera"));
  for (const int frame : {0, 15, 30, 45, 60, 75})
    share += cv::countNonZero(renderer.frame(frame).truth.person) / (6.0 * 640 * 480);
  CHECK(share > 0.5);
}

TEST_CASE("exposure times that do not fit between two frames are refused by name") {
  SequenceOptions options = quiet("static_desk");
  options.rate_hz = 60;
  options.exposure_ms = 17;
  CHECK_THROWS_WITH_AS(SequenceRenderer{options}, doctest::Contains("exposure_ms"), ConfigError);
  options.exposure_ms = 10;
  options.rolling_shutter_ms = 20;
  CHECK_THROWS_WITH_AS(SequenceRenderer{options}, doctest::Contains("rolling_shutter_ms"), ConfigError);
  options.rolling_shutter_ms = 0;
  options.rate_hz = 0;
  CHECK_THROWS_WITH_AS(SequenceRenderer{options}, doctest::Contains("rate_hz"), ConfigError);
  options.rate_hz = 60;
  options.depth_offset_ms = NAN;
  CHECK_THROWS_WITH_AS(SequenceRenderer{options}, doctest::Contains("depth_offset_ms"), ConfigError);
}

}  // namespace sensor_sequence_test
