// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/random.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/evidence/history.hpp>
#include <dynfilter/filters/flow_consistency.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "doctest/doctest.h"

namespace flow_consistency_test {

using namespace dynfilter;
using testing::CameraStep;
using testing::ExactScene;
using testing::MovingBox;
using testing::Preset;
using testing::Score;

namespace {

FlowConsistencyParams without_ground() {
  FlowConsistencyParams params;
  params.ground = false;
  return params;
}

Score score(const ExactScene& scene, const FlowConsistencyParams& params = {}, int frame = 8) {
  FlowConsistencyFilter filter(params);
  return Score(judge(filter, scene, frame), scene.frame(frame));
}

bool all_unknown(const Votes& votes) {
  return votes.count(Vote::Unknown) == votes.size();
}

/// Votes after 0.8 s on points that a camera with f = 700 px tracks. `at(time_s)`: points in its frame [m].
template <class At>
Votes judge_points(const At& at, const cv::Size& size, const cv::Point2d& centre, double rate_hz,
                   const FlowConsistencyParams& params) {
  FlowConsistencyFilter filter(params);
  FrameEvidence evidence;
  Votes votes;
  for (int k = 0; k <= 0.8 * rate_hz + 0.5; ++k) {
    std::vector<cv::KeyPoint> keypoints;
    std::vector<std::int32_t> reference;
    for (const cv::Point3d& p : at(k / rate_hz)) {
      keypoints.emplace_back(static_cast<float>(centre.x + 700 * p.x / p.z),
                             static_cast<float>(centre.y + 700 * p.y / p.z), 7.0F);
      reference.push_back(k == 0 ? -1 : static_cast<std::int32_t>(reference.size()));
    }
    FrameView view;
    view.id = k;
    view.timestamp_s = k / rate_hz;
    view.keypoints = keypoints;
    view.camera = Camera();
    view.camera->width_px = size.width, view.camera->height_px = size.height;
    view.matches = HostMatches{k - 1, reference};
    evidence.begin(view, CallPoint::BeforePose);
    votes.reset(keypoints.size());
    filter.apply(evidence, votes);
    evidence.end(false);
  }
  return votes;
}

/// A camera that shifts to the right at 0.3 m/s, a wall 4 m ahead with 300 points, and before it a body with
/// 40.
/// All flow is along the rows.
struct Room {
  double body_depth_m, body_mps = 0;  ///< to the right
  double body_half_m = 0.3;

  std::vector<cv::Point3d> at(double time_s) const {
    SampleGenerator rng(1);
    std::vector<cv::Point3d> points;
    for (int i = 0; i < 300; ++i)
      points.emplace_back(rng.uniform(-1.8, 1.8) - 0.3 * time_s, rng.uniform(-1.3, 1.3),
                          rng.uniform(3.8, 4.2));
    for (int i = 0; i < 40; ++i)
      points.emplace_back(rng.uniform(-body_half_m, body_half_m) + (body_mps - 0.3) * time_s,
                          rng.uniform(-body_half_m, body_half_m), body_depth_m);
    return points;
  }
  /// Shares of the wall and of the body that are dynamic.
  std::pair<double, double> dynamic() const {
    const Votes votes =
        judge_points([&](double time_s) { return at(time_s); }, {640, 480}, {320, 240}, 30, {});
    double wall = 0, body = 0;
    for (std::size_t i = 0; i < votes.size(); ++i)
      (i < 300 ? wall : body) += votes[i] == Vote::Dynamic ? 1 : 0;
    return {wall / 300, body / 40};
  }
};

/// A camera 1.5 m above a road that drives at 8 m/s and looks ahead.
/// The scene has the road, walls on both sides, and the front of a car with 30 points.
/// The car is on the oncoming lane and drives at `speed_m_s`.
class Road {
 public:
  explicit Road(double speed_m_s, double rate_hz = 10) : speed_m_s_(speed_m_s), rate_hz_(rate_hz) {}

