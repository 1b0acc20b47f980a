// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>
#include <limits>

#include "../../examples/multi_model/multi_model.hpp"
#include "doctest/doctest.h"

namespace multi_model_test {

using namespace dynfilter;
using multi_model::MultiModelFilter;
using testing::ExactScene;
using testing::Preset;
using testing::Score;

namespace {

struct Pair {
  std::vector<cv::KeyPoint> then, now;
  std::size_t good = 0;  ///< the first `good` matches are correct
};

/// Two surfaces with different motions, 40 matches each, and 60 mismatches.
Pair two_motions() {
  SampleGenerator rng(4);
  Pair pair;
  const auto add = [&](double x, double y, double u, double v) {
    pair.now.emplace_back(static_cast<float>(x), static_cast<float>(y), 7.0F);
    pair.then.emplace_back(static_cast<float>(u), static_cast<float>(v), 7.0F);
  };
  for (int i = 0; i < 40; ++i) {
    const double x = rng.uniform(20, 280), y = rng.uniform(20, 460);
    add(x, y, x + 40, y + 10);
  }
  for (int i = 0; i < 40; ++i) {
    const double x = rng.uniform(340, 620), y = rng.uniform(20, 460);
    add(x, y, 0.9 * x - 60, y - 15);
  }
  pair.good = pair.now.size();
  for (int i = 0; i < 60; ++i)
    add(rng.uniform(0, 640), rng.uniform(0, 480), rng.uniform(0, 640), rng.uniform(0, 480));
  return pair;
}

Votes judged(const Pair& pair, const std::vector<std::int32_t>& reference) {
  MultiModelFilter filter;
  FrameEvidence evidence;
  Votes votes;
  for (const bool second : {false, true}) {
    FrameView view;
    view.id = second ? 1 : 0;
    view.keypoints = second ? pair.now : pair.then;
    if (second) view.matches = HostMatches{0, reference};
    evidence.begin(view, CallPoint::BeforePose);
    votes.reset(view.size());
    if (second) filter.apply(evidence, votes);
    evidence.end(false);
  }
  return votes;
}

std::vector<std::int32_t> in_order(std::size_t n) {
  std::vector<std::int32_t> reference(n);
  for (std::size_t i = 0; i < n; ++i) reference[i] = static_cast<std::int32_t>(i);
  return reference;
}

}  // namespace

TEST_CASE("multi_model: mismatches go, both motions stay") {
  const Pair pair = two_motions();
  const Votes votes = judged(pair, in_order(pair.now.size()));
  for (std::size_t i = 0; i < pair.good; ++i) CHECK(votes[i] == Vote::Static);
  int found = 0;
  for (std::size_t i = pair.good; i < votes.size(); ++i) found += votes[i] == Vote::Dynamic ? 1 : 0;
  CHECK(found >= 58);  // a few agree by chance
}

TEST_CASE("multi_model: permuted features get permuted votes") {
  Pair pair = two_motions();
  const Votes votes = judged(pair, in_order(pair.now.size()));
  std::reverse(pair.now.begin(), pair.now.end());
  std::vector<std::int32_t> reference = in_order(pair.now.size());
  std::reverse(reference.begin(), reference.end());
  const Votes reversed = judged(pair, reference);
  for (std::size_t i = 0; i < votes.size(); ++i) CHECK(reversed[votes.size() - 1 - i] == votes[i]);
}

TEST_CASE("multi_model: movers are no mismatches, wrong matches are") {
  MultiModelFilter filter;
  const ExactScene scene = testing::preset(Preset::General).mono();
  CHECK(Score(judge(filter, scene, 3), scene.frame(3)).dynamic_found == 0);
  const ExactScene wrong = testing::preset(Preset::General).mono().mismatches(0.3);
  const Votes votes = judge(filter, wrong, 3);
  const auto frame = wrong.frame(3);
  int right_lost = 0, right = 0;
  for (std::size_t i = 0; i < votes.size(); ++i)
    if (frame.mismatched[i] == 0) ++right, right_lost += votes[i] == Vote::Dynamic ? 1 : 0;
  CHECK(right_lost <= right / 20);
}

TEST_CASE("multi_model: nothing, little, identical, collinear, NaN: unknown, or kept") {
  MultiModelFilter filter;
  for (const int points : {0, 1, 2, 5}) {
    const Votes votes = judge(filter, ExactScene().points(points).mono(), 2);
    CHECK(votes.count(Vote::Unknown) == votes.size());
  }
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (int kind = 0; kind < 3; ++kind) {
    Pair pair;
    for (int i = 0; i < 30; ++i) {
      const auto x = static_cast<float>(10 * i);
      const cv::Point2f px = kind == 0   ? cv::Point2f(5, 5)
                             : kind == 1 ? cv::Point2f(x, x)
                                         : cv::Point2f(kNan, x);
      pair.now.emplace_back(px, 7.0F);
      pair.then.emplace_back(px, 7.0F);
    }
    CHECK(judged(pair, in_order(30)).count(Vote::Dynamic) == 0);
  }
}

}  // namespace multi_model_test
