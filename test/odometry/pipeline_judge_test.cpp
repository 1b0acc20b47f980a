// SPDX-License-Identifier: MIT
#include "running/pipeline_judge.hpp"
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <odometry/odometry.hpp>

#include "test_images.hpp"

// Included last, because other headers may include glog.
#include "doctest/doctest.h"

namespace pipeline_judge_test {

using namespace dynfilter;
using namespace dynfilter::odometry;
using command::PipelineJudge;

namespace {
PipelineConfig pipeline(const char* before_pose) {
  const std::string text =
      std::string("%YAML:1.0\n---\npipeline:\n  name: test\n  before_pose:\n") + before_pose;
  return pipeline_from_text(text, builtin_filters());
}
}  // namespace

TEST_CASE("a pipeline that rejects people's boxes takes exactly the features inside") {
  PipelineJudge judge(pipeline("    - semantic_box: { role: reject, refine: none }\n"));
  Odometry odometry(odometry_test::camera(), {}, &judge);
  std::vector<Detection> people(1);
  people[0].box = {100.37F, 50.23F, 200.1F, 300.1F};
  people[0].class_name = "person";
  for (int i = 0; i < 3; ++i) {
    SemanticInputs inputs;
    inputs.detections = DetectionInput{-1, Span<const Detection>(people)};
    const TrackResult result = odometry.process(odometry_test::frame_at(0.01 * i, 0, i / 30.0), inputs);
    CHECK(result.state == TrackState::Tracked);
    int inside = 0, wrong = 0;
    for (std::size_t k = 0; k < odometry.extracted().size(); ++k) {
      const bool in_box = people[0].box.contains(odometry.extracted()[k].pt);
      inside += in_box;
      wrong += in_box != (odometry.rejected_at()[k] == RejectedAt::BeforePose);
    }
    CHECK(inside > 50);
    CHECK(wrong == 0);
    CHECK(result.rejected == inside);
    CHECK(judge.record().count(Vote::Dynamic) == static_cast<std::size_t>(inside));
  }
}

TEST_CASE("geometry leaves the odometry of a static scene alive, and its time is accounted for") {
  PipelineJudge judge(pipeline(
      "    - any:\n        - epipolar: { max_distance_px: 1.0 }\n        - trajectory_consistency: { "
      "threshold: noise }\n"));
  Odometry odometry(odometry_test::camera(), {}, &judge);
  int rejected = 0;
  for (int i = 0; i < 8; ++i) {
    const TrackResult result = odometry.process(odometry_test::frame_at(0.01 * i, 0.004 * i, i / 30.0));
    CHECK(result.state == TrackState::Tracked);
    rejected += result.rejected;
  }
  CHECK(rejected < 0.25 * 8 * 1000);  // the board's silhouettes move over the wall
  CHECK(judge.record().correspondence_ms > 0);
  CHECK(judge.record().filters_ms > 0);
}

TEST_CASE("the map starts when the pipeline no longer asks to wait") {
  // Most of the image is in a box at first.
  const std::string text =
      "%YAML:1.0\n---\npipeline:\n  initialisation: { max_dynamic_share: 0.3, max_frames: 5 }\n"
      "  before_pose:\n    - semantic_box: { role: reject, refine: none }\n    - trajectory_consistency\n"
      "  floor: { min_features: 0 }\n";
  PipelineJudge judge(pipeline_from_text(text, builtin_filters()));
  Odometry odometry(odometry_test::camera(), {}, &judge);
  std::vector<Detection> people(1);
  people[0].box = {0, 0, 640, 400};
  people[0].class_name = "person";
  for (int i = 0; i < 6; ++i) {
    SemanticInputs inputs;
    const bool busy = i < 3;
    inputs.detections = DetectionInput{-1, busy ? Span<const Detection>(people) : Span<const Detection>()};
    const TrackResult result = odometry.process(odometry_test::frame_at(0.02 * i, 0, i / 30.0), inputs);
    CAPTURE(i);
    CHECK((result.state == TrackState::NoMap) == busy);
    if (i <= 3) CHECK(result.keyframe == (i == 3));
    CHECK(result.T_world_camera.has_value() == !busy);
  }
}

}  // namespace pipeline_judge_test
