// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>

#include "doctest/doctest.h"

namespace judge_test {

using namespace dynfilter;
using testing::ExactFrame;
using testing::ExactScene;
using testing::Preset;
using testing::Score;
using testing::Truth;

namespace {

// Correct for a static camera: what moves in the image moves. Also records its calls.
class PictureMotion : public Filter {
 public:
  std::string name() const override { return "picture_motion"; }
  Needs needs() const override { return {Input::Correspondence, Input::None, history_frames}; }
  void apply(const Evidence& evidence, Votes& votes) override {
    frames.push_back(evidence.frame().id);
    const Match& match = evidence.match({false, 1});
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (!match.found(i)) continue;
      const cv::Point2f moved = evidence.pixels()[i] - match.correspondences.reference_px[i];
      votes.cast(i, std::hypot(moved.x, moved.y) > 0.5F ? Vote::Dynamic : Vote::Static);
    }
  }
  void reset() override { frames.clear(); }

  int history_frames = 1;
  std::vector<std::int64_t> frames;
};

class NeedsBoxes : public PictureMotion {
 public:
  Needs needs() const override { return {Input::Detections | Input::Correspondence, Input::None, 1}; }
};

}  // namespace

TEST_CASE("A right filter gets full marks, and is called on every frame from a fresh start") {
  PictureMotion filter;
  for (const int gap : {1, 4}) {
    const ExactScene scene = testing::preset(Preset::NoMotion).gap(gap);
    const ExactFrame frame = scene.frame(8);
    const Score score(testing::judge(filter, scene, 8), frame);
    CHECK(score.recall() == 1);
    CHECK(score.precision() == 1);
    CHECK(score.static_kept() == 1);
    CHECK(score.dynamic_missed == 0);
    CHECK(score.dynamic_count > 40);
    // Some were hidden before: no match.
    CHECK(score.static_confirmed >= 0.95 * score.static_count);
    // Frames without matches lack a required input, so the filter is not called.
    CHECK(filter.frames.front() == gap);
    CHECK(filter.frames.back() == 8);
    CHECK(filter.frames.size() == static_cast<std::size_t>(9 - gap));
  }
}

TEST_CASE("A wrong filter does not") {
  PictureMotion filter;
  const ExactScene scene = testing::preset(Preset::General);
  const Score score(testing::judge(filter, scene, 5), scene.frame(5));
  CHECK(score.recall() > 0.95);
  CHECK(score.static_kept() < 0.05);
  CHECK(score.precision() < 0.3);
}

TEST_CASE("What nobody can tell is not counted") {
  PictureMotion filter;
  // 1 mm a frame: 5 mm in five frames, but 0.2 px in each.
  const ExactScene scene = ExactScene()
                               .camera_motion(testing::CameraStep::None)
                               .mover(testing::MovingBox(50).moving({0.001, 0, 0}));
  const Score score(testing::judge(filter, scene, 7), scene.frame(7));
  CHECK(score.dynamic_count == 0);
  CHECK(score.recall() == 1);
  CHECK(score.static_count > 200);
}

TEST_CASE("Counting") {
  ExactFrame frame;
  frame.keypoints.resize(8);
  frame.truth = {Truth::Dynamic, Truth::Dynamic, Truth::Dynamic, Truth::Dynamic,
                 Truth::Static,  Truth::Static,  Truth::Static,  Truth::DontCare};
  Votes votes;
  votes.reset(8);
  votes.cast(0, Vote::Dynamic);
  votes.cast(1, Vote::Static);
  votes.cast(4, Vote::Dynamic);
  votes.cast(5, Vote::Static);
  votes.cast(7, Vote::Dynamic);
  Score score(votes, frame);
  CHECK(score.recall() == doctest::Approx(0.25));
  CHECK(score.precision() == doctest::Approx(0.5));
  CHECK(score.static_kept() == doctest::Approx(2.0 / 3));
  CHECK(score.dynamic_missed == 1);
  CHECK(score.static_confirmed == 1);
  score.add(votes, frame);
  CHECK(score.dynamic_count == 8);
  CHECK(score.recall() == doctest::Approx(0.25));
  CHECK(Score().recall() == 1);
  votes.reset(7);
  CHECK_THROWS_AS(score.add(votes, frame), ConfigError);
}

TEST_CASE("A scene that lacks what the filter needs is said, not judged") {
  NeedsBoxes filter;
  CHECK_THROWS_WITH_AS(testing::judge(filter, testing::preset(Preset::General), 3),
                       "picture_motion: frame 3 of the scene has no boxes", ConfigError);
  CHECK_NOTHROW(testing::judge(filter, testing::preset(Preset::General).with_detections(), 3));
}

}  // namespace judge_test
