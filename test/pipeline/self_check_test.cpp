// SPDX-License-Identifier: MIT
#include <dynfilter/pipeline/self_check.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/compose.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/pipeline/stage.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <memory>
#include <string>
#include <vector>

#include "doctest/doctest.h"

namespace self_check_test {

using namespace dynfilter;
using testing::ExactScene;
using testing::MovingBox;

/// Says the truth, or until it is reset its opposite: the movers are its background.
class Forced final : public Filter {
 public:
  Forced(const ExactScene& scene, bool wrong) : scene_(scene), wrong_(wrong) {}
  std::string name() const override { return "forced"; }
  Needs needs() const override { return {Input::Correspondence, Input::None, 1}; }
  void reset() override { wrong_ = false; }
  void apply(const Evidence& evidence, Votes& votes) override {
    if (evidence.match({}).reference == nullptr) return;
    const std::vector<int> label = scene_.frame(static_cast<int>(evidence.frame().id)).label;
    for (std::size_t i = 0; i < votes.size(); ++i)
      votes.cast(i, (label[i] != 0) != wrong_ ? Vote::Dynamic : Vote::Static);
  }

 private:
  const ExactScene& scene_;
  bool wrong_;
};

Pipeline forced(const ExactScene& scene, bool wrong) {
  PipelineConfig config;
  config.before_pose.reset(new FilterStage(std::make_unique<Forced>(scene, wrong), "before_pose"));
  return Pipeline(std::move(config));
}

Pipeline preset(const std::string& name) {
  return Pipeline(pipeline_from_file(
      std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/" + name + ".yaml", builtin_filters()));
}

/// What a host says: counts of its inliers and outliers, and its pose.
struct Host {
  std::size_t inliers = 200, outliers = 20;
  PoseProvenance provenance = PoseProvenance::Estimated;
};

struct Played {
  std::vector<int> doubts;  ///< frames with the note
  std::size_t count = 0;    ///< in the last report
  std::vector<std::vector<Vote>> decisions;
};

Played play(Pipeline pipeline, const ExactScene& scene, int frames, const Host& host) {
  Played played;
  for (int k = 0; k < frames; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    const Verdict& verdict = pipeline.before_pose(frame.view());
    const std::vector<std::string>& notes = verdict.report.notes;
    if (std::any_of(notes.begin(), notes.end(),
                    [](const std::string& note) { return note.rfind("self-check: ", 0) == 0; }))
      played.doubts.push_back(k);
    played.count = verdict.report.doubts;
    played.decisions.push_back(verdict.decision);
    pipeline.update_pose(k, scene.T_world_camera(k), host.provenance, {{}, {}, host.inliers, host.outliers});
  }
  return played;
}

ExactScene crowd(int points = 200) {
  return ExactScene().pixel_noise(0.2).mover(
      MovingBox(points).at({0.2, 0, 2.5}).half_size({0.6, 0.6, 0.2}).moving({0.03, 0, 0.01}));
}

TEST_CASE("a forced wrong background: half a second at any rate, a note, a reset, and a count") {
  for (const double rate_hz : {10.0, 30.0, 60.0}) {
    CAPTURE(rate_hz);
    const ExactScene scene = crowd().rate_hz(rate_hz);
    const Played played = play(forced(scene, true), scene, 40, {});
    // Frame 1 is the first with matches. The last of those 0.45 s is said to be wrong before the next.
    const int expected = 1 + static_cast<int>(std::ceil(0.45 * rate_hz)) + 1;
    REQUIRE(played.doubts == std::vector<int>{expected});
    CHECK(played.count == 1);
    const testing::ExactFrame frame = scene.frame(expected + 1);
    for (std::size_t i = 0; i < frame.size(); ++i)
      CHECK(played.decisions[static_cast<std::size_t>(expected + 1)][i] ==
            (frame.label[i] != 0 ? Vote::Dynamic : Vote::Static));
  }
}

TEST_CASE("the same without what speaks against the pipeline: nothing happens") {
  const ExactScene scene = crowd();
  CHECK(play(forced(scene, true), scene, 40, {0, 0, PoseProvenance::Estimated}).doubts.empty());
  CHECK(play(forced(scene, true), scene, 40, {200, 20, PoseProvenance::None}).doubts.empty());
  CHECK(play(forced(scene, true), scene, 40, {200, 20, PoseProvenance::Predicted}).doubts.empty());
  CHECK(play(forced(scene, true), scene, 40, {200, 100, PoseProvenance::Estimated}).doubts.empty());
  CHECK(play(forced(scene, true), scene, 40, {20, 0, PoseProvenance::Estimated}).doubts.empty());
  const ExactScene mono = crowd().mono();
  CHECK(play(forced(mono, true), mono, 40, {}).doubts.empty());
  const ExactScene few = ExactScene(scene).points(60);  // the wrong ones are fewer than 30 %
  CHECK(play(forced(few, true), few, 40, {}).doubts.empty());
}

TEST_CASE("a frame without the host's result, or a loss, starts the half second anew") {
  for (const bool loss : {false, true}) {
    const ExactScene scene = crowd();
    Pipeline pipeline = forced(scene, true);
    for (int k = 0; k <= 24; ++k) {
      const testing::ExactFrame frame = scene.frame(k);
      CHECK(pipeline.before_pose(frame.view()).report.doubts == 0);
      if (k == 10 && loss) pipeline.lost();
      if (k != 10)
        pipeline.update_pose(k, scene.T_world_camera(k), PoseProvenance::Estimated, {{}, {}, 200, 0});
    }
  }
}

TEST_CASE("a crowd that moves is no reason to doubt, and verdicts are what they are without the check") {
  for (const testing::Preset which :
       {testing::Preset::Majority, testing::Preset::DelayedMajority, testing::Preset::SeveralMovers}) {
    const ExactScene scene = testing::preset(which).pixel_noise(0.3).depth_noise(0.0014).mismatches(0.03);
    const Played with = play(preset("dynfilter"), scene, 60, {});
    const Played without = play(preset("dynfilter"), scene, 60, {0, 0, PoseProvenance::Estimated});
    CHECK(with.doubts.empty());
    CHECK(with.decisions == without.decisions);
  }
  const ExactScene scene = crowd(400);
  CHECK(play(forced(scene, false), scene, 60, {}).doubts.empty());
}

TEST_CASE("who stands still in a box that is rejected whatever it does is no reason to doubt") {
  const ExactScene scene =
      ExactScene().mover(MovingBox(300).at({0, 0, 2.5}).half_size({0.9, 0.8, 0.2})).with_detections();
  Pipeline pipeline(pipeline_from_text(
      "pipeline:\n  before_pose:\n    any: [ { semantic_box: { role: reject } }, background_motion ]\n",
      builtin_filters()));
  const Played played = play(std::move(pipeline), scene, 40, {});
  CHECK(played.doubts.empty());
  const std::vector<Vote>& last = played.decisions.back();
  CHECK(10 * std::count(last.begin(), last.end(), Vote::Dynamic) > 3 * static_cast<int>(last.size()));
}

TEST_CASE(
    "the default pipeline takes a wall that moves for the background: a host that knows better is heard") {
  // Three quarters of the image are a far wall that moves, as a lorry does. The host follows the rest.
  const ExactScene scene =
      ExactScene()
          .points(220)
          .depth_range(2.0, 2.4)
          .camera_motion(testing::CameraStep::None)
          .mover(MovingBox(600).at({0, 0, 3.6}).half_size({2.6, 2, 0.3}).moving({0.03, 0, 0}))
          .pixel_noise(0.2);
  const Played played = play(preset("dynfilter"), scene, 40, {});
  MESSAGE("doubts: " << played.count);
  CHECK(played.count >= 1);
}

}  // namespace self_check_test
