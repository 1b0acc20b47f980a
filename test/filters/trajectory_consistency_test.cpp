// SPDX-License-Identifier: MIT
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/camera_motion.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/trajectory_consistency.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>
#include <limits>
#include <string>
#include <utility>

#include "doctest/doctest.h"
#include "filters/matched_frames.hpp"

namespace trajectory_consistency_test {

using namespace dynfilter;
using matched_frames::MatchedFrames;
using matched_frames::votes_of;
using testing::CameraStep;
using testing::MovingBox;
using testing::Preset;
using testing::Score;

namespace {

TrajectoryConsistencyParams displacement() {
  TrajectoryConsistencyParams params;
  params.mode = TrajectoryMode::Displacement;
  params.threshold = TrajectoryThreshold::Metric;
  return params;
}
TrajectoryConsistencyParams metric() {
  TrajectoryConsistencyParams params;
  params.threshold = TrajectoryThreshold::Metric;
  return params;
}
TrajectoryConsistencyParams measured() {
  TrajectoryConsistencyParams params;
  params.measured_noise = true;
  return params;
}
Score score(const testing::ExactScene& scene, const TrajectoryConsistencyParams& params = {}, int frame = 8) {
  TrajectoryConsistencyFilter filter(params);
  return Score(judge(filter, scene, frame), scene.frame(frame));
}
/// Both keypoints of a match have 1.5 px of noise, so the match has 2.1 px, as in a blurred frame.
testing::ExactScene blurred(testing::ExactScene scene) {
  return scene.points(800).pixel_noise(1.5);
}

}  // namespace

TEST_CASE("a rigid scene rejects nothing, whatever the camera does") {
  for (const CameraStep step : {CameraStep::General, CameraStep::Sideways, CameraStep::Forward,
                                CameraStep::PureRotation, CameraStep::SmallBaseline, CameraStep::None})
    for (const auto& params : {TrajectoryConsistencyParams(), metric()})
      CHECK(score(testing::ExactScene().camera_motion(step), params).static_kept() == 1.0);
}

TEST_CASE("movers are found in every geometry, also where epipolar lines say nothing") {
  for (const Preset preset : {Preset::General, Preset::Planar, Preset::PureRotation, Preset::NoMotion,
                              Preset::SmallBaseline, Preset::AlongEpipolar, Preset::SeveralMovers}) {
    CAPTURE(testing::to_string(preset));
    const Score exact = score(testing::preset(preset));
    CHECK(exact.recall() >= 0.9);
    CHECK(exact.static_kept() == 1.0);
  }
}

TEST_CASE("with the noise of a Kinect static features stay and a mover goes") {
  const Score s = score(testing::preset(Preset::General).pixel_noise(0.3).depth_noise(0.0014));
  CHECK(s.static_kept() >= 0.95);
  CHECK(s.recall() >= 0.9);
}

// A static point at depth z moves by 2 z sin(a / 2) under a rotation by a, while |t| = 0.
// At 3 m and 0.69 degrees these are 36 mm, beyond alpha + beta z = 24 mm.
TEST_CASE(
    "the published displacement form rejects static points when the camera turns; the rigid one does not") {
  const testing::ExactScene turning = testing::preset(Preset::Rigid).camera_motion(CameraStep::PureRotation);
  CHECK(score(turning, displacement()).static_kept() < 0.5);
  CHECK(score(turning, metric()).static_kept() == 1.0);
}

// | |P_t - P_r| - |t| | with P_r = (0, 0, 2) m, P_t = (0.1, 0, 2), |t| = 0.03.
// 0.07 m > 0.015 + 0.003 * 2 = 0.021 m.
TEST_CASE("displacement mode is equation 14, with the host's translation") {
  TrajectoryConsistencyParams params = displacement();
  params.motion = MotionSource::Host;
  const auto scene = [](double speed) {
    return testing::ExactScene()
        .points(100)
        .camera_motion(CameraStep::Sideways)
        .with_poses()
        .mover(MovingBox(30).at({0, 0, 2}).moving({0.03 + speed, 0, 0}));
  };
  // `speed` is the mover's motion relative to the camera. Static points move by 0.03 the other way.
  CHECK(score(scene(0.1), params).recall() == 1.0);    // |0.1 - 0.03| = 0.07
  CHECK(score(scene(0.045), params).recall() == 0.0);  // |0.045 - 0.03| = 0.015
  CHECK(score(scene(0.1), params).static_kept() == 1.0);
}

TEST_CASE("the motion comes from where it is told") {
  TrajectoryConsistencyParams params;
  params.motion = MotionSource::Host;
  const Score without_pose = score(testing::preset(Preset::General), params);
  CHECK(without_pose.dynamic_found == 0);  // abstains
  CHECK(without_pose.static_confirmed == 0);
  // Two movers have most of the points. A fit on all points gives their motion.
  // The host's pose is correct.
  const Score told = score(testing::preset(Preset::Majority).with_poses(), params, 18);
  CHECK(told.recall() >= 0.9);
  CHECK(told.static_kept() >= 0.99);
}

TEST_CASE("a predicted motion of the host keeps most features on movers from taking the motion over") {
  const Score s = score(testing::preset(Preset::Majority).with_poses(PoseProvenance::Predicted), {}, 18);
  CHECK(s.recall() >= 0.9);
  CHECK(s.static_kept() >= 0.95);
}

// The assumed 0.6 px allow misses of up to sqrt(16) * 0.6 = 2.4 px, and depths that fit.
// exp(-(2.4 / 2.12)^2 / 2) = 53 % of the static matches miss by more.
TEST_CASE("blurred matches make a static scene dynamic under the assumed noise, not under the measured one") {
  const testing::ExactScene scene = blurred(testing::preset(Preset::Rigid));
  CHECK(score(scene).static_kept() < 0.55);
  const Score s = score(scene, measured());
  CHECK(s.static_kept() >= 0.99);
  CHECK(s.static_confirmed >= 0.95 * s.static_count);  // it does not abstain
}

// 4 sigma = 8.5 px. At 2.5 m the mover's 0.14 m per frame are 30 px.
TEST_CASE("a mover well above the measured noise is still found") {
  const testing::ExactScene scene =
      blurred(testing::ExactScene().mover(MovingBox(100).at({-0.6, -0.5, 2.5}).moving({0.1, 0.1, 0})));
  const Score s = score(scene, measured(), 4);
  REQUIRE(s.dynamic_count >= 50);
  CHECK(s.recall() >= 0.95);
  CHECK(s.static_kept() >= 0.98);
}

// The neighbours on a mover agree on where it moves, so its motion is no noise.
TEST_CASE("movers do not raise the measured noise: sharp frames are judged as without the option") {
  for (const Preset preset : testing::all_presets()) {
    CAPTURE(testing::to_string(preset));
    const testing::ExactScene scene = testing::preset(preset).pixel_noise(0.1).with_poses();
    TrajectoryConsistencyParams fixed = measured(), option = measured();
    fixed.motion = option.motion = MotionSource::Host;
    fixed.measured_noise = false;
    TrajectoryConsistencyFilter a(fixed), b(option);
    const Votes without = judge(a, scene, 18), with = judge(b, scene, 18);
    for (std::size_t i = 0; i < without.size(); ++i) CHECK(with[i] == without[i]);
  }
}

TEST_CASE("errors of the depths alone raise the noise of the depths") {
  // Both depths have 3 % of noise at 1 m and more behind: 15 times the model's, at 2 m.
  const testing::ExactScene scene = testing::preset(Preset::Rigid).points(600).depth_noise(0.015);
  CHECK(score(scene).static_kept() < 0.8);
  CHECK(score(scene, measured()).static_kept() > score(scene).static_kept() + 0.1);
}

TEST_CASE("with fewer than 20 pairs of neighbours the assumed noise counts, and the report says so") {
  const testing::ExactScene scene = testing::ExactScene().points(15).pixel_noise(0.1);
  const testing::ExactFrame before = scene.frame(3), now = scene.frame(4);
  const auto votes_and_note = [&](const TrajectoryConsistencyParams& params) {
    TrajectoryConsistencyFilter filter(params);
    FrameEvidence evidence;
    Votes votes;
    std::string note;
    for (const testing::ExactFrame* frame : {&before, &now}) {
      evidence.begin(frame->view(), CallPoint::BeforePose);
      votes.reset(frame->size());
      filter.apply(evidence, votes);
      note = votes.notes();
      evidence.end(false);
    }
    return std::make_pair(votes, note);
  };
  const auto [fixed, fixed_note] = votes_and_note({});
  const auto [votes, note] = votes_and_note(measured());
  REQUIRE(fixed.count(Vote::Static) >= 10);
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    CHECK(votes[i] == fixed[i]);
    CHECK(votes.suspicion(i) == fixed.suspicion(i));
  }
  CHECK(fixed_note.find("noise") == std::string::npos);
  CHECK(note.find("noise: not measured, too few neighbours") != std::string::npos);
}

