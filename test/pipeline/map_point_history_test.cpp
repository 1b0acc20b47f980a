// SPDX-License-Identifier: MIT
#include <dynfilter/pipeline/map_point_history.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/pipeline/stage.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "doctest/doctest.h"
#include "pipeline/fakes.hpp"

namespace map_point_history_test {

using namespace dynfilter;
using testing::ExactFrame;
using testing::ExactScene;
using testing::MovingBox;

ExactScene two_people() {
  return ExactScene()
      .pixel_noise(0.2)
      .depth_noise(0.0014)
      .mover(MovingBox(60).at({-0.6, 0, 2.5}).moving({0.02, 0, 0.01}))
      .mover(MovingBox(60).at({0.7, 0, 2.8}).moving({-0.02, 0.01, 0}));
}

Pipeline dynfilter_preset() {
  return Pipeline(pipeline_from_file(std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/dynfilter.yaml",
                                     builtin_filters()));
}

/// As an ORB-SLAM: it makes map points of all features of frame 0. Later it finds those of the static scene
/// among the features that were kept. A map point's id is the number of its point.
class Host {
 public:
  explicit Host(const ExactScene& scene) : scene_(scene) {}

  const Verdict& track(Pipeline& pipeline, int k) {
    const ExactFrame frame = scene_.frame(k);
    const Verdict& verdict = pipeline.before_pose(frame.view());
    std::vector<cv::KeyPoint> kept;
    std::vector<std::int64_t> ids;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      if (!verdict.keep(i)) continue;
      kept.push_back(frame.keypoints[i]);
      ids.push_back(k == 0 || frame.label[i] == 0 ? frame.point[i] : -1);
    }
    pipeline.update_pose(k, scene_.T_world_camera(k), PoseProvenance::Estimated, {kept, ids, kept.size(), 0});
    return verdict;
  }

 private:
  const ExactScene& scene_;
};

/// Static points of these scenes float in space, so that a mover sweeps some along: 2 % may be.
void check_first_frame(const Pipeline& pipeline, const ExactFrame& first, double least_share) {
  int people = 0, found = 0, wrong = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const bool moved = pipeline.map_point(first.point[i]).vote == Vote::Dynamic;
    (first.label[i] != 0 ? found : wrong) += moved ? 1 : 0;
    people += first.label[i] != 0 ? 1 : 0;
  }
  MESSAGE(found << " of " << people << " map points on people, and " << wrong << " others");
  CHECK(found >= least_share * people);
  CHECK(50 * wrong <= static_cast<int>(first.size()) - people);
  CHECK(static_cast<int>(pipeline.moved_map_points().size()) == found + wrong);
}

TEST_CASE("people of the first frame: their map points have moved after a second, the others have not") {
  for (const double rate_hz : {10.0, 30.0, 60.0}) {
    CAPTURE(rate_hz);
    const double step = 30 / rate_hz;
    const ExactScene scene =
        ExactScene()
            .pixel_noise(0.2)
            .depth_noise(0.0014)
            .rate_hz(rate_hz)
            .camera_motion(testing::CameraStep::SmallBaseline)
            .mover(MovingBox(60).at({-0.6, 0, 2.5}).moving({0.02 * step, 0, 0.01 * step}))
            .mover(MovingBox(60).at({0.7, 0, 2.8}).moving({-0.02 * step, 0.01 * step, 0}));
    Pipeline pipeline = dynfilter_preset();
    Host host(scene);
    for (int k = 0; k <= static_cast<int>(rate_hz); ++k) host.track(pipeline, k);
    check_first_frame(pipeline, scene.frame(0), 0.8);
  }
}

TEST_CASE("a point whose feature has no match goes on with the features around it") {
  const ExactScene scene = two_people().missing_matches(0.4).order(7);
  Pipeline pipeline = dynfilter_preset();
  Host host(scene);
  for (int k = 0; k <= 24; ++k) host.track(pipeline, k);
  // By its own features alone, one point of 100 would be left after 9 frames.
  check_first_frame(pipeline, scene.frame(0), 0.7);
}

TEST_CASE("at a keyframe, verdicts on map points are those of all frames, and features are left alone") {
  const ExactScene scene = two_people().with_map_points();
  Pipeline pipeline = dynfilter_preset();
  for (int k = 0; k < 30; ++k) {
    const ExactFrame frame = scene.frame(k);
    pipeline.before_pose(frame.view());
  }
  const ExactFrame frame = scene.frame(29);
  const Verdict& verdict = pipeline.at_keyframe(frame.view());
  REQUIRE(verdict.map_points.size() == frame.size());
  CHECK(verdict.report.rejected == 0);
  int moved = 0, people = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const MapPointVerdict& point = verdict.map_points[i];
    CHECK(point.map_point_id == frame.point[i]);
    CHECK(point.vote == pipeline.map_point(frame.point[i]).vote);
    moved += point.vote == Vote::Dynamic ? 1 : 0;
    people += frame.label[i] != 0 ? 1 : 0;
    CHECK((point.vote != Vote::Dynamic || frame.label[i] != 0));
  }
  CHECK(people > 20);
  CHECK(moved == people);
}