  std::vector<cv::Point3d> at(double time_s) const {
    SampleGenerator rng(1);
    std::vector<cv::Point3d> points;
    const double driven = 8 * time_s;
    for (int i = 0; i < 150; ++i) points.emplace_back(rng.uniform(-6, 6), 1.5, rng.uniform(16, 40) - driven);
    for (int i = 0; i < 200; ++i)
      points.emplace_back(i % 2 == 0 ? -9 : 9, rng.uniform(-4, 1.5), rng.uniform(20, 50) - driven);
    for (int i = 0; i < 30; ++i)
      points.emplace_back(rng.uniform(-4, -2.4), rng.uniform(0.1, 1.45), 26 - driven - speed_m_s_ * time_s);
    return points;
  }
  /// Votes after 0.8 s, in the order of the points.
  Votes judge(const FlowConsistencyParams& params) const {
    return judge_points([&](double time_s) { return at(time_s); }, {1240, 380}, {620, 190}, rate_hz_, params);
  }
  int found(const Votes& votes, std::size_t from, std::size_t to) const {
    int n = 0;
    for (std::size_t i = from; i < to; ++i) n += votes[i] == Vote::Dynamic ? 1 : 0;
    return n;
  }

 private:
  double speed_m_s_, rate_hz_;
};

}  // namespace

TEST_CASE("flow_consistency: a rigid scene rejects nothing, whatever the camera does") {
  for (const CameraStep step : {CameraStep::General, CameraStep::Sideways, CameraStep::Forward,
                                CameraStep::PureRotation, CameraStep::SmallBaseline, CameraStep::None})
    for (const bool planar : {false, true})
      for (const int points : {360, 500, 1000, 2000}) {
        CAPTURE(static_cast<int>(step));
        CAPTURE(planar);
        CAPTURE(points);
        ExactScene scene = ExactScene().points(points).mono().camera_motion(step);
        if (planar) scene.planar();
        CHECK(score(scene).static_kept() == 1.0);
        CHECK(score(scene.pixel_noise(0.3)).static_kept() >= 0.98);
      }
}

TEST_CASE("flow_consistency: of a plane's two motions the one that has all of it before the camera") {
  for (const CameraStep step : {CameraStep::General, CameraStep::Sideways, CameraStep::Forward})
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      CAPTURE(static_cast<int>(step));
      CAPTURE(seed);
      ExactScene scene = ExactScene().points(360).mono().seed(seed).camera_motion(step).planar();
      CHECK(score(scene.pixel_noise(0.3)).static_kept() >= 0.98);
    }
}

TEST_CASE("flow_consistency: movers off their epipolar line are found, with noise too") {
  for (const Preset preset : {Preset::General, Preset::Planar, Preset::PureRotation, Preset::NoMotion,
                              Preset::SmallBaseline, Preset::SeveralMovers}) {
    CAPTURE(testing::to_string(preset));
    for (const double noise_px : {0.0, 0.3}) {
      CAPTURE(noise_px);
      const Score s = score(testing::preset(preset).mono().pixel_noise(noise_px));
      CHECK(s.recall() >= 0.9);
      CHECK(s.static_kept() >= 0.97);
    }
  }
}

// The car's own speed doubles its flow, but along the direction of static flow.
TEST_CASE("flow_consistency: what seems more than five times nearer than the middle of the scene moves") {
  // On their lines, all of them. The walker seems to be at 2 m * 0.3 / (0.3 + 1.2) = 0.4 m, a tenth of 4 m.
  const std::pair<double, double> walker = Room{2, -1.2}.dynamic();
  CHECK(walker.first == 0);
  CHECK(walker.second >= 0.8);  // at its rim some have too few neighbours that move alike
  const auto check_static = [](const Room& room) {
    CAPTURE(room.body_mps);
    CAPTURE(room.body_depth_m);
    const auto [wall, body] = room.dynamic();
    CHECK(wall == 0);
    CHECK(body == 0);
  };
  // With the camera, but slower: it seems to be at 3 m, as something static could be.
  check_static({2, 0.1});
  // Static things a quarter and a half as far as the wall, and half of the image.
  check_static({1});
  check_static({2, 0, 0.6});
}

