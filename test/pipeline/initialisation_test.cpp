// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/compose.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <memory>

#include "doctest/doctest.h"
#include "fakes.hpp"

namespace initialisation_test {

using namespace dynfilter;

namespace {

/// Frame k is judged by `script[k]`; later frames by the last entry.
Pipeline scripted(std::vector<std::string> script, const InitialisationParams& params, int floor = 0) {
  PipelineConfig config;
  config.initialisation = params;
  config.floor.min_features = floor;
  config.before_pose =
      stage(std::make_unique<fakes::Scripted>("scripted", [script](const Evidence& evidence, Votes& votes) {
        const auto k = std::min(static_cast<std::size_t>(evidence.frame().id), script.size() - 1);
        for (std::size_t i = 0; i < script[k].size(); ++i) {
          if (script[k][i] == 'S') votes.cast(i, Vote::Static);
          if (script[k][i] == 'D') votes.cast(i, Vote::Dynamic);
        }
      }));
  return Pipeline(std::move(config));
}
/// One letter per frame: w for a delayed keyframe.
std::string waits(Pipeline& pipeline, int frames) {
  std::string text;
  for (int k = 0; k < frames; ++k)
    text += pipeline.before_pose(fakes::Features(10).view(k)).report.wait_for_keyframe ? 'w' : '.';
  return text;
}
InitialisationParams limits(double max_dynamic_share, int max_frames) {
  InitialisationParams params;
  params.max_dynamic_share = max_dynamic_share;
  params.max_frames = max_frames;
  return params;
}

const std::string kUnknown = "UUUUUUUUUU", kBusy = "DDDDSSSSSS", kCalm = "DDDSSSSSSS";

}  // namespace

TEST_CASE("the first keyframe waits while too much moves, or nothing could be judged") {
  // 4 of 10 against 0.3, then 3 of 10.
  Pipeline pipeline = scripted({kUnknown, kBusy, kBusy, kCalm, kCalm}, limits(0.3, 10));
  CHECK(waits(pipeline, 5) == "www..");
}

TEST_CASE("the share is that of the features that could be judged") {
  Pipeline pipeline = scripted({"DSUUUUUUUU", "DSSSUUUUUU"}, limits(0.3, 10));
  CHECK(waits(pipeline, 2) == "w.");
}

TEST_CASE("it waits for so many frames and no more; by default not at all") {
  Pipeline three = scripted({kBusy}, limits(0.3, 3));
  CHECK(waits(three, 5) == "www..");
  Pipeline never = scripted({kBusy}, InitialisationParams());
  CHECK(waits(never, 3) == "...");
}

TEST_CASE("two calls for one frame are one frame") {
  Pipeline pipeline = scripted({kBusy}, limits(0.3, 1));
  const fakes::Features features(10);
  CHECK(pipeline.before_pose(features.view(0)).report.wait_for_keyframe);
  CHECK(pipeline.before_pose(features.view(0)).report.wait_for_keyframe);
  CHECK_FALSE(pipeline.before_pose(features.view(1)).report.wait_for_keyframe);
}

TEST_CASE("what the floor restores still moves") {
  Pipeline pipeline = scripted({kBusy}, limits(0.3, 10), 10);
  const Verdict& verdict = pipeline.before_pose(fakes::Features(10).view(0));
  CHECK(verdict.kept() == 10);
  CHECK(verdict.report.wait_for_keyframe);
}

TEST_CASE("once there is a keyframe nothing waits, until a reset") {
  Pipeline pipeline = scripted({kBusy}, limits(0.3, 10));
  const fakes::Features features(10);
  CHECK(pipeline.before_pose(features.view(0)).report.wait_for_keyframe);
  CHECK_FALSE(pipeline.at_keyframe(features.view(0)).report.wait_for_keyframe);
  CHECK_FALSE(pipeline.before_pose(features.view(1)).report.wait_for_keyframe);
  pipeline.reset();
  CHECK(pipeline.before_pose(features.view(2)).report.wait_for_keyframe);
}

TEST_CASE("the rules are read from YAML, and checked") {
  const auto read = [](const std::string& rules) {
    return pipeline_from_text("%YAML:1.0\n---\npipeline:\n  initialisation: " + rules + "\n",
                              builtin_filters());
  };
  const PipelineConfig config = read("{ max_dynamic_share: 0.25, max_frames: 12 }");
  CHECK(config.initialisation.max_dynamic_share == 0.25);
  CHECK(config.initialisation.max_frames == 12);
  CHECK_THROWS_AS(read("{ max_dynamic_share: 2 }"), ConfigError);
  CHECK_THROWS_AS(read("{ frames: 2 }"), ConfigError);
}

// ---- the preset motion_consistency, rule by rule

namespace {

/// Matched features in front of a static camera, with descriptors and depth.
/// Static ones are on a regular grid at 3 m; each test adds others.
struct Room {
  std::vector<cv::KeyPoint> then, now;
  std::vector<float> then_depth_m, now_depth_m;
  std::vector<std::int32_t> index;
  std::vector<cv::Mat> then_rows, now_rows;
  Camera camera;
  cv::RNG random{11};