TEST_CASE("no depth, too far, no match, too few points: unknown") {
  TrajectoryConsistencyFilter filter;
  const auto all_unknown = [&](const testing::ExactScene& scene, int frame) {
    const Votes votes = judge(filter, scene, frame);
    return votes.count(Vote::Unknown) == votes.size();
  };
  CHECK(all_unknown(testing::preset(Preset::General).missing_depth(1), 4));
  CHECK(all_unknown(testing::preset(Preset::General).missing_matches(1), 4));
  CHECK(all_unknown(testing::ExactScene().points(3), 4));
  CHECK(all_unknown(testing::ExactScene().points(200).depth_range(7, 7.5), 4));
}

TEST_CASE("zero, negative, NaN and infinite depths are none") {
  const testing::ExactScene scene = testing::ExactScene().points(100);
  TrajectoryConsistencyFilter filter;
  FrameEvidence evidence;
  Votes votes;
  constexpr float kOdd[] = {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity()};
  for (int k = 0; k < 2; ++k) {
    testing::ExactFrame frame = scene.frame(k);
    for (std::size_t i = 0; i < 4; ++i) frame.depth_m[i] = kOdd[i];
    evidence.begin(frame.view(), CallPoint::BeforePose);
    votes.reset(frame.size());
    filter.apply(evidence, votes);
    evidence.end(false);
  }
  for (std::size_t i = 0; i < 4; ++i) CHECK(votes[i] == Vote::Unknown);
  CHECK(votes.count(Vote::Static) > 50);
}

