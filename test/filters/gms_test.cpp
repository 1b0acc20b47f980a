// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/dbscan.hpp>
#include <dynfilter/filters/descriptor_distance.hpp>
#include <dynfilter/filters/gms.hpp>
#include <dynfilter/filters/trajectory_consistency.hpp>
#include <dynfilter/synth/exact_scene.hpp>
#include <dynfilter/synth/exact_scene_frame.hpp>
#include <dynfilter/synth/exact_scene_motion.hpp>
#include <dynfilter/synth/exact_scene_presets.hpp>
#include <dynfilter/synth/judge.hpp>
#include <limits>
#include <numeric>

#include "doctest/doctest.h"

namespace gms_test {

using namespace dynfilter;
using synth::CameraStep;
using synth::ExactFrame;
using synth::ExactScene;
using synth::MovingBox;
using synth::Preset;
using synth::Score;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Features matched with those of the same index of an earlier frame.
struct TwoFrames {
  std::vector<cv::KeyPoint> then, now;
  std::vector<std::int32_t> index;
  cv::Mat then_descriptors, now_descriptors;
  std::vector<float> depth_m;
  Camera camera;
  cv::Mat grey;

  void add(const cv::Point2f& from, const cv::Point2f& to) {
    then.emplace_back(from, 1.0F);
    now.emplace_back(to, 1.0F);
    index.push_back(static_cast<std::int32_t>(index.size()));
  }
  FrameView view(bool current) const {
    FrameView frame;
    frame.id = current ? 1 : 0;
    frame.keypoints = current ? now : then;
    frame.descriptors = current ? now_descriptors : then_descriptors;
    if (camera.valid()) frame.camera = camera;
    frame.depth_m = depth_m;
    frame.grey = grey;
    if (current) frame.matches = HostMatches{0, index};
    return frame;
  }
};

Votes votes_of(Filter& filter, const TwoFrames& frames) {
  FrameEvidence evidence;
  evidence.begin(frames.view(false), CallPoint::BeforePose);
  evidence.end(false);
  const FrameView now = frames.view(true);
  evidence.begin(now, CallPoint::BeforePose);
  Votes votes;
  votes.reset(now.size());
  if (without(filter.needs().required, evidence.inputs()) == Input::None) filter.apply(evidence, votes);
  return votes;
}

/// A regular grid of matches by (3, 2) px, and `odd` mismatches by (-150, 100) px.
TwoFrames even_field(int width, int height, int odd) {
  TwoFrames frames;
  frames.camera.width_px = width, frames.camera.height_px = height;
  frames.camera.fx_px = frames.camera.fy_px = 500;
  for (int y = 6; y < height - 4; y += 24)
    for (int x = 5; x < width - 5; x += 24)
      frames.add({static_cast<float>(x), static_cast<float>(y)},
                 {static_cast<float>(x + 3), static_cast<float>(y + 2)});
  for (int k = 0; k < odd; ++k) {
    const cv::Point2f to(static_cast<float>(width / 2 + 40 * k), static_cast<float>(height / 2 - 30 * k));
    frames.add(to + cv::Point2f(-100, 60), to);
  }
  return frames;
}

}  // namespace

// ---- gms

TEST_CASE("gms: a rigid scene rejects nothing, whatever the camera does") {
  for (const CameraStep step : {CameraStep::General, CameraStep::Sideways, CameraStep::Forward,
                                CameraStep::PureRotation, CameraStep::SmallBaseline, CameraStep::None}) {
    GmsFilter filter;
    const ExactScene scene = synth::preset(Preset::Rigid).camera_motion(step);
    const Score score(judge(filter, scene, 8), scene.frame(8));
    // A near point that is alone at its depth has no neighbour with similar motion.
    CHECK(score.static_kept() >= 0.995);
    CHECK(score.static_confirmed >= score.static_count - 3);
  }
}

TEST_CASE("gms: mismatches are found, what agrees is kept, in images of any size") {
  for (const cv::Size size :
       {cv::Size(640, 480), cv::Size(1241, 376), cv::Size(752, 480), cv::Size(320, 240)}) {
    CAPTURE(size.width);
    const TwoFrames frames = even_field(size.width, size.height, 3);
    GmsFilter filter;
    const Votes votes = votes_of(filter, frames);
    CHECK(votes.count(Vote::Dynamic) == 3);
    for (std::size_t i = votes.size() - 3; i < votes.size(); ++i) CHECK(votes[i] == Vote::Dynamic);
    CHECK(votes.count(Vote::Static) == votes.size() - 3);
  }
}