  Room() {
    camera.fx_px = camera.fy_px = 500, camera.cx_px = 320, camera.cy_px = 240;
    camera.width_px = 640, camera.height_px = 480;
    for (int y = 20; y < 470; y += 25)
      for (int x = 20; x < 630; x += 25)
        add({static_cast<float>(x), static_cast<float>(y)}, {static_cast<float>(x), static_cast<float>(y)}, 3,
            0);
  }
  /// `bits`: Hamming distance of the two descriptors.
  void add(const cv::Point2f& from, const cv::Point2f& to, float depth_m, int bits) {
    then.emplace_back(from, 1.0F), now.emplace_back(to, 1.0F);
    then_depth_m.push_back(depth_m), now_depth_m.push_back(depth_m);
    cv::Mat row(1, 32, CV_8UC1);
    random.fill(row, cv::RNG::UNIFORM, 0, 256);
    then_rows.push_back(row);
    now_rows.push_back(row.clone());
    for (int b = 0; b < bits; ++b)
      now_rows.back().at<std::uint8_t>(0, b / 8) ^= static_cast<std::uint8_t>(1 << b % 8);
    index.push_back(static_cast<std::int32_t>(index.size()));
  }
  FrameView view(std::int64_t id, const std::vector<cv::KeyPoint>& keypoints,
                 const std::vector<float>& depth_m, const cv::Mat& descriptors) const {
    FrameView frame;
    frame.id = id;
    frame.timestamp_s = static_cast<double>(id) / 30;
    frame.keypoints = keypoints;
    frame.depth_m = depth_m;
    frame.descriptors = descriptors;
    frame.camera = camera;
    return frame;
  }
  Verdict judged(Pipeline& pipeline) const {
    cv::Mat then_descriptors, now_descriptors;
    cv::vconcat(then_rows, then_descriptors);
    cv::vconcat(now_rows, now_descriptors);
    pipeline.before_pose(view(0, then, then_depth_m, then_descriptors));
    return pipeline.before_pose(view(1, now, now_depth_m, now_descriptors));
  }
};

Pipeline motion_consistency() {
  return Pipeline(pipeline_from_file(
      std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/motion_consistency.yaml", builtin_filters()));
}

}  // namespace

TEST_CASE("motion_consistency: a lone match that looks alike and moved between d1 and the cap is dynamic") {
  Room room;
  const std::size_t first = room.now.size();
  // At 1.4 m and 500 px of focal length, 10 px are 2.8 cm.
  // GMS detects what leaves its cell of 32 x 24 px.
  room.add({300, 210}, {334, 210}, 1.4F, 10);  // 9.5 cm: dynamic
  room.add({410, 110}, {416, 108}, 1.4F, 10);  // 1.8 cm: within d1
  room.add({210, 310}, {255, 310}, 1.4F, 10);  // 12.6 cm: beyond the cap
  room.add({510, 310}, {544, 310}, 1.4F, 60);  // 9.5 cm, not similar
  Pipeline pipeline = motion_consistency();
  const Verdict verdict = room.judged(pipeline);
  CHECK(verdict.decision[first] == Vote::Dynamic);
  for (std::size_t i = first + 1; i < first + 4; ++i) CHECK(verdict.keep(i));
  for (std::size_t i = 0; i < first; ++i) CHECK(verdict.keep(i));
}

TEST_CASE("motion_consistency: features of the cluster that the pipeline could not judge go along") {
  Room room;
  const std::size_t first = room.now.size();
  // Ten features that end within 20 cm of each other, each moved by 9.5 cm in another direction.
  for (int k = 0; k < 10; ++k) {
    const cv::Point2f to(305.0F + 14.0F * static_cast<float>(k % 5),
                         205.0F + 20.0F * static_cast<float>(k / 5));
    const float angle = 0.6283F * static_cast<float>(k);
    room.add(to - 34 * cv::Point2f(std::cos(angle), std::sin(angle)), to, 1.4F, 10);
  }
  room.add({335, 220}, {335, 220}, 1.4F, 200);  // no match: its descriptor has changed
  room.add({335, 370}, {335, 370}, 1.4F, 200);  // the same, 40 cm below
  Pipeline pipeline = motion_consistency();
  const Verdict verdict = room.judged(pipeline);
  int found = 0;
  for (std::size_t i = first; i < first + 10; ++i) found += verdict.keep(i) ? 0 : 1;
  CHECK(found >= 9);
  CHECK(verdict.decision[first + 10] == Vote::Dynamic);
  CHECK(verdict.reason(first + 10) == "dbscan");
  CHECK(verdict.keep(first + 11));
}

TEST_CASE(
    "motion_consistency: a rigid scene loses nothing, and its first keyframe waits for one frame only") {
  const testing::ExactScene scene = testing::preset(testing::Preset::Rigid).with_descriptors(10);
  Pipeline pipeline = motion_consistency();
  for (int k = 0; k < 6; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    const Verdict& verdict = pipeline.before_pose(frame.view());
    CHECK(verdict.kept() == frame.size());
    CHECK(verdict.report.wait_for_keyframe == (k == 0));
  }
}

}  // namespace initialisation_test
