// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/pipeline/compose.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>

#include "doctest/doctest.h"
#include "fakes.hpp"

namespace pipeline_test {

using namespace dynfilter;
using fakes::Features;
using fakes::letters_of;
using fakes::says;
using fakes::Scripted;

namespace {

PipelineConfig config_with(StagePtr before) {
  PipelineConfig config;
  config.floor.min_features = 0;
  config.before_pose = std::move(before);
  return config;
}

/// Records how many earlier frames are kept.
StagePtr count_history(std::vector<std::size_t>& log, int frames = 3) {
  return stage(std::make_unique<Scripted>(
      "count",
      [&log](const Evidence& evidence, Votes&) {
        log.push_back(0);
        for (std::int64_t id = 0; id < 100; ++id)
          if (id != evidence.frame().id && evidence.kept_frame(id) != nullptr) ++log.back();
      },
      Needs{Input::None, Input::None, frames}));
}

/// As a semantic stage: marks or rejects by letters, and is skipped without boxes.
StagePtr semantic(const std::string& letters) {
  return stage(std::make_unique<Scripted>(
      "boxes",
      [letters](const Evidence&, Votes& votes) {
        for (std::size_t i = 0; i < letters.size(); ++i) {
          if (letters[i] == 'P') votes.mark_prior(i);
          if (letters[i] == 'D') votes.cast(i, Vote::Dynamic);
        }
      },
      Needs{Input::Detections}));
}
/// Says what `letters` say, but nothing on a frame without an earlier one.
StagePtr with_history(const std::string& letters) {
  return stage(std::make_unique<Scripted>(
      "moves",
      [letters](const Evidence& evidence, Votes& votes) {
        if (evidence.match({}).reference == nullptr) return;
        for (std::size_t i = 0; i < letters.size(); ++i)
          votes.cast(i, letters[i] == 'D' ? Vote::Dynamic : Vote::Static);
      },
      Needs{Input::None, Input::None, 1}));
}
FrameView with_boxes(const Features& features, std::int64_t id) {
  FrameView frame = features.view(id);
  frame.detections = DetectionInput{};
  return frame;
}

}  // namespace

TEST_CASE("a pipeline without stages keeps everything as unknown") {
  Pipeline pipeline{PipelineConfig()};
  const Verdict& verdict = pipeline.before_pose(Features(3).view());
  CHECK(letters_of(verdict) == "UUU");
  CHECK(verdict.kept() == 3);
  CHECK(verdict.report.stages.empty());
  CHECK(verdict.report.features == 3);
}

TEST_CASE("the report counts what each stage did") {
  Pipeline pipeline(config_with(sequence(stage(says("a", "DSUP")), stage(says("b", "DDUU")))));
  const Verdict& verdict = pipeline.before_pose(Features(4).view(7));
  CHECK(letters_of(verdict) == "DDUU");
  CHECK(verdict.prior == std::vector<std::uint8_t>{0, 0, 0, 1});
  CHECK(verdict.report.frame_id == 7);
  CHECK(verdict.report.rejected == 2);
  REQUIRE(verdict.report.stages.size() == 3);
  const StageReport &a = verdict.report.stages[1], &b = verdict.report.stages[2];
  CHECK(a.judged == 4);
  CHECK(a.dynamic == 1);
  CHECK(a.unknown == 2);
  CHECK(a.prior == 1);
  CHECK(b.judged == 3);  // the first one is rejected already
  CHECK(b.dynamic == 1);
  CHECK(b.unknown == 2);
}

TEST_CASE("each call point has its own stages; at a keyframe verdicts are per map point too") {
  PipelineConfig config = config_with(stage(says("before", "DUU")));
  config.at_keyframe = stage(says("keyframe", "SDU"));
  Pipeline pipeline(std::move(config));
  const Features features(3);
  FrameView frame = features.view();
  const std::vector<std::int64_t> map_points{5, -1, 9};
  frame.map_point_ids = map_points;
  CHECK(letters_of(pipeline.before_pose(frame)) == "DUU");
  CHECK(pipeline.before_pose(frame).map_points.empty());
  CHECK(letters_of(pipeline.after_pose(frame)) == "UUU");
  const Verdict& verdict = pipeline.at_keyframe(frame);
  CHECK(letters_of(verdict) == "SDU");
  REQUIRE(verdict.map_points.size() == 2);
  CHECK(verdict.map_points[0].map_point_id == 5);
  CHECK(verdict.map_points[0].vote == Vote::Static);
  CHECK(verdict.map_points[1].map_point_id == 9);
  CHECK(verdict.map_points[1].vote == Vote::Unknown);
}

TEST_CASE("history keeps as many frames as the stages look back, once per frame id") {
  std::vector<std::size_t> log;
  Pipeline pipeline(config_with(count_history(log, 2)));
  const Features features(1);
  for (const std::int64_t id : {0, 1, 1, 2, 3, 4}) pipeline.before_pose(features.view(id));
  CHECK(log == std::vector<std::size_t>{0, 1, 1, 2, 2, 2});
}

TEST_CASE("reset and a time jump forget the earlier frames; a filter that learns is told") {
  std::vector<std::size_t> log;
  Pipeline pipeline(config_with(count_history(log)));
  const Features features(1);
  const auto at = [&](std::int64_t id, double timestamp_s) -> const Verdict& {
    FrameView frame = features.view(id);
    frame.timestamp_s = timestamp_s;
    return pipeline.before_pose(frame);
  };
  at(0, 0.0);
  at(1, 0.1);
  pipeline.reset();
  at(2, 0.2);
  // Time goes backwards.
  CHECK(at(3, 0.1).report.notes == std::vector<std::string>{"time jump: history forgotten"});
  at(4, 0.2);
  at(5, 99.0);  // far ahead
  at(6, std::nan(""));
  CHECK(log == std::vector<std::size_t>{0, 1, 0, 0, 1, 0, 0});
}

TEST_CASE("arrays of another length and images of another size or type are left out, with a note") {
  Input seen = Input::None;
  Pipeline pipeline(config_with(stage(std::make_unique<Scripted>(
      "look", [&](const Evidence& evidence, Votes&) { seen = evidence.inputs(); }))));
  const Features features(3);
  FrameView frame = features.view();
  const std::vector<float> two_depths{1, 2};
  frame.depth_m = two_depths;
  frame.grey = cv::Mat::zeros(4, 4, CV_8UC3);
  frame.depth = cv::Mat::zeros(4, 4, CV_64FC1);
  frame.descriptors = cv::Mat::zeros(2, 32, CV_8U);
  frame.mask = MaskInput{0, cv::Mat()};
  CHECK(pipeline.before_pose(frame).report.notes.size() == 5);
  CHECK(seen == Input::None);
  frame = features.view(1);
  frame.grey = cv::Mat::zeros(40, 40, CV_8UC1);
  frame.depth = cv::Mat::zeros(20, 40, CV_16UC1);
  CHECK(pipeline.before_pose(frame).report.notes.size() == 1);
  CHECK(seen == (Input::GreyImage | Input::Correspondence));
}

TEST_CASE("frames of changing size and without features are judged like any other") {
  std::vector<std::size_t> log;
  PipelineConfig config = config_with(stage(std::make_unique<Scripted>(
      "flow",
      [&](const Evidence& evidence, Votes&) { log.push_back(evidence.match({}).correspondences.count()); },
      Needs{Input::Correspondence, Input::None, 1})));
  Pipeline pipeline(std::move(config));
  const std::size_t counts[] = {3, 0, 5, 2};
  for (std::int64_t id = 0; id < 4; ++id) {
    const Features features(counts[id]);
    FrameView frame = features.view(id);
    frame.grey = cv::Mat::zeros(60 + 20 * static_cast<int>(id), 80, CV_8UC1);
    CHECK(pipeline.before_pose(frame).size() == counts[id]);
  }
  CHECK(log == std::vector<std::size_t>{0, 0, 0, 0});
}

TEST_CASE("first_frame_suspects: without history what a semantic stage suspects is dynamic") {
  const auto run = [](StagePtr stages, FirstFrameSuspects suspects, std::string* reason = nullptr) {
    PipelineConfig config = config_with(std::move(stages));
    config.params.first_frame_suspects = suspects;
    Pipeline pipeline(std::move(config));
    const Features features(4);
    std::string frames = letters_of(pipeline.before_pose(with_boxes(features, 5)));
    if (reason != nullptr) *reason = pipeline.before_pose(with_boxes(features, 5)).reason(1);
    frames += " " + letters_of(pipeline.before_pose(with_boxes(features, 6)));
    pipeline.reset();
    return frames + " " + letters_of(pipeline.before_pose(with_boxes(features, 7)));
  };
  const auto prior = [] { return sequence(semantic("UPPU"), with_history("SSDS")); };
  const auto both = [] { return all(semantic("UDDU"), with_history("SSDS")); };
  std::string reason;
  CHECK(run(prior(), FirstFrameSuspects::Keep) == "UUUU SSDS UUUU");
  CHECK(run(prior(), FirstFrameSuspects::Reject, &reason) == "UDDU SSDS UDDU");
  CHECK(reason == "boxes");
  CHECK(run(both(), FirstFrameSuspects::Keep) == "UUUU SSDS UUUU");
  CHECK(run(both(), FirstFrameSuspects::Reject) == "UDDU SSDS UDDU");
  // A stage that needs neither boxes nor masks suspects nothing by itself; what is called static stays.
  CHECK(run(sequence(stage(says("gate", "PPPP"))), FirstFrameSuspects::Reject) == "UUUU UUUU UUUU");
  CHECK(run(sequence(semantic("PPPP"), stage(says("sure", "SSUU"))), FirstFrameSuspects::Reject) ==
        "SSDD SSUU SSDD");
}

TEST_CASE("first_frame_suspects: the floor holds, time that jumps makes a first frame") {
  PipelineConfig config = config_with(sequence(semantic("PPPU")));
  config.params.first_frame_suspects = FirstFrameSuspects::Reject;
  config.floor.min_features = 3;
  Pipeline pipeline(std::move(config));
  const Features features(4);
  const Verdict& verdict = pipeline.before_pose(with_boxes(features, 0));
  CHECK(verdict.kept() == 3);
  CHECK(verdict.report.rejected == 1);
  CHECK(verdict.report.restored == 2);
  REQUIRE_FALSE(verdict.report.notes.empty());
  CHECK(verdict.report.notes[0] == "first frame: 3 features on boxes or masks rejected");
  CHECK(pipeline.before_pose(with_boxes(features, 1)).report.rejected == 0);
  FrameView later = with_boxes(features, 2);
  later.timestamp_s = 100;
  CHECK(pipeline.before_pose(later).report.rejected == 1);
}

TEST_CASE("wrong parameters set in code throw when the pipeline is made") {
  PipelineConfig config;
  config.floor.min_share = 2;
  CHECK_THROWS_WITH_AS(Pipeline(std::move(config)), "floor.min_share: expected 0 to 1, got `2`", ConfigError);
}

TEST_CASE("what is not judged has no vote and no reason, whatever a filter says of it") {
  Features features(3);
  features.keypoints[1].pt.x = std::nanf("");  // in no image
  Pipeline pipeline(config_with(stage(says("a", "DDS"))));
  const Verdict& verdict = pipeline.before_pose(features.view());
  CHECK(letters_of(verdict) == "DUS");
  CHECK(verdict.reasons == std::vector<std::uint64_t>{1, 0, 0});
  CHECK(verdict.report.stages[0].judged == 2);
}

}  // namespace pipeline_test