TEST_CASE("gms: the published 20 x 20 grid starves where the adaptive one does not") {
  const TwoFrames frames = even_field(640, 480, 0);
  GmsFilter adaptive, published(GmsFilterParams::published());
  CHECK(votes_of(adaptive, frames).count(Vote::Dynamic) == 0);
  CHECK(votes_of(published, frames).count(Vote::Dynamic) > 100);
}

TEST_CASE("gms: a large coherent mover supports itself: what it is blind to") {
  TwoFrames frames = even_field(640, 480, 0);
  for (int k = 0; k < 200; ++k) {
    const cv::Point2f from(300.0F + static_cast<float>(k % 20) * 4, 200.0F + static_cast<float>(k / 20) * 6);
    frames.add(from, from + cv::Point2f(60, 0));
  }
  GmsFilter filter;
  const Votes votes = votes_of(filter, frames);
  int rejected = 0;
  for (std::size_t i = votes.size() - 200; i < votes.size(); ++i)
    rejected += votes[i] == Vote::Dynamic ? 1 : 0;
  CHECK(rejected < 20);
}

TEST_CASE("gms: the order of the features does not matter") {
  const TwoFrames frames = even_field(640, 480, 6);
  TwoFrames shuffled = frames;
  std::reverse(shuffled.now.begin(), shuffled.now.end());
  std::reverse(shuffled.index.begin(), shuffled.index.end());
  GmsFilter filter;
  const Votes a = votes_of(filter, frames), b = votes_of(filter, shuffled);
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == b[a.size() - 1 - i]);
}

TEST_CASE("gms: too few, odd and matchless features stay unknown") {
  GmsFilter filter;
  for (const int n : {0, 1, 2}) {
    TwoFrames few;
    for (int k = 0; k < n; ++k) few.add({10, 10}, {12, 12});
    CHECK(votes_of(filter, few).count(Vote::Unknown) == static_cast<std::size_t>(n));
  }
  TwoFrames frames = even_field(640, 480, 0);
  frames.now[0].pt = {kNan, 3};
  frames.then[1].pt = {3, kNan};
  frames.index[2] = -1;
  frames.index[3] = 1 << 20;
  frames.now[4].pt = frames.then[4].pt = {640, 480};  // x = width
  const Votes votes = votes_of(filter, frames);
  for (std::size_t i = 0; i < 4; ++i) CHECK(votes[i] == Vote::Unknown);
  CHECK(votes[4] != Vote::Unknown);
  TwoFrames same;
  for (int k = 0; k < 100; ++k) same.add({50, 60}, {53, 62});
  CHECK(votes_of(filter, same).count(Vote::Dynamic) == 0);
  TwoFrames line;
  for (int k = 0; k < 100; ++k)
    line.add({static_cast<float>(5 * k), 60}, {static_cast<float>(5 * k) + 2, 60});
  CHECK(votes_of(filter, line).count(Vote::Dynamic) == 0);
}

TEST_CASE("gms: of flow and of descriptors it makes as much") {
  // Without host matches: features move by (6, 4) and are identified by their descriptors.
  TwoFrames frames = even_field(640, 480, 0);
  frames.then_descriptors.create(static_cast<int>(frames.then.size()), 32, CV_8UC1);
  cv::RNG random(7);
  random.fill(frames.then_descriptors, cv::RNG::UNIFORM, 0, 256);
  frames.now_descriptors = frames.then_descriptors.clone();
  // Two features swap their positions: both matches are then wrong.
  const auto a = frames.now.size() / 2, b = a + 1;
  std::swap(frames.now[a].pt, frames.now[b].pt);
  FrameEvidence evidence;
  FrameView then = frames.view(false), now = frames.view(true);
  now.matches.reset();
  evidence.begin(then, CallPoint::BeforePose);
  evidence.end(false);
  evidence.begin(now, CallPoint::BeforePose);
  Votes votes;
  votes.reset(now.size());
  GmsFilter filter;
  filter.apply(evidence, votes);
  CHECK(votes.count(Vote::Unknown) == 0);
  CHECK(votes.count(Vote::Dynamic) <= 2);
}

// ---- descriptor_distance

TEST_CASE("descriptor_distance: alike is a candidate, unlike is none") {
  TwoFrames frames;
  for (int k = 0; k < 4; ++k)
    frames.add({10.0F * static_cast<float>(k), 5}, {10.0F * static_cast<float>(k), 6});
  frames.then_descriptors = cv::Mat::zeros(4, 32, CV_8UC1);
  frames.now_descriptors = cv::Mat::zeros(4, 32, CV_8UC1);
  for (int b = 0; b < 6; ++b) frames.now_descriptors.at<std::uint8_t>(1, b) = 0xFF;  // 48 bits
  for (int b = 0; b < 6; ++b) frames.now_descriptors.at<std::uint8_t>(2, b) = 0xFF;
  frames.now_descriptors.at<std::uint8_t>(2, 6) = 0x07;  // 51 bits
  frames.index[3] = -1;
  DescriptorDistanceFilter filter;
  const Votes votes = votes_of(filter, frames);
  CHECK(votes[0] == Vote::Dynamic);
  CHECK(votes[1] == Vote::Dynamic);
  CHECK(votes[2] == Vote::Static);
  CHECK(votes[3] == Vote::Unknown);
  CHECK(votes.suspicion(0) > votes.suspicion(1));
}

