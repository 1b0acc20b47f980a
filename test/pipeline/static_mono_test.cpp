// SPDX-License-Identifier: MIT
// One camera, recordings in which nothing else moves, and features spread evenly as the hosts of the ORB-SLAM
// family do. The odometry of the command spreads otherwise: what locked the filter there was seen by no other
// test.
#include <algorithm>
#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "doctest/doctest.h"
#include "io/sequence.hpp"
#include "render/sequence_renderer.hpp"
#include "support/effort.hpp"
#include "support/static_play.hpp"

namespace static_mono_test {

using namespace dynfilter;
using dynfilter_test::GreyRecording;
using dynfilter_test::Rejected;
namespace fs = std::filesystem;

namespace {

/// Of 700 the filter once locked: 29 % of all frames' features were rejected from one start of six.
constexpr int kCounts[] = {500, 700, 1000, 2000};

Pipeline mono_pipeline() {
  return Pipeline(pipeline_from_file(
      std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/dynfilter_mono.yaml", builtin_filters()));
}

/// Empty without the data.
GreyRecording recorded(const char* name) {
  GreyRecording recording;
  const fs::path folder = fs::path(DYNFILTER_DATA_DIR) / name;
  if (!fs::exists(folder)) {
    MESSAGE("skipped: no ../shared/data");
    return recording;
  }
  const io::Sequence sequence = io::Sequence::open(folder);
  recording.camera = sequence.camera();
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    recording.images.push_back(sequence.load(k).grey);
    recording.times_s.push_back(sequence.timestamp_s(k));
  }
  return recording;
}

struct Limits {
  double mean, worst, late;
};

/// Six starts: forwards and backwards from frames 0, 5 and 10.
void check_starts(const GreyRecording& recording, int frames, const Limits& limits) {
  Pipeline pipeline = mono_pipeline();
  for (const bool backwards : {false, true})
    for (const std::size_t first : {0U, 5U, 10U}) {
      CAPTURE(backwards);
      CAPTURE(first);
      const Rejected rejected = dynfilter_test::play(pipeline, recording, first, backwards, frames);
      CHECK(rejected.mean <= limits.mean);
      CHECK(rejected.worst <= limits.worst);
      CHECK(rejected.late <= limits.late);
    }
}

}  // namespace

TEST_CASE("quadtree: as many features as wanted, the strongest of each leaf, in all quarters of the image") {
  std::vector<cv::KeyPoint> corners;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x)  // dense on the left
      corners.emplace_back(
          x < 30 ? 0.1F + 0.5F * static_cast<float>(x) : 16.0F + 1.5F * static_cast<float>(x),
          2.0F * static_cast<float>(y), 7.0F, -1.0F, static_cast<float>((7 * x + 13 * y) % 101));
  const auto chosen = dynfilter_test::spread_by_quadtree(corners, {80, 80}, 64);
  CHECK(chosen.size() >= 61);
  CHECK(chosen.size() <= 67);
  int right = 0;
  for (const cv::KeyPoint& k : chosen) right += k.pt.x >= 40 ? 1 : 0;
  CHECK(right >= 16);  // these corners cover 2 of 8 columns of leaves of 10 px
  // The strongest of all is the strongest of its leaf.
  CHECK(std::any_of(chosen.begin(), chosen.end(), [](const cv::KeyPoint& k) { return k.response == 100; }));
}

TEST_CASE("static desk, rendered, mono: spread features are kept") {
  render::SequenceOptions options;
  options.scene = "static_desk";
  options.frames = 16;
  render::SequenceRenderer renderer(options);
  GreyRecording recording;
  recording.camera = renderer.calibration();
  recording.camera.baseline_fx_px_m = 0;
  for (int k = 0; k < options.frames; ++k) {
    recording.images.emplace_back();
    cv::cvtColor(renderer.frame(k).colour, recording.images.back(), cv::COLOR_BGR2GRAY);
    recording.times_s.push_back(k / 30.0);
  }
  for (const int count : kCounts) {
    if (dynfilter_test::kSlowBuild && count != kCounts[0]) continue;
    CAPTURE(count);
    recording.spread_features(count);
    check_starts(recording, 45, {0.025, 0.10, 0.03});  // 2.2 % with 2000 features
  }
}

TEST_CASE("static desk, real frames, mono, to and fro: spread features are kept from every start" *
          doctest::test_suite("shared_data")) {
  GreyRecording recording = recorded("tum_fr1_xyz");
  if (recording.images.empty()) return;
  for (const int count : kCounts) {
    CAPTURE(count);
    recording.spread_features(count);
    check_starts(recording, 240, {0.02, 0.08, 0.03});
  }
}

}  // namespace static_mono_test