TEST_CASE("flow_consistency: an oncoming car is found by its foot above the ground only") {
  const Road road(8);
  const Votes with_ground = road.judge({}), without = road.judge(without_ground());
  CHECK(road.found(with_ground, 350, 380) >= 28);
  CHECK(road.found(with_ground, 0, 350) <= 7);
  CHECK(road.found(without, 350, 380) == 0);
  const Road parked(0);
  CHECK(parked.found(parked.judge({}), 0, 380) <= 4);
}

TEST_CASE("flow_consistency: gaps are times, not frames") {
  for (const double rate_hz : {5.0, 10.0, 20.0, 30.0}) {
    CAPTURE(rate_hz);
    const Road road(8, rate_hz);
    const Votes votes = road.judge({});
    CHECK(road.found(votes, 350, 380) >= 28);
    CHECK(road.found(votes, 0, 350) <= 7);
  }
}

// The flow of one frame (0.1 px) is below the noise; that of a second is not.
TEST_CASE("flow_consistency: slow movers are found over a long gap") {
  constexpr double kRate_hz = 20;
  FlowConsistencyFilter filter;
  FrameEvidence evidence;
  Votes votes;
  for (int k = 0; k < 40; ++k) {
    SampleGenerator rng(1), noise(static_cast<std::uint64_t>(k) + 2);
    std::vector<cv::KeyPoint> keypoints;
    std::vector<std::int32_t> reference;
    for (int i = 0; i < 240; ++i) {
      const bool moves = i < 40;
      const double x = moves ? rng.uniform(280, 360) : rng.uniform(0, 640), y = rng.uniform(100, 380);
      const double shift = moves ? 0.1 * k : 0;
      keypoints.emplace_back(static_cast<float>(x + shift + 0.2 * noise.normal()),
                             static_cast<float>(y + 0.2 * noise.normal()), 7.0F);
      reference.push_back(k == 0 ? -1 : i);
    }
    FrameView view;
    view.id = k;
    view.timestamp_s = k / kRate_hz;
    view.keypoints = keypoints;
    view.camera = Camera();
    view.camera->width_px = 640, view.camera->height_px = 480;
    view.matches = HostMatches{k - 1, reference};
    evidence.begin(view, CallPoint::BeforePose);
    votes.reset(keypoints.size());
    filter.apply(evidence, votes);
    evidence.end(false);
  }
  int found = 0, lost = 0;
  for (std::size_t i = 0; i < votes.size(); ++i) (i < 40 ? found : lost) += votes[i] == Vote::Dynamic ? 1 : 0;
  CHECK(found >= 32);  // static points are visible through it
  CHECK(lost <= 10);
}

// A track of one frame has no long gap. It is judged over one frame.
TEST_CASE("flow_consistency: young tracks are judged too") {
  const ExactScene scene = testing::preset(Preset::General).mono();
  FlowConsistencyFilter filter;
  FrameEvidence evidence;
  Votes votes;
  for (int k = 0; k < 8; ++k) {
    auto frame = scene.frame(k);
    for (std::size_t i = 0; i < frame.reference_index.size(); ++i)
      if (k < 7 && frame.point[i] % 3 == 0) frame.reference_index[i] = -1;
    evidence.begin(frame.view(), CallPoint::BeforePose);
    votes.reset(frame.size());
    filter.apply(evidence, votes);
    evidence.end(false);
  }
  CHECK(votes.count(Vote::Unknown) <= votes.size() / 10);
}

TEST_CASE("flow_consistency: the last frame's votes follow the features' order") {
  const ExactScene scene = testing::preset(Preset::General).mono().pixel_noise(0.3);
  ExactScene shuffled = scene;
  shuffled.order(5);
  FlowConsistencyFilter filter, other;
  const Votes votes = judge(filter, scene, 8), permuted = judge(other, shuffled, 8);
  const auto frame = scene.frame(8), mixed = shuffled.frame(8);
  REQUIRE(votes.size() == permuted.size());
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    const auto at = std::find(frame.point.begin(), frame.point.end(), mixed.point[i]);
    REQUIRE(at != frame.point.end());
    const auto k = static_cast<std::size_t>(at - frame.point.begin());
    CHECK(permuted[i] == votes[k]);
    CHECK(permuted.suspicion(i) == votes.suspicion(k));
  }
}

