// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/gms.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>
#include <limits>
#include <numeric>

#include "doctest/doctest.h"
#include "filters/matched_frames.hpp"

namespace gms_test {

using namespace dynfilter;
using matched_frames::MatchedFrames;
using matched_frames::votes_of;
using testing::CameraStep;
using testing::ExactFrame;
using testing::ExactScene;
using testing::MovingBox;
using testing::Preset;
using testing::Score;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A regular grid of matches by (3, 2) px, and `odd` mismatches by (-150, 100) px.
MatchedFrames even_field(int width, int height, int odd) {
  MatchedFrames frames;
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

TEST_CASE("gms: a rigid scene rejects nothing, whatever the camera does") {
  for (const CameraStep step : {CameraStep::General, CameraStep::Sideways, CameraStep::Forward,
                                CameraStep::PureRotation, CameraStep::SmallBaseline, CameraStep::None}) {
    GmsFilter filter;
    const ExactScene scene = testing::preset(Preset::Rigid).camera_motion(step);
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
    const MatchedFrames frames = even_field(size.width, size.height, 3);
    GmsFilter filter;
    const Votes votes = votes_of(filter, frames);
    CHECK(votes.count(Vote::Dynamic) == 3);
    for (std::size_t i = votes.size() - 3; i < votes.size(); ++i) CHECK(votes[i] == Vote::Dynamic);
    CHECK(votes.count(Vote::Static) == votes.size() - 3);
  }
}

TEST_CASE("gms: the published 20 x 20 grid starves where the adaptive one does not") {
  const MatchedFrames frames = even_field(640, 480, 0);
  GmsFilter adaptive, published(GmsFilterParams::published());
  CHECK(votes_of(adaptive, frames).count(Vote::Dynamic) == 0);
  CHECK(votes_of(published, frames).count(Vote::Dynamic) > 100);
}

TEST_CASE("gms: a large coherent mover supports itself: what it is blind to") {
  MatchedFrames frames = even_field(640, 480, 0);
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
  const MatchedFrames frames = even_field(640, 480, 6);
  MatchedFrames shuffled = frames;
  std::reverse(shuffled.now.begin(), shuffled.now.end());
  std::reverse(shuffled.index.begin(), shuffled.index.end());
  GmsFilter filter;
  const Votes a = votes_of(filter, frames), b = votes_of(filter, shuffled);
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == b[a.size() - 1 - i]);
}

TEST_CASE("gms: too few, odd and matchless features stay unknown") {
  GmsFilter filter;
  for (const int n : {0, 1, 2}) {
    MatchedFrames few;
    for (int k = 0; k < n; ++k) few.add({10, 10}, {12, 12});
    CHECK(votes_of(filter, few).count(Vote::Unknown) == static_cast<std::size_t>(n));
  }
  MatchedFrames frames = even_field(640, 480, 0);
  frames.now[0].pt = {kNan, 3};
  frames.then[1].pt = {3, kNan};
  frames.index[2] = -1;
  frames.index[3] = 1 << 20;
  frames.now[4].pt = frames.then[4].pt = {640, 480};  // x = width
  const Votes votes = votes_of(filter, frames);
  for (std::size_t i = 0; i < 4; ++i) CHECK(votes[i] == Vote::Unknown);
  CHECK(votes[4] != Vote::Unknown);
  MatchedFrames same;
  for (int k = 0; k < 100; ++k) same.add({50, 60}, {53, 62});
  CHECK(votes_of(filter, same).count(Vote::Dynamic) == 0);
  MatchedFrames line;
  for (int k = 0; k < 100; ++k)
    line.add({static_cast<float>(5 * k), 60}, {static_cast<float>(5 * k) + 2, 60});
  CHECK(votes_of(filter, line).count(Vote::Dynamic) == 0);
}

TEST_CASE("gms: of flow and of descriptors it makes as much") {
  // Without host matches: features move by (6, 4) and are identified by their descriptors.
  MatchedFrames frames = even_field(640, 480, 0);
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

}  // namespace gms_test