TEST_CASE("less than d1 is static, more than the cap unknown, between dynamic") {
  // 30 static features at 2 m and three that move by 1, 6 and 30 cm: 5, 30, 150 px.
  // The camera is static.
  MatchedFrames frames;
  frames.camera.fx_px = frames.camera.fy_px = 1000;
  frames.camera.cx_px = 320, frames.camera.cy_px = 240;
  for (int k = 0; k < 30; ++k) {
    const cv::Point2f p(20.0F + static_cast<float>(k % 6) * 100, 30.0F + static_cast<float>(k / 6) * 90);
    frames.add(p, p);
  }
  for (const float moved_px : {5.0F, 30.0F, 150.0F}) frames.add({300, 200}, {300 + moved_px, 200});
  for (std::size_t i = 0; i < frames.now.size(); ++i)
    frames.depth_m.push_back(i < 30 ? 2.0F + 0.1F * static_cast<float>(i % 5) : 2.0F);
  for (const TrajectoryThreshold threshold : {TrajectoryThreshold::Metric, TrajectoryThreshold::Noise}) {
    TrajectoryConsistencyParams params;
    params.threshold = threshold;
    params.alpha_m = 0.02, params.beta = 0;  // d1
    params.max_displacement_m = 0.1;
    TrajectoryConsistencyFilter filter(params);
    const Votes votes = votes_of(filter, frames);
    const bool metric = threshold == TrajectoryThreshold::Metric;  // 5 px are more than the noise
    CHECK(votes.count(Vote::Static) == (metric ? 31 : 30));
    CHECK(votes[30] == (metric ? Vote::Static : Vote::Dynamic));
    CHECK(votes[31] == Vote::Dynamic);
    CHECK(votes[32] == Vote::Unknown);
  }
}

}  // namespace trajectory_consistency_test
