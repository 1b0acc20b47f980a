// SPDX-License-Identifier: MIT
#include <dynfilter/keyframe/make_selector.hpp>
#include <limits>
#include <set>

#include "doctest/doctest.h"

namespace selector_test {

using namespace dynfilter;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A frame at x metres that observes the points `first` .. `first` + `points` - 1.
FrameSummary frame(std::int64_t id, double x_m, std::int64_t first, int points = 100, int dynamic = 0) {
  FrameSummary f;
  f.id = id;
  f.timestamp_s = static_cast<double>(id) / 30;
  f.T_world_camera.translation_m = {x_m, 0, 0};
  f.image_px = {640, 480};
  for (int i = 0; i < points; ++i) f.points.push_back(first + i);
  f.dynamic_features = dynamic;
  return f;
}

FrameSummary turned(std::int64_t id, double deg) {
  FrameSummary f = frame(id, 0, 0);
  const double a = deg * M_PI / 180;
  f.T_world_camera.rotation = {std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1};
  return f;
}

using Ids = std::vector<std::int64_t>;

Ids ids(const std::vector<SelectedFrame>& frames) {
  Ids list;
  for (const SelectedFrame& f : frames) list.push_back(f.id);
  return list;
}

void append(std::vector<SelectedFrame>& all, const std::vector<SelectedFrame>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

std::vector<SelectedFrame> select(KeyframeSelector& selector, const std::vector<FrameSummary>& frames) {
  std::vector<SelectedFrame> all;
  for (const FrameSummary& f : frames) append(all, selector.add(f));
  append(all, selector.flush());
  return all;
}

/// Makes every frame a candidate: frames are a metre apart. Batches of up to a hundred.
VertexCoverParams one_batch() {
  VertexCoverParams params;
  params.min_candidates = 100;
  params.max_dynamic_features = 50;
  return params;
}

/// Frame k shares 50 of 100 points with each neighbour, none with others.
std::vector<FrameSummary> chain(int n) {
  std::vector<FrameSummary> frames;
  for (int k = 0; k < n; ++k) frames.push_back(frame(k, k, k * 50));
  return frames;
}

}  // namespace

TEST_CASE("shared points, spread and pose difference") {
  CHECK(sorted_points({5, -1, 3, 5}) == Ids{3, 5});
  CHECK(shared_points({1, 3, 5, 9}, {0, 3, 4, 5, 6}) == 2);
  CHECK(shared_points({}, {1}) == 0);
  FrameSummary f = frame(0, 0, 0);
  f.pixels = {{0, 0}, {1, 1}, {639.9F, 479.9F}, {640, 480}, {-1, 5}, {NAN, 5}};
  CHECK(occupied_share(f, 2, 2) == doctest::Approx(0.5));
  f.image_px = {};
  CHECK(occupied_share(f, 2, 2) == 0);
  const PoseDifference d = difference(turned(0, 10).T_world_camera, turned(1, 40).T_world_camera);
  CHECK(d.rotation_deg == doctest::Approx(30));
  CHECK(d.translation_m == doctest::Approx(0));
}

TEST_CASE("pose change: first frame, motion, rotation, gap and lost points make keyframes") {
  PoseChangeParams params;
  params.min_translation_m = 0.1, params.min_rotation_deg = 10, params.max_gap_frames = 20;
  PoseChangeSelector selector(params);
  CHECK(ids(selector.add(frame(0, 0, 0))) == Ids{0});
  CHECK(selector.add(frame(1, 0.09, 0)).empty());
  const auto moved = selector.add(frame(2, 0.11, 0));
  REQUIRE(moved.size() == 1);
  CHECK(moved[0].reason == KeyframeReason::Moved);
  CHECK(selector.add(frame(3, 0.05, 0)).empty());      // from the last keyframe, not from the first
  const auto lost = selector.add(frame(4, 0.11, 26));  // 74 of 100 are left
  REQUIRE(lost.size() == 1);
  CHECK(lost[0].reason == KeyframeReason::FewShared);
  CHECK(selector.add(frame(23, 0.11, 26)).empty());
  const auto late = selector.add(frame(24, 0.11, 26));
  REQUIRE(late.size() == 1);
  CHECK(late[0].reason == KeyframeReason::Gap);

  PoseChangeSelector rotation(params);
  rotation.add(turned(0, 0));
  CHECK(rotation.add(turned(1, 9.9)).empty());
  CHECK(rotation.add(turned(2, 10.1)).size() == 1);
  CHECK(selector.pending().empty());
}

TEST_CASE("pose change: with require_motion a still camera makes no keyframes") {
  PoseChangeParams params;
  params.require_motion = true;
  PoseChangeSelector selector(params);
  selector.add(frame(0, 0, 0));
  CHECK(selector.add(frame(50, 0, 900)).empty());
  CHECK(selector.add(frame(51, 0.2, 900)).size() == 1);
  CHECK(selector.add(frame(52, 0.4, 900)).empty());  // moved, but all points are still visible
}

TEST_CASE("pose change: the least gap holds, many dynamic features are marked") {
  PoseChangeParams params;
  params.min_gap_frames = 3, params.max_dynamic_features = 10;
  PoseChangeSelector selector(params);
  selector.add(frame(0, 0, 0));
  CHECK(selector.add(frame(2, 5, 0)).empty());
  const auto key = selector.add(frame(3, 5, 0, 100, 11));
  REQUIRE(key.size() == 1);
  CHECK(key[0].cut_dynamic);
}

TEST_CASE("vertex cover: every second frame of a chain, joined by bridges") {
  VertexCoverSelector selector(one_batch());
  // The smallest cover of a path of 5 is {1, 3}; 2 connects them.
  const auto keys = select(selector, chain(5));
  CHECK(ids(keys) == Ids{1, 2, 3});
  CHECK(keys[1].reason == KeyframeReason::Bridge);
  CHECK(keys[0].reason == KeyframeReason::Cover);
  CHECK(keys[2].reason == KeyframeReason::Cover);
}

TEST_CASE("vertex cover: fourteen shared points are no edge, fifteen are") {
  const auto pair = [](int shared) {
    return std::vector<FrameSummary>{frame(0, 0, 0), frame(1, 1, 100 - shared)};
  };
  VertexCoverSelector selector(one_batch());
  const auto apart = select(selector, pair(14));
  CHECK(ids(apart) == Ids{0, 1});
  CHECK(apart[0].reason == KeyframeReason::Isolated);
  selector.reset();
  CHECK(select(selector, pair(15)).size() == 1);
  VertexCoverParams published = one_batch();
  published.keep_isolated = false;
  VertexCoverSelector literal(published);
  CHECK(select(literal, pair(14)).empty());
}

TEST_CASE("vertex cover: a frame with too many dynamic features gives way where the cover still holds") {
  // Two frames: either covers the edge, and the clean one is selected.
  VertexCoverSelector selector(one_batch());
  CHECK(ids(select(selector, {frame(0, 0, 0, 100, 99), frame(1, 1, 50)})) == Ids{1});
  // The middle of a star cannot be replaced, so it is marked cut_dynamic.
  selector.reset();
  std::vector<FrameSummary> star{frame(0, 0, 0), frame(1, 1, 200), frame(2, 2, 400), frame(3, 3, 0, 500, 99)};
  const auto keys = select(selector, star);
  REQUIRE(ids(keys) == Ids{3});
  CHECK(keys[0].cut_dynamic);
  // A path of three: {1} is a cover with many dynamic features.
  // The two ends are not a smaller cover, so it remains.
  selector.reset();
  std::vector<FrameSummary> path = chain(3);
  path[1].dynamic_features = 51;
  CHECK(ids(select(selector, path)) == Ids{1});
}

TEST_CASE("vertex cover: a dirty frame of a four-cycle is replaced") {
  // 0-1-2-3-0: the smallest covers are {0, 2} and {1, 3}.
  // Each needs a bridge, for which there are two options.
  const auto cycle = [](int dirty) {
    std::vector<FrameSummary> frames;
    for (int k = 0; k < 4; ++k) {
      FrameSummary f = frame(k, k, k * 100, 30, k == dirty ? 99 : 0);  // shared with the next
      for (int i = 0; i < 30; ++i) f.points.push_back((k + 3) % 4 * 100 + i);
      frames.push_back(f);
    }
    return frames;
  };
  for (int dirty = 0; dirty < 4; ++dirty) {
    VertexCoverSelector selector(one_batch());
    const auto keys = select(selector, cycle(dirty));
    CAPTURE(dirty);
    CHECK(keys.size() == 3);
    for (const SelectedFrame& key : keys) CHECK(key.id != dirty);
  }
}

TEST_CASE("vertex cover: candidates by motion or by spread, batches with an anchor") {
  VertexCoverParams params = one_batch();
  params.min_translation_m = 0.5, params.min_spread_gap_frames = 3;
  VertexCoverSelector selector(params);
  selector.add(frame(0, 0, 0));
  selector.add(frame(1, 0.4, 0));
  CHECK(selector.pending() == Ids{0});
  selector.add(frame(2, 0.6, 0));
  CHECK(selector.pending() == Ids{0, 2});
  FrameSummary even = frame(4, 0.6, 0);
  for (int y = 5; y < 480; y += 20)
    for (int x = 5; x < 640; x += 20) even.pixels.push_back({static_cast<float>(x), static_cast<float>(y)});
  selector.add(even);
  CHECK(selector.pending().size() == 2);  // too soon after the last candidate
  even.id = 5, even.timestamp_s = 0.2;
  selector.add(even);
  CHECK(selector.pending() == Ids{0, 2, 5});

  params = one_batch();
  params.min_candidates = 5;
  VertexCoverSelector batches(params);
  std::vector<SelectedFrame> keys;
  const std::vector<FrameSummary> frames = chain(23);
  for (const FrameSummary& f : frames) append(keys, batches.add(f));
  CHECK(batches.pending().back() == 22);
  append(keys, batches.flush());
  CHECK(batches.pending().empty());
  // Connected over all batches: consecutive keyframes are at most one edge apart.
  for (std::size_t i = 1; i < keys.size(); ++i) CHECK(keys[i].id - keys[i - 1].id == 1);
}

TEST_CASE("vertex cover: who waits too long is solved with fewer") {
  VertexCoverParams params = one_batch();
  params.max_wait_frames = 10;
  VertexCoverSelector selector(params);
  selector.add(frame(0, 0, 0));
  CHECK(selector.add(frame(9, 0, 0)).empty());
  CHECK(ids(selector.add(frame(10, 0, 0))) == Ids{0});
}

TEST_CASE("both selectors leave out what is no frame, and say so; the same again after a reset") {
  for (const char* name : {"pose_change", "vertex_cover"}) {
    CAPTURE(name);
    const auto selector = make_keyframe_selector(name);
    CHECK(selector->name() == name);
    FrameSummary nan = frame(0, kNan, 0), skewed = frame(0, 0, 0);
    skewed.T_world_camera.rotation[0] = 2;
    CHECK(selector->add(nan).empty());
    CHECK(selector->add(skewed).empty());
    CHECK(selector->left_out().bad_pose == 2);
    std::vector<FrameSummary> frames = chain(20);
    FrameSummary early = frame(6, 9, 0), stampless = frame(30, 9, 0);
    early.timestamp_s = 0, stampless.timestamp_s = kNan;
    frames.insert(frames.begin() + 6, {frames[5], frame(3, 9, 0), early, stampless});
    const Ids first = ids(select(*selector, frames));
    CHECK(selector->left_out().not_newer == 4);
    CHECK(std::set<std::int64_t>(first.begin(), first.end()).size() == first.size());
    CHECK(std::is_sorted(first.begin(), first.end()));
    selector->reset();
    CHECK(selector->left_out().bad_pose == 0);
    CHECK(ids(select(*selector, chain(20))) == first);
    CHECK(ids(select(*make_keyframe_selector(name), chain(20))) == first);
  }
}

TEST_CASE("frames that see nothing, and points in any order") {
  for (const char* name : {"pose_change", "vertex_cover"}) {
    CAPTURE(name);
    const auto blind = make_keyframe_selector(name);
    std::vector<FrameSummary> frames;
    for (int k = 0; k < 4; ++k) frames.push_back(frame(k, k, 0, 0));
    CHECK(select(*blind, frames).size() == 4);
    std::vector<FrameSummary> mixed = chain(15);
    for (FrameSummary& f : mixed) std::reverse(f.points.begin(), f.points.end()), f.points.push_back(-1);
    CHECK(ids(select(*make_keyframe_selector(name), mixed)) ==
          ids(select(*make_keyframe_selector(name), chain(15))));
  }
}

TEST_CASE("parameters are checked and read") {
  VertexCoverParams params;
  params.min_rotation_deg = 200;
  CHECK_THROWS_AS(VertexCoverSelector{params}, ConfigError);
  PoseChangeParams nan;
  nan.min_translation_m = kNan;
  CHECK_THROWS_AS(PoseChangeSelector{nan}, ConfigError);
  CHECK_THROWS_WITH_AS(
      make_keyframe_selector("best"),
      "unknown keyframe selector `best`; known keyframe selectors: pose_change, vertex_cover", ConfigError);
  const YamlDocument yaml = YamlDocument::from_text("%YAML:1.0\nmax_gap_frames: 2\n");
  CHECK(make_keyframe_selector("pose_change", yaml.root())->name() == "pose_change");
  CHECK_THROWS_AS(make_keyframe_selector("vertex_cover", yaml.root()), ConfigError);
}

}  // namespace selector_test