TEST_CASE("descriptor_distance: rows that do not fit, another length, none: unknown") {
  TwoFrames frames;
  for (int k = 0; k < 4; ++k)
    frames.add({10.0F * static_cast<float>(k), 5}, {10.0F * static_cast<float>(k), 6});
  DescriptorDistanceFilter filter;
  const auto unknown = [&] { return votes_of(filter, frames).count(Vote::Unknown) == 4; };
  CHECK(unknown());
  frames.now_descriptors = cv::Mat::zeros(4, 32, CV_8UC1);
  CHECK(unknown());
  frames.then_descriptors = cv::Mat::zeros(4, 64, CV_8UC1);
  CHECK(unknown());
  frames.then_descriptors = cv::Mat::zeros(3, 32, CV_8UC1);
  CHECK(unknown());
  frames.then_descriptors = cv::Mat::zeros(4, 32, CV_32FC1);
  CHECK(unknown());
}

// ---- trajectory_consistency: the band of Zhou et al.

TEST_CASE("trajectory_consistency: less than d1 is static, more than the cap unknown, between dynamic") {
  // 30 static features at 2 m and three that move by 1, 6 and 30 cm: 5, 30, 150 px.
  // The camera is static.
  TwoFrames frames;
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
    params.alpha_m = params.beta = 0;
    params.min_displacement_m = 0.02;
    params.max_displacement_m = 0.1;
    TrajectoryConsistencyFilter filter(params);
    const Votes votes = votes_of(filter, frames);
    CHECK(votes.count(Vote::Static) == 31);
    CHECK(votes[30] == Vote::Static);
    CHECK(votes[31] == Vote::Dynamic);
    CHECK(votes[32] == Vote::Unknown);
  }
}

// ---- dbscan

namespace {

/// Features given as 3-D points before a camera, some of them dynamic by an earlier stage.
struct Cloud {
  std::vector<cv::KeyPoint> keypoints;
  std::vector<float> depth_m;
  std::vector<std::size_t> dynamic;
  Camera camera;

  Cloud() { camera.fx_px = camera.fy_px = 500, camera.cx_px = 320, camera.cy_px = 240; }
  void add(const cv::Point3f& p, bool moving) {
    if (moving) dynamic.push_back(keypoints.size());
    keypoints.emplace_back(320 + 500 * p.x / p.z, 240 + 500 * p.y / p.z, 1.0F);
    depth_m.push_back(p.z);
  }
  Votes votes(Filter& filter, std::int64_t id = 0) const {
    FrameEvidence evidence;
    FrameView frame;
    frame.id = id;
    frame.keypoints = keypoints;
    frame.depth_m = depth_m;
    frame.camera = camera;
    evidence.begin(frame, CallPoint::BeforePose);
    Votes votes;
    votes.reset(frame.size());
    for (const std::size_t i : dynamic) votes.cast(i, Vote::Dynamic);
    evidence.stages().learn(votes);
    votes.reset(frame.size());
    filter.apply(evidence, votes);
    return votes;
  }
};

/// Five dynamic features around (0, 0, 2), 5 cm apart.
Cloud person() {
  Cloud cloud;
  for (const cv::Point3f p : {cv::Point3f(0, 0, 2), cv::Point3f(0.05F, 0, 2), cv::Point3f(-0.05F, 0, 2),
                              cv::Point3f(0, 0.05F, 2), cv::Point3f(0, -0.05F, 2)})
    cloud.add(p, true);
  return cloud;
}

/// Two people of 120 features, half of them already dynamic, and a room.
Cloud room(float spread_m) {
  Cloud cloud;
  std::uint32_t state = 1;
  const auto uniform = [&] {
    state = state * 1664525U + 1013904223U;
    return static_cast<float>(state >> 8U) / 8388608.0F - 1;
  };
  for (int k = 0; k < 240; ++k) {
    const float x = k % 2 == 0 ? -0.8F : 0.8F;
    cloud.add({x + spread_m * uniform(), 2 * spread_m * uniform(), 2.5F + 0.3F * spread_m * uniform()},
              k % 4 < 2);
  }
  for (int k = 0; k < 100; ++k) cloud.add({2.5F * uniform(), 1.5F * uniform(), 4.5F}, false);
  return cloud;
}

}  // namespace

