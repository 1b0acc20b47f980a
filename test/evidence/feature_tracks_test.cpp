// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <vector>

#include "doctest/doctest.h"

namespace feature_tracks_test {

using namespace dynfilter;

namespace {

/// Position of a feature now and in the previous frame.
struct Seen {
  cv::Point2f px, was_px;
  std::int32_t index = -1;  ///< index in the previous frame; -1: only the position is known
  float depth_m = 2, was_depth_m = 2;
  bool found = true;
  MatchSpread spread{};
};

/// Passes frames to FeatureTracks as FrameTracks does.
class Frames {
 public:
  void show(FeatureTracks& tracks, std::int64_t id, std::int64_t reference_id,
            const std::vector<Seen>& features) {
    reference_.id = reference_id;
    Match match;
    match.reference = reference_id >= 0 ? &reference_ : nullptr;
    match.correspondences.reset(features.size());
    std::vector<cv::Point2f> px;
    std::vector<float> depths_m;
    for (std::size_t i = 0; i < features.size(); ++i) {
      const Seen& f = features[i];
      px.push_back(f.px);
      depths_m.push_back(f.depth_m);
      if (f.found) match.correspondences.set(i, f.was_px, f.index);
      match.correspondences.spread[i] = f.spread;
      match.reference_undistorted_px.push_back(f.was_px);
      match.reference_depth_m.push_back(f.was_depth_m);
    }
    tracks.follow(id, match, px, px, depths_m);
  }