TEST_CASE("a pipeline with a stage at keyframes is what it was: that stage judges map points") {
  const ExactScene scene = two_people().with_map_points();
  Pipeline pipeline(pipeline_from_text(
      "pipeline:\n  before_pose: [ background_motion ]\n  at_keyframe: [ background_motion ]\n",
      builtin_filters()));
  for (int k = 0; k < 10; ++k) {
    const ExactFrame frame = scene.frame(k);
    pipeline.before_pose(frame.view());
    const Verdict& verdict = pipeline.at_keyframe(frame.view());
    for (std::size_t i = 0; i < frame.size(); ++i) {
      CHECK(verdict.map_points[i].vote == verdict.decision[i]);
      CHECK(verdict.map_points[i].suspicion == verdict.suspicion[i]);
    }
  }
}

/// A pipeline that says the same in every frame, with the features as fakes::Features has them.
Pipeline saying(const std::string& letters) {
  PipelineConfig config;
  config.before_pose.reset(new FilterStage(fakes::says("script", letters), "before_pose"));
  return Pipeline(std::move(config));
}

TEST_CASE("Bayes' rule: log-odds add up by time, within bounds, one vote a frame") {
  for (const double rate_hz : {10.0, 30.0, 60.0}) {
    CAPTURE(rate_hz);
    Pipeline pipeline = saying("DSUDD");
    const fakes::Features features(5);
    const std::vector<std::int64_t> ids{10, 11, 12, 13, 13};
    const double dynamic = std::log(0.7 / 0.03), fixed = std::log(0.3 / 0.97), first = std::log(0.05 / 0.95);
    const auto expect = [&](std::int64_t id, double log_odds) {
      const MapPointVerdict verdict = pipeline.map_point(id);
      CHECK(verdict.suspicion == doctest::Approx(1 / (1 + std::exp(-log_odds / 2))).epsilon(0.002));
      CHECK(verdict.vote == (log_odds > std::log(4.0) ? Vote::Dynamic
                             : log_odds < first       ? Vote::Static
                                                      : Vote::Unknown));
    };
    // A stamp is missing before the first frame: it counts for 1/30 s.
    double observations = 0;
    for (int k = 0; k <= rate_hz; ++k) {
      FrameView view = features.view(k);
      view.timestamp_s = k / rate_hz;
      view.map_point_ids = ids;
      pipeline.before_pose(view);
      observations += (k == 0 ? 1.0 / 30 : 1 / rate_hz) / 0.2;
      expect(10, std::min(4.0, first + observations * dynamic));
      expect(11, std::max(-4.0, first + observations * fixed));
      expect(13, std::min(4.0, first + observations * dynamic));
    }
    CHECK(pipeline.map_point(12).vote == Vote::Unknown);  // nothing was said of it
    CHECK(pipeline.map_point(12).suspicion == Votes::kNoIdea);
    CHECK(pipeline.moved_map_points() == std::vector<std::int64_t>{10, 13});
  }
}

TEST_CASE("a loss of the host keeps map points, a reset forgets them") {
  const ExactScene scene = two_people();
  Pipeline pipeline = dynfilter_preset();
  Host host(scene);
  for (int k = 0; k < 30; ++k) host.track(pipeline, k);
  const std::vector<std::int64_t> moved = pipeline.moved_map_points();
  CHECK(moved.size() > 60);
  pipeline.lost();
  CHECK(pipeline.moved_map_points() == moved);
  pipeline.reset();
  CHECK(pipeline.moved_map_points().empty());
}

TEST_CASE("a loss forgets the poses of earlier frames, and what images say goes on") {
  const ExactScene scene = two_people();
  const auto last = [&](bool poses, bool loss) {
    Pipeline pipeline = dynfilter_preset();
    for (int k = 0; k < 8; ++k) {
      const ExactFrame frame = scene.frame(k);
      pipeline.before_pose(frame.view());
      if (poses)
        pipeline.update_pose(k, Pose::from(Eigen::Matrix3d::Identity(), {9.0 * k, 0, 0}),
                             PoseProvenance::Estimated);
    }
    if (loss) pipeline.lost();
    const ExactFrame frame = scene.frame(8);
    FrameView view = frame.view();
    view.T_world_camera = Pose(), view.pose_provenance = PoseProvenance::Predicted;
    return pipeline.before_pose(view).decision;
  };
  const std::vector<Vote> after = last(true, true);
  CHECK(std::count(after.begin(), after.end(), Vote::Dynamic) > 0);
  CHECK(after == last(false, false));  // as if the host had never said a pose
}

TEST_CASE("ids from any thread while frames are judged; ids of another frame or of other keypoints") {
  const ExactScene scene = two_people();
  Pipeline pipeline = dynfilter_preset();
  Host host(scene);
  host.track(pipeline, 0);
  std::thread reader([&] {
    for (int n = 0; n < 2000; ++n) pipeline.map_point(n % 400), pipeline.moved_map_points();
  });
  for (int k = 1; k < 10; ++k) host.track(pipeline, k);
  reader.join();
  const std::vector<cv::KeyPoint> elsewhere(3, cv::KeyPoint(-5, -5, 1));
  const std::vector<std::int64_t> ids{9001, 9002, 9003};
  pipeline.update_pose(9, Pose(), PoseProvenance::Estimated, {elsewhere, ids, 0, 0});
  pipeline.update_pose(3, Pose(), PoseProvenance::Estimated, {elsewhere, ids, 0, 0});
  pipeline.update_pose(9, Pose(), PoseProvenance::Estimated, {elsewhere, {ids.data(), 2}, 0, 0});
  for (int k = 10; k < 13; ++k) host.track(pipeline, k);
  for (const std::int64_t id : ids) CHECK(pipeline.map_point(id).suspicion == Votes::kNoIdea);
}

}  // namespace map_point_history_test
