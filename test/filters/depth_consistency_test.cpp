// SPDX-License-Identifier: MIT
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/depth_consistency.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>
#include <limits>
#include <utility>

#include "doctest/doctest.h"
#include "grid_scene.hpp"

namespace depth_consistency_test {

using namespace dynfilter;
using testing::CameraStep;
using testing::MovingBox;
using testing::Preset;
using testing::Score;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

DepthConsistencyParams params_for(DepthPrediction prediction, DepthForm form = DepthForm::Relative) {
  DepthConsistencyParams params;
  params.prediction = prediction;
  params.form = form;
  return params;
}
Score score(const testing::ExactScene& scene, const DepthConsistencyParams& params = {}, int frame = 8) {
  DepthConsistencyFilter filter(params);
  return Score(judge(filter, scene, frame), scene.frame(frame));
}

/// A wall at 3 m, a person at 1.8 m in columns `from` to `to`, a static camera.
/// Features on a 10 px grid.
struct Room {
  Room(int from, int to) : depth(110, 110, CV_32FC1, cv::Scalar(3)) {
    camera.fx_px = camera.fy_px = 100;
    camera.cx_px = camera.cy_px = 55;
    if (to > from) depth.colRange(from, to).setTo(1.8);
  }
  FrameView view(std::int64_t id, const std::vector<std::int32_t>& index) const {
    FrameView frame = grid.view(id);
    frame.detections.reset();
    frame.camera = camera;
    frame.depth = depth;
    if (id > 0) frame.matches = HostMatches{id - 1, index};
    return frame;
  }
  GridScene grid;
  Camera camera;
  cv::Mat depth;
};

/// Frames 0 and 1 of two rooms. Features on the person are not matched.
Votes second(const Room& before, const Room& now, DepthConsistencyParams params,
             std::string* note = nullptr) {
  std::vector<std::int32_t> index = GridScene::same();
  for (std::size_t i = 0; i < index.size(); ++i) {
    const cv::Point place(now.grid.keypoints[i].pt);
    if (now.depth.at<float>(place) < 2 || before.depth.at<float>(place) < 2) index[i] = -1;
  }
  DepthConsistencyFilter filter(params);
  FrameEvidence evidence;
  votes_of(filter, evidence, before.view(0, index));
  evidence.end(false);
  Votes votes = votes_of(filter, evidence, now.view(1, index));
  if (note != nullptr) *note = votes.notes();
  return votes;
}

/// A current frame at the origin, one keyframe 0.3 m to its left, and a feature 2 m ahead.
struct AtKeyframe {
  AtKeyframe() {
    camera.fx_px = camera.fy_px = 100;
    camera.cx_px = camera.cy_px = 50;
    keypoints.emplace_back(50.0F, 50.0F, 1.0F);
    depth_m = {2.0F};
    ids = {7};
    points_m = {{0, 0, 2}};
    keyframe.T_world_camera.translation_m = {-0.3, 0, 0};
    keyframe.id = 1;
  }
  Votes judge(DepthPrediction prediction, double max_deviation = 0.08) {
    FrameView frame;
    frame.keypoints = keypoints;
    frame.depth_m = depth_m;
    frame.camera = camera;
    frame.map_point_ids = ids;
    frame.map_points_world_m = points_m;
    frame.pose_provenance = PoseProvenance::Refined;
    keyframe.map_point_ids = keyframe_ids;
    keyframe.keypoints_undistorted = keyframe_keypoints;
    keyframe.depth_m = keyframe_depth_m;
    const std::vector<KeyframeView> keyframes(static_cast<std::size_t>(copies), keyframe);
    frame.covisible_keyframes = keyframes;
    DepthConsistencyParams params = params_for(prediction);
    params.against = DepthReference::Covisible;
    params.max_deviation = max_deviation;
    DepthConsistencyFilter filter(params);
    FrameEvidence evidence;
    return votes_of(filter, evidence, frame);
  }
  Camera camera;
  std::vector<cv::KeyPoint> keypoints, keyframe_keypoints;
  std::vector<float> depth_m, keyframe_depth_m;
  std::vector<std::int64_t> ids, keyframe_ids{7};
  std::vector<cv::Point3f> points_m;
  KeyframeView keyframe;
  int copies = 1;
};

}  // namespace

TEST_CASE("a rigid scene rejects nothing, whatever the camera does") {
  for (const CameraStep step : {CameraStep::General, CameraStep::Sideways, CameraStep::Forward,
                                CameraStep::PureRotation, CameraStep::SmallBaseline, CameraStep::None})
    for (const auto prediction : {DepthPrediction::Match, DepthPrediction::View, DepthPrediction::Both}) {
      const Score s = score(testing::ExactScene().camera_motion(step), params_for(prediction));
      CHECK(s.static_kept() >= 0.98);
      if (prediction == DepthPrediction::Match) CHECK(s.static_kept() == 1.0);
    }
}

