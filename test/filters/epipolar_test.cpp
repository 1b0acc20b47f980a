// SPDX-License-Identifier: MIT
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/epipolar.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>
#include <limits>
#include <map>

#include "doctest/doctest.h"

namespace epipolar_test {

using namespace dynfilter;
using testing::Preset;
using testing::Score;

namespace {

Score score(const testing::ExactScene& scene, const EpipolarParams& params = {}, int frame = 8) {
  EpipolarFilter filter(params);
  return Score(judge(filter, scene, frame), scene.frame(frame));
}

}  // namespace

TEST_CASE("a rigid scene rejects nothing, a known mover is found") {
  CHECK(score(testing::preset(Preset::Rigid)).static_kept() == 1.0);
  const Score exact = score(testing::preset(Preset::General));
  CHECK(exact.recall() >= 0.95);
  CHECK(exact.static_kept() == 1.0);
  const Score noisy = score(testing::preset(Preset::General).pixel_noise(0.3));
  CHECK(noisy.recall() >= 0.9);
  CHECK(noisy.static_kept() >= 0.95);
}

TEST_CASE("degenerate scenes never cost static features in bulk, and movers are not called static") {
  for (const Preset preset :
       {Preset::Planar, Preset::PureRotation, Preset::NoMotion, Preset::SmallBaseline}) {
    CAPTURE(testing::to_string(preset));
    const Score s = score(testing::preset(preset).points(600).pixel_noise(0.2));
    CHECK(s.static_kept() >= 0.97);
    CHECK(s.dynamic_missed <= s.dynamic_count / 10);
  }
}

namespace {
EpipolarParams measured() {
  EpipolarParams params;
  params.measured_noise = true;
  return params;
}
}  // namespace

// Both keypoints of a match have 1.5 px of noise, as in a blurred frame. The distance from the line has about
// 2.1 px, of which 64 % exceed 1 px; next to none exceed three standard deviations.
TEST_CASE("blurred matches make a static scene dynamic by a fixed limit, not by the measured one") {
  for (const Preset preset : {Preset::Rigid, Preset::PureRotation}) {
    CAPTURE(testing::to_string(preset));
    const testing::ExactScene scene = testing::preset(preset).points(800).pixel_noise(1.5);
    CHECK(score(scene).static_kept() < 0.6);
    const Score s = score(scene, measured());
    CHECK(s.static_kept() >= 0.98);
    CHECK(s.static_confirmed >= 0.95 * s.static_count);  // it does not abstain
  }
}

// Limit: 3 times 2.1 px = 6.4 px. At 2.5 m the mover's 0.1 m per frame across the lines are 21 px.
TEST_CASE("a mover well above the measured noise is still found") {
  const testing::ExactScene scene =
      testing::ExactScene()
          .points(800)
          .pixel_noise(1.5)
          .camera_motion(testing::CameraStep::Sideways)
          .mover(testing::MovingBox(100).at({-0.3, -0.5, 2.5}).moving({0, 0.1, 0}));
  const Score s = score(scene, measured(), 4);
  REQUIRE(s.dynamic_count >= 50);
  CHECK(s.recall() >= 0.95);
  CHECK(s.static_kept() >= 0.97);
}

// The neighbours on a mover agree on where it moves, so its motion is no noise. Without depths, neighbours
// count across a mover's outline, so most of the pairs must be on one object.
TEST_CASE("movers do not raise the measured noise: sharp frames are judged as without the option") {
  for (const Preset preset : testing::all_presets()) {
    if (preset == Preset::Majority || preset == Preset::DelayedMajority) continue;
    CAPTURE(testing::to_string(preset));
    const testing::ExactScene scene = testing::preset(preset).pixel_noise(0.05);
    EpipolarFilter a, b(measured());
    const Votes without = judge(a, scene, 18), with = judge(b, scene, 18);
    for (std::size_t i = 0; i < without.size(); ++i) {
      CHECK(with[i] == without[i]);
      CHECK(with.suspicion(i) == without.suspicion(i));
    }
  }
}

TEST_CASE("the published form judges every match, by its distance from the epipolar line alone") {
  EpipolarParams params;
  params.model = EpipolarModel::Fundamental;
  CHECK(score(testing::preset(Preset::Rigid), params).static_kept() == 1.0);
  const Score general = score(testing::preset(Preset::General), params);
  CHECK(general.recall() >= 0.95);
  CHECK(general.static_kept() == 1.0);
  EpipolarFilter filter(params);
  const testing::ExactScene scene = testing::preset(Preset::General).pixel_noise(0.3);
  const Votes votes = judge(filter, scene, 8);
  const testing::ExactFrame frame = scene.frame(8);
  const FrameView view = frame.view();
  REQUIRE(view.matches.has_value());
  REQUIRE(votes.count(Vote::Dynamic) > 0);
  for (std::size_t i = 0; i < votes.size(); ++i)
    CHECK((votes[i] != Vote::Unknown) == (view.matches->reference_index[i] >= 0));
}

// A camera that only turns has no fundamental matrix: `auto` compares with the point that the rotation
// predicts.
TEST_CASE("by any model only with `auto`, else by the fundamental matrix") {
  const auto turning = [](EpipolarModel model) {
    EpipolarParams params;
    params.model = model;
    EpipolarFilter filter(params);
    const Votes votes = judge(filter, testing::preset(Preset::PureRotation).points(600).pixel_noise(0.2), 8);
    return votes.size() - votes.count(Vote::Unknown);
  };
  CHECK(turning(EpipolarModel::Auto) > 500);
  CHECK(turning(EpipolarModel::Fundamental) == 0);
}

TEST_CASE("with fewer than 20 pairs of neighbours max_distance_px counts as it is") {
  const testing::ExactScene scene = testing::ExactScene().points(30).pixel_noise(1.5);
  EpipolarFilter a, b(measured());
  const Votes without = judge(a, scene, 4), with = judge(b, scene, 4);
  REQUIRE(without.count(Vote::Unknown) < without.size());
  for (std::size_t i = 0; i < without.size(); ++i) {
    CHECK(with[i] == without[i]);
    CHECK(with.suspicion(i) == without.suspicion(i));
  }
}

TEST_CASE("motion along the epipolar line is what it cannot see: the card says so") {
  CHECK(score(testing::preset(Preset::AlongEpipolar)).recall() < 0.5);
}

TEST_CASE("the order of features does not matter") {
  const testing::ExactScene a = testing::preset(Preset::General).order(1),
                            b = testing::preset(Preset::General).order(7);
  EpipolarFilter filter;
  const Votes va = judge(filter, a, 8), vb = judge(filter, b, 8);
  const auto fa = a.frame(8), fb = b.frame(8);
  std::map<int, Vote> by_point;
  for (std::size_t i = 0; i < va.size(); ++i) by_point[fa.point[i]] = va[i];
  for (std::size_t i = 0; i < vb.size(); ++i) CHECK(by_point.at(fb.point[i]) == vb[i]);
}

TEST_CASE("without correspondences or enough seeds it abstains") {
  EpipolarFilter filter;
  for (const int points : {0, 1, 6, 7, 15}) {
    const Votes votes = judge(filter, testing::ExactScene().points(points), 3);
    CHECK(votes.count(Vote::Unknown) == votes.size());
  }
  const Votes lost = judge(filter, testing::preset(Preset::General).missing_matches(1), 4);
  CHECK(lost.count(Vote::Unknown) == lost.size());
}

TEST_CASE("NaN keypoints abstain, whatever the model") {
  EpipolarFilter filter;
  const testing::ExactScene scene = testing::preset(Preset::General);
  FrameEvidence evidence;
  Votes votes;
  for (int k = 0; k < 2; ++k) {
    testing::ExactFrame frame = scene.frame(k);
    frame.keypoints_undistorted = frame.keypoints;
    frame.keypoints_undistorted[0].pt = {std::numeric_limits<float>::quiet_NaN(), 3};
    evidence.begin(frame.view(), CallPoint::BeforePose);
    votes.reset(frame.size());
    filter.apply(evidence, votes);
    evidence.end(false);
  }
  CHECK(votes[0] == Vote::Unknown);
  CHECK(votes.count(Vote::Static) > 100);
}

TEST_CASE(
    "Algorithm 1: seeds outside of the suspects; all features when seeds are too few and suspects are "
    "there") {
  const testing::ExactScene scene = testing::preset(Preset::General);
  FrameEvidence evidence;
  Votes votes;
  EpipolarFilter filter;
  std::string note;
  const auto run = [&](const auto& is_suspect) {
    evidence.reset();
    for (int k = 0; k < 2; ++k) {
      const testing::ExactFrame frame = scene.frame(k);
      evidence.begin(frame.view(), CallPoint::BeforePose);
      for (std::size_t i = 0; i < frame.size(); ++i)
        if (is_suspect(i)) evidence.earlier_votes().mark_prior(i);
      votes.reset(frame.size());
      filter.apply(evidence, votes);
      note = votes.notes();
      evidence.end(false);
    }
    return std::stoi(note.substr(note.find(" of ") + 4));
  };
  const auto n = static_cast<int>(scene.frame(1).size());
  CHECK(run([](std::size_t i) { return i % 2 == 0; }) <= n / 2 + 1);
  // Ten seeds: the model is fitted on all features.
  CHECK(run([](std::size_t i) { return i >= 10; }) > n / 2);
}

TEST_CASE("wrong parameters throw") {
  EpipolarParams params;
  params.max_distance_px = -1;
  CHECK_THROWS_AS(EpipolarFilter{params}, ConfigError);
}

}  // namespace epipolar_test