TEST_CASE("flow_consistency: after a reset it is as new") {
  const ExactScene scene = testing::preset(Preset::General).mono().pixel_noise(0.3);
  FlowConsistencyFilter filter;
  const Votes first = judge(filter, scene, 8);
  judge(filter, testing::preset(Preset::SeveralMovers).mono(), 5);
  CHECK(judge(filter, scene, 8) == first);  // judge() resets
}

TEST_CASE("flow_consistency: too little to judge by is unknown") {
  FlowConsistencyFilter filter;
  for (const int points : {0, 1, 2, 11})
    CHECK(all_unknown(judge(filter, ExactScene().points(points).mono(), 5)));
  CHECK(all_unknown(judge(filter, testing::preset(Preset::General).mono().missing_matches(1), 5)));
}

TEST_CASE("flow_consistency: odd keypoints are unknown and hurt nobody") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kHuge = std::numeric_limits<float>::max();
  const ExactScene scene = testing::preset(Preset::General).mono();
  FlowConsistencyFilter filter;
  FrameEvidence evidence;
  Votes votes;
  for (int k = 0; k < 6; ++k) {
    auto frame = scene.frame(k);
    const cv::Point2f odd[] = {{kNan, 1}, {1, kNan}, {kHuge, kHuge}, {-kHuge, 0}, {640, 480}};
    for (std::size_t i = 0; i < 5; ++i) frame.keypoints[i].pt = odd[i];
    evidence.begin(frame.view(), CallPoint::BeforePose);
    votes.reset(frame.size());
    filter.apply(evidence, votes);
    evidence.end(false);
  }
  for (std::size_t i = 0; i < 4; ++i) CHECK(votes[i] == Vote::Unknown);
  CHECK(votes.count(Vote::Static) > 200);
}

TEST_CASE("flow_consistency: all features in one place, on one line, on the edge, in images of any size") {
  struct Case {
    int width, height, kind;
  };
  for (const Case c :
       {Case{640, 480, 0}, Case{640, 480, 1}, Case{1241, 376, 2}, Case{752, 480, 2}, Case{320, 240, 2}}) {
    CAPTURE(c.width);
    CAPTURE(c.kind);
    FlowConsistencyFilter filter;
    FrameEvidence evidence;
    Votes votes;
    for (int k = 0; k < 6; ++k) {
      SampleGenerator rng(1);
      std::vector<cv::KeyPoint> keypoints;
      std::vector<std::int32_t> reference;
      for (int i = 0; i < 60; ++i) {
        const auto x = static_cast<float>(rng.uniform(0, c.width)),
                   y = static_cast<float>(rng.uniform(0, c.height));
        const auto step = static_cast<float>(2 * k);
        cv::Point2f px = c.kind == 0   ? cv::Point2f(100 + step, 100)
                         : c.kind == 1 ? cv::Point2f(x + step, 0.5F * x)
                                       : cv::Point2f(std::min(x + step, static_cast<float>(c.width)), y);
        keypoints.emplace_back(px, 7.0F);
        reference.push_back(k == 0 ? -1 : i);
      }
      FrameView view;
      view.id = k;
      view.timestamp_s = 0.1 * k;
      view.keypoints = keypoints;
      view.camera = Camera();
      view.camera->width_px = c.width, view.camera->height_px = c.height;
      view.matches = HostMatches{k - 1, reference};
      evidence.begin(view, CallPoint::BeforePose);
      votes.reset(keypoints.size());
      filter.apply(evidence, votes);
      evidence.end(false);
    }
    // Static points cut off by the edge remain.
    CHECK(votes.count(Vote::Dynamic) <= (c.kind == 2 ? 3U : 0U));
  }
}