 private:
  PastFrame reference_;
};

Seen at(float x, float y, float depth_m = 2) {
  Seen seen;
  seen.px = {x, y};
  seen.depth_m = depth_m;
  seen.found = false;
  return seen;
}
Seen moved(cv::Point2f from, cv::Point2f to, std::int32_t index = -1) {
  Seen seen;
  seen.px = to;
  seen.was_px = from;
  seen.index = index;
  return seen;
}

}  // namespace

TEST_CASE("the host's indices are followed, wherever the features went, up to the length that is kept") {
  FeatureTracks tracks({3});
  Frames frames;
  frames.show(tracks, 0, -1, {at(100, 50), at(300, 200)});
  CHECK(tracks.size() == 2);
  CHECK(tracks.length(0) == 0);
  CHECK(tracks.previous(0) == -1);
  // They change order in the list and jump far.
  frames.show(tracks, 1, 0, {moved({300, 200}, {340, 200}, 1), moved({100, 50}, {100, 90}, 0)});
  CHECK(tracks.previous(0) == 1);
  CHECK(tracks.previous(1) == 0);
  frames.show(tracks, 2, 1, {moved({340, 200}, {380, 200}, 0), moved({100, 90}, {100, 130}, 1)});
  CHECK(tracks.length(0) == 2);
  for (int k = 0; k <= 2; ++k) {
    CHECK(tracks.at(0, k) == cv::Point2f(380.0F - 40.0F * static_cast<float>(k), 200));
    CHECK(tracks.at(1, k) == cv::Point2f(100, 130.0F - 40.0F * static_cast<float>(k)));
    CHECK(tracks.depth_m(0, k) == 2.0F);
  }
  for (int id = 3; id < 6; ++id) {
    const auto x = static_cast<float>(380 + 40 * (id - 2));
    frames.show(tracks, id, id - 1, {moved({x - 40, 200}, {x, 200}, 0)});
  }
  CHECK(tracks.length(0) == 3);
  CHECK(tracks.at(0, 3) == cv::Point2f(380, 200));
}

TEST_CASE("an index that the last frame does not have lends no past") {
  FeatureTracks tracks({3});
  Frames frames;
  frames.show(tracks, 0, -1, {at(100, 50)});
  frames.show(tracks, 1, 0, {moved({100, 50}, {101, 50}, 7)});
  CHECK(tracks.previous(0) == -1);
  CHECK(tracks.length(0) == 1);
}

TEST_CASE("where only places are known the nearest feature lends its past, shifted onto the place") {
  FeatureTracks tracks({4, 2.0});
  Frames frames;
  frames.show(tracks, 0, -1, {at(100, 50), at(103, 50)});
  frames.show(tracks, 1, 0, {moved({100, 50}, {110, 52}), moved({103, 50}, {113, 52})});
  // Detected again, 0.5 px right of and 1 px below the old position, at 1.9 m instead of 2 m.
  Seen seen = moved({110.5F, 53}, {120, 55});
  seen.was_depth_m = 1.95F;
  seen.depth_m = 1.9F;
  frames.show(tracks, 2, 1, {seen});
  CHECK(tracks.previous(0) == 0);
  CHECK(tracks.length(0) == 2);
  CHECK(tracks.at(0, 0) == cv::Point2f(120, 55));
  CHECK(tracks.at(0, 1) == cv::Point2f(110.5F, 53));
  CHECK(tracks.at(0, 2) == cv::Point2f(100.5F, 51));
  CHECK(tracks.depth_m(0, 0) == doctest::Approx(1.9));
  CHECK(tracks.depth_m(0, 2) == doctest::Approx(1.95));
}

TEST_CASE("nothing within the jump: a track of one step") {
  FeatureTracks tracks({4, 2.0});
  Frames frames;
  frames.show(tracks, 0, -1, {at(100, 50)});
  frames.show(tracks, 1, 0, {moved({102.1F, 50}, {110, 52}), moved({101.9F, 50}, {110, 52})});
  CHECK(tracks.previous(0) == -1);
  CHECK(tracks.length(0) == 1);
  CHECK(tracks.previous(1) == 0);
}

// 4 % of 2 m: 2.09 m is another surface, 2.07 m is not, and a missing depth passes.
TEST_CASE("a feature on another surface lends no past, though it is nearer") {
  FeatureTracks tracks({4, 2.0});
  Frames frames;
  const auto previous_of = [&](float near_depth_m) {
    tracks.reset();
    frames.show(tracks, 0, -1, {at(100, 50, near_depth_m), at(101, 50, 2)});
    frames.show(tracks, 1, 0, {moved({100.1F, 50}, {105, 50})});
    return tracks.previous(0);
  };
  CHECK(previous_of(2.09F) == 1);
  CHECK(previous_of(2.07F) == 0);
  CHECK(previous_of(1.5F) == 1);
  CHECK(previous_of(FeatureTracks::kNoDepth) == 0);
}

TEST_CASE("of two features at the same distance the upper left one, whatever their order") {
  for (const bool turned : {false, true}) {
    FeatureTracks tracks({4, 2.0});
    Frames frames;
    std::vector<Seen> first{at(99, 50), at(101, 50), at(100, 49)};
    if (turned) std::reverse(first.begin(), first.end());
    frames.show(tracks, 0, -1, first);
    frames.show(tracks, 1, 0, {moved({100, 50}, {105, 50})});
    REQUIRE(tracks.previous(0) >= 0);
    CHECK(first[static_cast<std::size_t>(tracks.previous(0))].px == cv::Point2f(100, 49));
  }
}

TEST_CASE("tracks begin anew where the chain is broken") {
  FeatureTracks tracks({4});
  Frames frames;
  const auto three_frames = [&] {
    tracks.reset();
    frames.show(tracks, 0, -1, {at(100, 50)});
    for (int id = 1; id < 3; ++id) frames.show(tracks, id, id - 1, {moved({100, 50}, {100, 50}, 0)});
    REQUIRE(tracks.length(0) == 2);
  };
  SUBCASE("a match to a frame that is not the last one") {
    three_frames();
    frames.show(tracks, 3, 1, {moved({100, 50}, {100, 50}, 0)});
    CHECK(tracks.length(0) == 1);
    CHECK(tracks.previous(0) == -1);
  }
  SUBCASE("a frame without any match") {
    three_frames();
    frames.show(tracks, 3, -1, {at(100, 50)});
    CHECK(tracks.length(0) == 0);
    frames.show(tracks, 4, 3, {moved({100, 50}, {100, 50}, 0)});
    CHECK(tracks.length(0) == 1);
    CHECK(tracks.previous(0) == 0);
  }
  SUBCASE("a feature that is not matched") {
    three_frames();
    frames.show(tracks, 3, 2, {at(100, 50), moved({100, 50}, {100, 50}, 0)});
    CHECK(tracks.length(0) == 0);
    CHECK(tracks.length(1) == 3);
  }
  SUBCASE("a frame without features") {
    three_frames();
    frames.show(tracks, 3, 2, {});
    CHECK(tracks.size() == 0);
    frames.show(tracks, 4, 3, {moved({100, 50}, {100, 50}, 0)});
    CHECK(tracks.length(0) == 1);
    CHECK(tracks.previous(0) == -1);
  }
  SUBCASE("reset") {
    three_frames();
    tracks.reset();
    frames.show(tracks, 3, 2, {moved({100, 50}, {100, 50}, 0)});
    CHECK(tracks.length(0) == 1);
    CHECK(tracks.previous(0) == -1);
  }
}

TEST_CASE("without depths, and with places that are none") {
  FeatureTracks tracks({4});
  Frames frames;
  const float none = FeatureTracks::kNoDepth;
  frames.show(tracks, 0, -1, {at(100, 50, none), at(none, 50), at(1e30F, -1e30F)});
  Seen seen = moved({100, 50}, {104, 50}), odd = moved({none, none}, {5, 5});
  seen.was_depth_m = seen.depth_m = none;
  frames.show(tracks, 1, 0, {seen, odd});
  CHECK(tracks.previous(0) == 0);
  CHECK(tracks.previous(1) == -1);
  CHECK(std::isnan(tracks.depth_m(0, 1)));
}

TEST_CASE("feature tracks: what a track may have slid is the mean of its steps") {
  FeatureTracks tracks({12, 3.0, true});
  Frames frames;
  MatchSpread edge;
  edge.edge = {0.8F, -0.6F};
  edge.along = 100;
  edge.depth_per_px = 0.01F;
  frames.show(tracks, 0, -1, {at(100, 100)});
  for (int k = 1; k <= 4; ++k) {
    const auto x = static_cast<float>(100 + k);
    Seen seen = moved({x - 1, 100}, {x, 100}, 0);
    if (k != 3) seen.spread = edge;  // one step has found a corner
    frames.show(tracks, k, k - 1, {seen});
    const MatchSpread spread = tracks.spread(0);
    const double share = k < 3 ? 1.0 : k == 3 ? 2.0 / 3 : 3.0 / 4;
    CHECK(spread.along == doctest::Approx(1 + 99 * share));
    CHECK(spread.across == doctest::Approx(1));
    CHECK(std::abs(spread.edge.dot(edge.edge)) == doctest::Approx(1));
    if (k != 3) CHECK(spread.depth_per_px * spread.edge.dot(edge.edge) == doctest::Approx(0.01));
  }
  frames.show(tracks, 9, -1, {at(100, 100)});
  CHECK_FALSE(tracks.spread(0).slides());
}

}  // namespace feature_tracks_test