// For a static camera d_proj is the last depth.
// The limit is 0.12: 1 - 2.26 / 2 = -0.13, 1 - 2.22 / 2 = -0.11.
TEST_CASE("equation 1 with its limit of 12 percent") {
  const auto moves = [](double step_m) {
    return testing::ExactScene()
        .points(150)
        .camera_motion(CameraStep::None)
        .mover(MovingBox(40).at({0, 0, 2 + step_m}).half_size({0.3, 0.3, 0.0}).moving({0, 0, -step_m}));
  };
  CHECK(score(moves(0.26), params_for(DepthPrediction::Match), 1).recall() == 1.0);
  CHECK(score(moves(0.22), params_for(DepthPrediction::Match), 1).recall() == 0.0);
  DepthConsistencyParams metric = params_for(DepthPrediction::Match, DepthForm::Metric);
  CHECK(score(moves(0.42), metric, 1).recall() == 1.0);
  CHECK(score(moves(0.38), metric, 1).recall() == 0.0);
}

TEST_CASE(
    "features that come before a wall are dynamic, what they uncover cannot be judged, the rest stays") {
  const Room before(20, 45), now(50, 75);
  for (const auto& params : {params_for(DepthPrediction::View), params_for(DepthPrediction::Both),
                             params_for(DepthPrediction::View, DepthForm::Metric)}) {
    const Votes votes = second(before, now, params);
    CHECK(votes[now.grid.at(60, 50)] == Vote::Dynamic);  // the wall was visible there
    CHECK(votes[now.grid.at(60, 20)] == Vote::Dynamic);
    CHECK(votes[now.grid.at(30, 50)] == Vote::Unknown);  // uncovered
    CHECK(votes[now.grid.at(90, 50)] == Vote::Static);
    CHECK(votes[now.grid.at(10, 50)] == Vote::Static);
  }
  const Votes still = second(before, before, {});
  CHECK(still.count(Vote::Dynamic) == 0);
}

// The person moves by 2 px: a patch with an edge abstains.
TEST_CASE("edges are told from motion by the patch") {
  const Room before(52, 80), now(49, 77);
  const std::size_t edge = now.grid.at(50, 50);
  CHECK(second(before, now, params_for(DepthPrediction::View))[edge] != Vote::Dynamic);
}

TEST_CASE("without its own depth image a view is asked through its keypoints") {
  const testing::ExactScene scene = testing::ExactScene()
                                        .points(3000)
                                        .camera_motion(CameraStep::None)
                                        .mover(MovingBox(60).at({0, 0, 1.6}).moving({0.12, 0, 0}));
  DepthConsistencyParams params = params_for(DepthPrediction::View);
  params.gap_frames = 3;
  const Score s = score(testing::ExactScene(scene).gap(3), params, 3);
  CHECK(s.dynamic_found > 3);
  CHECK(s.precision() >= 0.9);
}

TEST_CASE("equation 5 at keyframes: the map point's depth there against the reprojected one") {
  AtKeyframe at;
  CHECK(at.judge(DepthPrediction::Match)[0] == Vote::Static);
  at.points_m = {{0, 0, 2.2F}};  // |2.2 - 2| / 2.2 = 0.091
  CHECK(at.judge(DepthPrediction::Match)[0] == Vote::Dynamic);
  CHECK(at.judge(DepthPrediction::Match, 0.095)[0] == Vote::Static);
  at.points_m = {{0, 0, 2.15F}};  // 0.0698
  CHECK(at.judge(DepthPrediction::Match)[0] == Vote::Static);
  at.keyframe_ids = {8, 3};  // the keyframe does not observe it
  CHECK(at.judge(DepthPrediction::Match)[0] == Vote::Unknown);
}

// (0, 0, 2) viewed from 0.3 m to the left: u = 50 + 100 * 0.3 / 2 = 65.
TEST_CASE("a feature without a map point: what the keyframe saw at its place") {
  AtKeyframe at;
  at.ids = {-1};
  const auto saw = [&](float z1, float z2) {
    at.keyframe_keypoints = {{63.0F, 50.0F, 1.0F}, {67.0F, 51.0F, 1.0F}, {20.0F, 20.0F, 1.0F}};
    at.keyframe_depth_m = {z1, z2, 1.0F};
    return at.judge(DepthPrediction::View)[0];
  };
  CHECK(saw(2.0F, 3.0F) == Vote::Static);
  CHECK(saw(3.0F, 3.1F) == Vote::Dynamic);
  CHECK(saw(1.0F, 3.0F) == Vote::Unknown);                // an edge
  CHECK(saw(1.0F, 1.0F) == Vote::Unknown);                // hidden
  CHECK(saw(kNan, 3.0F) == Vote::Unknown);                // a single depth does not decide
  at.keyframe.T_world_camera.translation_m = {-2, 0, 0};  // 45 degrees
  CHECK(saw(3.0F, 3.0F) == Vote::Unknown);
}