TEST_CASE("feature tracks: chained by the host's index, or by the nearest feature of the last frame") {
  PastFrame stored;
  FeatureTracks tracks({4});
  Match match;
  const auto matched = [&](const cv::Point2f& px, int index) {
    match.reference = &stored;
    match.correspondences.reset(1);
    match.correspondences.set(0, px, index);
    match.reference_undistorted_px.assign(1, px);
  };
  tracks.follow(0, Match(), {{10, 10}, {50, 50}}, {{10, 10}, {50, 50}});
  CHECK(tracks.length(0) == 0);
  stored.id = 0;
  matched({50, 50}, 1);
  tracks.follow(1, match, {{52, 50}}, {{52, 50}});
  CHECK(tracks.length(0) == 1);
  CHECK(tracks.previous(0) == 1);
  stored.id = 1;
  // The flow ended 1 px beside the feature, so its past positions are shifted.
  matched({53, 50}, -1);
  tracks.follow(2, match, {{55, 50}}, {{55, 50}});
  CHECK(tracks.length(0) == 2);
  CHECK(tracks.previous(0) == 0);
  CHECK(tracks.at(0, 0) == cv::Point2f(55, 50));
  CHECK(tracks.at(0, 1) == cv::Point2f(53, 50));
  CHECK(tracks.at(0, 2) == cv::Point2f(51, 50));
  stored.id = 2;
  matched({60, 50}, -1);  // 5 px away: another feature
  tracks.follow(3, match, {{62, 50}}, {{62, 50}});
  CHECK(tracks.length(0) == 1);
  CHECK(tracks.previous(0) == -1);
  stored.id = 2;  // not the frame that was added last
  matched({62, 50}, 0);
  tracks.follow(4, match, {{64, 50}}, {{64, 50}});
  CHECK(tracks.length(0) == 1);
  CHECK(tracks.previous(0) == -1);
}

TEST_CASE("flow_consistency: parameters out of range are refused") {
  FlowConsistencyParams params;
  params.max_gap_s = -1;
  CHECK_THROWS_AS(FlowConsistencyFilter{params}, ConfigError);
}

TEST_CASE("flow_consistency: what slides along its edge is not called dynamic, and what moves is") {
  // Host matches of a scene with a mover. Every third static feature is on an edge of any direction, and its
  // match is up to 10 px along it. Once its spread says so.
  const ExactScene scene =
      ExactScene().points(500).mono().gap(1).pixel_noise(0.1).mover(MovingBox(60).moving({0.05, 0, 0}));
  const auto play = [&](bool told) {
    FlowConsistencyFilter filter(without_ground());
    FrameEvidence evidence;
    Votes votes;
    Score total;
    Random random(7);
    std::vector<cv::Point2f> slid(static_cast<std::size_t>(scene.point_count()), cv::Point2f(0, 0));
    for (int k = 0; k <= 10; ++k) {
      testing::ExactFrame frame = scene.frame(k);
      std::vector<MatchSpread> spread(frame.size());
      for (std::size_t i = 0; i < frame.size(); ++i) {
        const auto p = static_cast<std::size_t>(frame.point[i]);
        if (frame.label[i] != 0 || p % 3 != 0) continue;
        const double angle_rad = 0.7 * static_cast<double>(p);
        spread[i].edge =
            cv::Point2f(static_cast<float>(std::cos(angle_rad)), static_cast<float>(std::sin(angle_rad)));
        spread[i].along = 1e4F;
        slid[p] += static_cast<float>(random.uniform(-10, 10)) * spread[i].edge;
        frame.keypoints[i].pt += slid[p];
      }
      FrameView view = frame.view();
      if (told && view.matches) view.matches->spread = spread;
      evidence.begin(view, CallPoint::BeforePose);
      votes.reset(frame.size());
      filter.apply(evidence, votes);
      evidence.end(false);
      if (k >= 5) total.add(votes, frame);
    }
    return total;
  };
  const Score told = play(true), untold = play(false);
  CAPTURE(untold.static_kept());
  CAPTURE(told.static_kept());
  CAPTURE(told.recall());
  CHECK(untold.static_kept() < 0.9);
  CHECK(told.static_kept() > 0.98);
  CHECK(told.recall() > 0.9);
}

}  // namespace flow_consistency_test