TEST_CASE("dbscan: what is within Eps of a core point goes, the rest is left unknown") {
  Cloud cloud = person();
  cloud.add({0.14F, 0.0F, 2}, false);      // 9 cm from a point of the cluster, 14 from its middle
  cloud.add({0.0F, 0.0F, 2.3F}, false);    // 30 cm behind
  cloud.add({1.0F, 0.0F, 2}, true);        // a lone dynamic feature
  cloud.add({1.05F, 0.0F, 2}, false);      // beside it
  cloud.add({0.02F, 0.02F, kNan}, false);  // no depth
  DbscanFilterParams params;
  params.eps_m = 0.1;
  DbscanFilter filter(params);
  const Votes votes = cloud.votes(filter);
  CHECK(votes[5] == Vote::Dynamic);
  CHECK(votes[6] == Vote::Unknown);
  CHECK(votes[8] == Vote::Unknown);
  CHECK(votes[9] == Vote::Unknown);
  CHECK(votes.count(Vote::Static) == 0);
  CHECK(votes.suspicion(5) == doctest::Approx(1 - 0.5 * 0.9).epsilon(0.01));
}

TEST_CASE("dbscan: without dynamic features, with one, with equal ones") {
  DbscanFilter filter;
  Cloud none;
  CHECK(none.votes(filter).size() == 0);
  for (int k = 0; k < 30; ++k) none.add({0, 0.01F * static_cast<float>(k), 2}, false);
  CHECK(none.votes(filter).count(Vote::Unknown) == 30);
  Cloud one = none;
  one.add({0, 0, 2}, true);
  CHECK(one.votes(filter).count(Vote::Dynamic) == 0);
  Cloud same;
  for (int k = 0; k < 20; ++k) same.add({0.3F, 0.2F, 2}, k < 10);
  CHECK(same.votes(filter).count(Vote::Dynamic) == 10);
  DbscanFilterParams params;
  params.adaptive = true;
  params.adaptive_min_points = 4;
  DbscanFilter adaptive(params);
  CHECK(same.votes(adaptive).count(Vote::Dynamic) == 10);  // no choice: eps_m and min_points apply
  CHECK_FALSE(adaptive.chosen());
}

TEST_CASE("dbscan: two people known by half go whole, the room stays") {
  DbscanFilter filter;
  const Votes votes = room(0.2F).votes(filter);
  int found = 0, wrong = 0;
  for (std::size_t i = 0; i < 240; ++i) found += i % 4 >= 2 && votes[i] == Vote::Dynamic ? 1 : 0;
  for (std::size_t i = 240; i < votes.size(); ++i) wrong += votes[i] == Vote::Dynamic ? 1 : 0;
  CHECK(found >= 110);
  CHECK(wrong == 0);
}

TEST_CASE("dbscan: adaptive parameters are chosen once, kept, and chosen again after a reset") {
  DbscanFilterParams params;
  params.adaptive = true;
  DbscanFilter filter(params);
  CHECK(person().votes(filter).size() == 5);  // too few to choose from
  CHECK_FALSE(filter.chosen());
  room(0.2F).votes(filter);
  REQUIRE(filter.chosen());
  const DbscanParams first = *filter.chosen();
  Cloud wide = room(0.35F);
  wide.votes(filter);
  CHECK(filter.chosen()->eps_m == first.eps_m);
  filter.reset();
  CHECK_FALSE(filter.chosen());
  wide.votes(filter);
  REQUIRE(filter.chosen());
  CHECK(filter.chosen()->eps_m > first.eps_m);
  DbscanFilterParams narrow = params;
  narrow.adaptive_max_eps_m = 0.01;
  DbscanFilter refusing(narrow);
  wide.votes(refusing);
  CHECK_FALSE(refusing.chosen());
}

TEST_CASE("dbscan: the order of the features does not matter") {
  const Cloud cloud = room(0.2F);
  Cloud reversed;
  for (std::size_t i = cloud.keypoints.size(); i-- > 0;) {
    const bool moving = std::find(cloud.dynamic.begin(), cloud.dynamic.end(), i) != cloud.dynamic.end();
    if (moving) reversed.dynamic.push_back(reversed.keypoints.size());
    reversed.keypoints.push_back(cloud.keypoints[i]);
    reversed.depth_m.push_back(cloud.depth_m[i]);
  }
  DbscanFilter filter;
  const Votes a = cloud.votes(filter), b = reversed.votes(filter);
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == b[a.size() - 1 - i]);
}

}  // namespace gms_test