TEST_CASE("poses that are not rigid, empty arrays and numbers that are none: unknown") {
  AtKeyframe at;
  at.points_m = {{0, 0, 3}};
  at.copies = 3;
  CHECK(at.judge(DepthPrediction::Both)[0] == Vote::Dynamic);
  const Pose good = at.keyframe.T_world_camera;
  at.keyframe.T_world_camera.rotation[4] = -1;  // a reflection
  CHECK(at.judge(DepthPrediction::Both)[0] == Vote::Unknown);
  at.keyframe.T_world_camera = good;
  at.keyframe.T_world_camera.translation_m[0] = std::numeric_limits<double>::quiet_NaN();
  CHECK(at.judge(DepthPrediction::Both)[0] == Vote::Unknown);
  at.keyframe.T_world_camera = good;
  at.points_m = {{kNan, kNan, kNan}};
  CHECK(at.judge(DepthPrediction::Both)[0] == Vote::Unknown);
  at.points_m = {{0, 0, 3}};
  at.depth_m = {kNan};
  CHECK(at.judge(DepthPrediction::Both)[0] == Vote::Unknown);
  at.depth_m = {2.0F};
  at.keyframe_keypoints = {{63.0F, 50.0F, 1.0F}};  // depths for another number of keypoints
  at.keyframe_depth_m = {3.0F, 3.0F};
  CHECK(at.judge(DepthPrediction::View)[0] == Vote::Unknown);
  at.copies = 0;
  CHECK(at.judge(DepthPrediction::Both)[0] == Vote::Unknown);
}

TEST_CASE("no depth, too few points, the first frame, identical and collinear features: unknown") {
  const auto all_unknown = [&](const testing::ExactScene& scene, int frame) {
    DepthConsistencyFilter filter;
    const Votes votes = judge(filter, scene, frame);
    return votes.count(Vote::Unknown) == votes.size();
  };
  CHECK(all_unknown(testing::preset(Preset::General).missing_depth(1), 4));
  for (const int n : {1, 2}) CHECK(all_unknown(testing::ExactScene().points(n), 4));
  for (const bool line : {false, true}) {
    Room room(0, 0);
    for (std::size_t i = 0; i < 81; ++i)
      room.grid.keypoints[i].pt = {line ? static_cast<float>(i) : 40.0F, 50.0F};
    std::string note;
    CHECK(second(room, room, {}, &note).count(Vote::Dynamic) == 0);
  }
}

TEST_CASE(
    "NaN, zero and negative depths, keypoints on and beyond the edge are left out, permuting permutes") {
  const Room before(20, 45);
  Room now(50, 75);
  now.depth.at<float>(50, 90) = 0;
  now.depth(cv::Rect(86, 16, 9, 9)).setTo(kNan);
  now.depth(cv::Rect(86, 66, 9, 9)).setTo(-1);
  now.grid.keypoints[0].pt = {110, 110};
  now.grid.keypoints[1].pt = {kNan, 20};
  now.grid.keypoints[2].pt = {-1e30F, 1e30F};
  // second() uses pixels: no match for the odd features.
  Room odd = now;
  std::vector<std::int32_t> index = GridScene::same();
  for (int i = 0; i < 3; ++i) index[static_cast<std::size_t>(i)] = -1;
  DepthConsistencyFilter filter;
  FrameEvidence evidence;
  votes_of(filter, evidence, before.view(0, index));
  evidence.end(false);
  const Votes votes = votes_of(filter, evidence, odd.view(1, index));
  CHECK(votes[1] == Vote::Unknown);
  CHECK(votes[2] == Vote::Unknown);
  CHECK(votes[now.grid.at(90, 20)] == Vote::Unknown);
  CHECK(votes[now.grid.at(90, 70)] == Vote::Unknown);

  std::reverse(odd.grid.keypoints.begin(), odd.grid.keypoints.end());
  std::reverse(index.begin(), index.end());
  filter.reset();
  evidence.reset();
  votes_of(filter, evidence, before.view(0, index));
  evidence.end(false);
  const Votes turned = votes_of(filter, evidence, odd.view(1, index));
  int different = 0;
  for (std::size_t i = 0; i < 81; ++i) different += turned[80 - i] != votes[i];
  CHECK(different == 0);
}

TEST_CASE("other image sizes") {
  for (const cv::Size size : {cv::Size(1241, 376), cv::Size(752, 480), cv::Size(320, 240)}) {
    Camera camera = testing::ExactScene().camera();
    camera.width_px = size.width;
    camera.height_px = size.height;
    camera.cx_px = size.width / 2.0;
    camera.cy_px = size.height / 2.0;
    const Score s = score(testing::ExactScene().camera(camera).mover(
                              MovingBox(60).at({0, 0, 4}).moving({0, 0, -0.6}).half_size({0.3, 0.3, 0.1})),
                          {}, 3);
    CHECK(s.recall() >= 0.8);
    CHECK(s.static_kept() >= 0.97);
  }
}

}  // namespace depth_consistency_test
