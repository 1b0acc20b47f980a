// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/motion/detail/view_motion_terms.hpp>
#include <dynfilter/motion/flow_groups.hpp>
#include <dynfilter/motion/ground_plane.hpp>
#include <dynfilter/motion/view_motion_search.hpp>
#include <numeric>

#include "../../examples/multi_model/sequential_homographies.hpp"
#include "doctest/doctest.h"

namespace background_motion_test {

using namespace dynfilter;
using multi_model::ImageMatch;
using multi_model::SequentialHomographies;

namespace {

constexpr double kFocal = 700;
constexpr ImageCells<double> kCells{1240, 380, 12, 6, 0.5};

/// Position of a point that was at (x, y) px and depth z. The camera moved by t and turned by a small angle
/// about the vertical axis.
ViewPair seen(double x, double y, double z, double tx, double ty, double tz, double turn) {
  const double X = x / kFocal * z - tx, Y = y / kFocal * z - ty, Z = z - tz;
  const double c = std::cos(turn), s = std::sin(turn);
  const double Xc = c * X - s * Z, Zc = s * X + c * Z;  // rays of the current camera, turned by +turn
  return {x, y, kFocal * Xc / Zc, kFocal * Y / Zc};
}

std::vector<int> all(std::size_t n) {
  std::vector<int> indices(n);
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

/// Static points all over the image, seen by a camera that drives and turns.
std::vector<ViewPair> road(int n, double tx, double tz, double turn) {
  SampleGenerator rng(7);
  std::vector<ViewPair> pairs;
  for (int i = 0; i < n; ++i)
    pairs.push_back(
        seen(rng.uniform(-500, 500), rng.uniform(-150, 150), rng.uniform(8, 40), tx, 0, tz, turn));
  return pairs;
}

}  // namespace

TEST_CASE("a static point's flow has nothing across its line, and its inverse depth") {
  ViewMotion motion;
  motion.focal_px = kFocal;
  motion.direction = {0.6, 0, 0.8};
  const ViewFlowModel model(motion);
  const ViewFlow flow = model(seen(200, -80, 12, 0.6, 0, 0.8, 0));
  CHECK(std::abs(flow.across_px) < 1e-9);
  CHECK(flow.inverse_depth == doctest::Approx(1.0 / 12).epsilon(1e-3));
  CHECK(flow.along_px > 0);
  // The same flow backwards is that of nothing static.
  const ViewPair p = seen(200, -80, 12, 0.6, 0, 0.8, 0);
  CHECK(model({p.x, p.y, p.reference_x, p.reference_y}).along_px < 0);
}

TEST_CASE("derivatives of flows by the camera's motion are those of differences") {
  constexpr double kStep = 1e-6;
  const ViewPair pair{210, -90, 260, -40};
  const auto turned = [](const std::array<double, 3>& turn, const double* by) {
    return turn[0] * by[0] + turn[1] * by[1] + turn[2] * by[2];
  };
  for (const double turn : {0.0, 0.3})
    for (const bool baseline : {false, true}) {
      ViewMotion motion;
      motion.focal_px = kFocal;
      motion.rotation_rad = {turn, -0.7 * turn, 0.5 * turn};
      motion.direction = {};
      if (baseline) motion.direction = {0.48, -0.6, 0.64};
      const auto difference = [&](int k, double ViewFlow::*member) {
        double there[5] = {}, back[5] = {};
        there[k] = kStep, back[k] = -kStep;
        const ViewFlowModel more(detail::stepped(motion, there)), less(detail::stepped(motion, back));
        return (more(pair).*member - less(pair).*member) / (2 * kStep);
      };
      const detail::ViewMotionTerms<double> terms(motion);
      const auto turns = detail::turns_by_step(motion.rotation_rad);
      double ahead = 0;
      if (baseline) {
        const auto t = terms.across(pair.reference_x, pair.reference_y, pair.x, pair.y, ahead);
        const double length = std::sqrt(t.squared);
        CHECK(t.cross / length == doctest::Approx(ViewFlowModel(motion)(pair).across_px));
        for (int k = 0; k < 3; ++k)
          CHECK(turned(turns[static_cast<std::size_t>(k)], t.by) / length ==
                doctest::Approx(difference(k, &ViewFlow::across_px)).epsilon(1e-6));
        for (int k = 3; k < 5; ++k)
          CHECK(t.by[k] / length == doctest::Approx(difference(k, &ViewFlow::across_px)).epsilon(1e-6));
      } else {
        const auto t = terms.rest(pair.reference_x, pair.reference_y, pair.x, pair.y, ahead);
        for (int k = 0; k < 3; ++k) {
          const auto& by = turns[static_cast<std::size_t>(k)];
          CHECK(turned(by, t.by[0]) == doctest::Approx(difference(k, &ViewFlow::across_px)).epsilon(1e-6));
          CHECK(turned(by, t.by[1]) == doctest::Approx(difference(k, &ViewFlow::along_px)).epsilon(1e-6));
        }
      }
      CHECK(ahead > 0);
      // Eight points at a time: the same to the precision of floats.
      const detail::ViewMotionTerms<detail::Pack> packs(motion);
      detail::Pack ahead8;
      const auto number = [](double value) { return detail::Pack(static_cast<float>(value)); };
      const auto t8 = packs.across(number(pair.reference_x), number(pair.reference_y), number(pair.x),
                                   number(pair.y), ahead8);
      const auto t = terms.across(pair.reference_x, pair.reference_y, pair.x, pair.y, ahead);
      for (int lane = 0; lane < detail::Pack::kWidth; ++lane)
        for (int k = 0; k < 5; ++k)
          CHECK(static_cast<double>(t8.by[k][lane]) == doctest::Approx(t.by[k]).epsilon(1e-3));
    }
}

TEST_CASE("a fit finds the motion from a start nearby, and leaves out what is behind the camera") {
  for (const bool baseline : {true, false}) {
    CAPTURE(baseline);
    std::vector<ViewPair> pairs = road(203, baseline ? 0.3 : 0, baseline ? 1.0 : 0, 0.03);
    ViewMotion start;
    start.focal_px = kFocal;
    if (!baseline) start.direction = {};
    std::vector<int> which = all(pairs.size());
    std::vector<double> weights(pairs.size(), 0.5);
    weights[7] = 0;
    pairs[7] = {500, 100, -500, -100};
    ViewMotionFit fit;
    fit.select(pairs, which, weights);
    const ViewMotion found = fit.refine(start, {1.0, 20, 0.0005});
    const ViewFlowModel model(found);
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (i != 7) CHECK(std::abs(model(pairs[i]).across_px) < 0.01);
    CHECK(std::abs(found.rotation_rad[1]) == doctest::Approx(0.03).epsilon(0.02));
    // Without anything to fit, it is the start.
    fit.select(pairs, {}, {});
    CHECK(fit.refine(start, {}).rotation_rad == start.rotation_rad);
  }
}

TEST_CASE("the camera's motion is found from nothing, exactly where there is no noise") {
  for (const double turn : {0.0, 0.03, -0.08})
    for (const double tx : {0.0, 0.5, -2.0}) {
      const std::vector<ViewPair> pairs = road(200, tx, 1.0, turn);
      ViewMotionEstimator estimator;
      const auto motion = estimator.estimate(pairs, all(pairs.size()), kCells, kFocal, std::nullopt);
      REQUIRE(motion.has_value());
      REQUIRE(motion->has_baseline());
      const ViewFlowModel model(*motion);
      double most = 0;
      for (const ViewPair& p : pairs) most = std::max(most, std::abs(model(p).across_px));
      CHECK(most < 0.05);
      CHECK(motion->direction[2] == doctest::Approx(1 / std::hypot(tx, 1.0)).epsilon(0.02));
      CHECK(std::abs(motion->rotation_rad[1]) == doctest::Approx(std::abs(turn)).epsilon(0.05));
    }
}

TEST_CASE("what covers the image is the background, not what has most of the points") {
  std::vector<ViewPair> pairs = road(150, 0, 1.0, 0);
  SampleGenerator rng(3);
  for (int i = 0; i < 500;
       ++i)  // 77 % of the points on a truck that drives to the right, on a quarter of the image
    pairs.push_back(seen(rng.uniform(100, 400), rng.uniform(-100, 150), 15, -1.5, 0.1, -0.5, 0));
  ViewMotionEstimator estimator;
  const auto motion = estimator.estimate(pairs, all(pairs.size()), kCells, kFocal, std::nullopt);
  REQUIRE(motion.has_value());
  const ViewFlowModel model(*motion);
  for (std::size_t i = 0; i < 150; ++i) CHECK(std::abs(model(pairs[i]).across_px) < 1);
  int found = 0;
  for (std::size_t i = 150; i < pairs.size(); ++i) {
    const ViewFlow flow = model(pairs[i]);
    found += std::abs(flow.across_px) > 1 || flow.along_px < -1 ? 1 : 0;
  }
  CHECK(found > 450);
}

TEST_CASE("a camera that only turns has no baseline, and flows count in every direction") {
  const std::vector<ViewPair> pairs = road(150, 0, 0, 0.02);
  ViewMotionEstimator estimator;
  const auto motion = estimator.estimate(pairs, all(pairs.size()), kCells, kFocal, std::nullopt);
  REQUIRE(motion.has_value());
  CHECK_FALSE(motion->has_baseline());
  const ViewFlowModel model(*motion);
  ViewPair moved = pairs[0];
  CHECK(model(moved).length_px() < 0.01);
  moved.x += 3;
  CHECK(model(moved).length_px() == doctest::Approx(3).epsilon(0.1));
}

TEST_CASE("too few points, or all in one place: no motion") {
  ViewMotionEstimator estimator;
  std::vector<ViewPair> pairs = road(11, 0, 1, 0);
  CHECK_FALSE(estimator.estimate(pairs, all(pairs.size()), kCells, kFocal, std::nullopt));
  pairs.assign(100, {5, 5, 6, 6});
  CHECK_FALSE(estimator.estimate(pairs, all(pairs.size()), kCells, kFocal, std::nullopt));
  CHECK_FALSE(estimator.estimate({}, {}, kCells, kFocal, std::nullopt));
}

// On the plane Y = h a point at row y below the horizon has depth f h / y: its inverse depth grows like y.
TEST_CASE("the ground is the lowest plane with support, also with a tilted horizon") {
  for (const double tilt : {0.0, 0.04, -0.06}) {
    CAPTURE(tilt);
    SampleGenerator rng(11);
    std::vector<GroundPoint> points;
    for (int i = 0; i < 60; ++i) {
      GroundPoint p;
      p.x = rng.uniform(-500, 500);
      p.y = rng.uniform(60, 180);
      p.inverse_depth = 0.002 * (p.y + tilt * p.x) * rng.uniform(0.98, 1.02);
      p.cell = kCells.of(p.x, p.y);
      points.push_back(p);
    }
    for (int i = 0; i < 100; ++i) {  // a car that comes: dense, and seems to hang in the air
      GroundPoint p{rng.uniform(-300, -200), rng.uniform(40, 90), 0, 0};
      p.inverse_depth = 0.3;
      p.cell = kCells.of(p.x, p.y);
      points.push_back(p);
    }
    GroundPlaneFinder finder;
    const auto plane = finder.find(points, {});
    REQUIRE(plane.has_value());
    CHECK(plane->scale == doctest::Approx(0.002).epsilon(0.06));
    CHECK(plane->tilt == doctest::Approx(tilt).epsilon(0.3));
  }
  GroundPlaneFinder finder;
  CHECK_FALSE(finder.find({}, {}));
}

std::vector<int> list(Span<const int> members) {
  return {members.begin(), members.end()};
}

TEST_CASE("groups are what chains of like neighbours hold together") {
  std::vector<cv::Point2d> points;
  for (int i = 0; i < 10; ++i) points.emplace_back(10.0 * i, 0);    // a chain
  for (int i = 0; i < 10; ++i) points.emplace_back(10.0 * i, 500);  // another, far away
  FlowGroups groups;
  groups.build(points, 30, 4, 0, [](std::size_t i, std::size_t j) { return (i == 4) == (j == 4); });
  // The fifth point is like no other: it is alone, and its neighbours reach each other past it.
  REQUIRE(groups.size() == 3);
  CHECK(groups.group(0).size() == 9);
  CHECK(list(groups.group(1)) == std::vector<int>{4});
  CHECK(groups.group(2).size() == 10);
  CHECK(groups.linked(4).empty());
  CHECK(groups.near(4).size() == 4);
}

TEST_CASE("a camera stands while traffic fills most of the view") {
  // Cars that cross to the right fit a camera that shifts to the left before a background at infinity.
  SampleGenerator rng(3);
  std::vector<ViewPair> pairs;
  std::vector<int> seeds;
  for (int i = 0; i < 400; ++i) {
    const double x = rng.uniform(-600, 600), y = rng.uniform(-180, 180);
    const bool crossing = y > -60;
    const double flow = crossing ? 6 + rng.uniform(0, 10) : 0, noise = rng.uniform(-0.05, 0.05);
    seeds.push_back(static_cast<int>(pairs.size()));
    pairs.push_back({x, y, x + flow + noise, y + noise});
  }
  const ImageCells<double> cells{1200, 360, 12, 6, 0.5};
  ViewMotionEstimator estimator;
  const auto found = estimator.estimate(pairs, seeds, cells, 700, std::nullopt);
  REQUIRE(found.has_value());
  CHECK_FALSE(found->has_baseline());
  CHECK(found->rotation_rad == std::array<double, 3>{});
  // Where the background moves as well, the camera does.
  for (ViewPair& p : pairs) p.x += 1;
  const auto moved = estimator.estimate(pairs, seeds, cells, 700, std::nullopt);
  REQUIRE(moved.has_value());
  CHECK(moved->rotation_rad != std::array<double, 3>{});
}

TEST_CASE("points of one patch are not each other's neighbours") {
  std::vector<cv::Point2d> points;
  for (int i = 0; i < 5; ++i) points.emplace_back(1.0 * i, 0);  // one corner
  points.emplace_back(20, 0);
  FlowGroups groups;
  groups.build(points, 30, 4, 8, [](std::size_t i, std::size_t j) { return (i < 5) == (j < 5); });
  CHECK(groups.size() == 6);
  CHECK(list(groups.near(0)) == std::vector<int>{5});
  groups.build(points, 30, 4, 0, [](std::size_t i, std::size_t j) { return (i < 5) == (j < 5); });
  CHECK(groups.size() == 2);
}

TEST_CASE("two moving planes among mismatches: the mismatches are what is left") {
  SampleGenerator rng(9);
  std::vector<ImageMatch> matches;
  for (int i = 0; i < 60; ++i) {
    const double x = rng.uniform(20, 300), y = rng.uniform(20, 460);
    matches.push_back({x, y, 1.1 * x + 0.05 * y + 30, 0.95 * y - 20});
  }
  for (int i = 0; i < 40; ++i) {
    const double x = rng.uniform(350, 620), y = rng.uniform(20, 460);
    matches.push_back({x, y, 0.9 * x - 200, 0.1 * x + y + 5});
  }
  for (int i = 0; i < 80; ++i)
    matches.push_back({rng.uniform(0, 640), rng.uniform(0, 480), rng.uniform(0, 640), rng.uniform(0, 480)});
  SequentialHomographies sequential;
  const std::vector<int>& label = sequential.fit(matches);
  CHECK(sequential.models() == 2);
  for (std::size_t i = 0; i < 100; ++i) CHECK(label[i] >= 0);
  int agreeing = 0;  // 80 matches x 2 models x 0.003: 0.5 by chance
  for (std::size_t i = 100; i < 180; ++i) agreeing += label[i] >= 0 ? 1 : 0;
  CHECK(agreeing <= 2);
  // A disc of this radius has 0.003 of the area, 640 x 480.
  CHECK(sequential.max_distance_px() ==
        doctest::Approx(std::sqrt(0.003 * 640 * 480 / 3.14159)).epsilon(0.05));
  CHECK(sequential.fit({}).empty());
  CHECK(sequential.models() == 0);
}

TEST_CASE("wrong matches alone make no homography") {
  for (const int n : {10, 50, 200, 500}) {
    CAPTURE(n);
    int models = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      SampleGenerator rng(seed);
      std::vector<ImageMatch> matches;
      for (int i = 0; i < n; ++i)
        matches.push_back(
            {rng.uniform(0, 640), rng.uniform(0, 480), rng.uniform(0, 640), rng.uniform(0, 480)});
      SequentialHomographies sequential;
      sequential.fit(matches);
      models += static_cast<int>(sequential.models());
    }
    CHECK(models <= 5);  // fewer than one expected each
  }
}

TEST_CASE("homographies do not depend on the unit of length") {
  SampleGenerator rng(9);
  std::vector<ImageMatch> matches, larger;
  for (int i = 0; i < 100; ++i) {
    const double x = rng.uniform(20, 600), y = rng.uniform(20, 460);
    matches.push_back({x, y, i < 60 ? x + 10 : rng.uniform(0, 640), i < 60 ? y - 5 : rng.uniform(0, 480)});
    const ImageMatch& m = matches.back();
    larger.push_back({4 * m.x, 4 * m.y, 4 * m.rx, 4 * m.ry});
  }
  SequentialHomographies small, large;
  CHECK(small.fit(matches) == large.fit(larger));
}

}  // namespace background_motion_test
