// SPDX-License-Identifier: MIT
#include <dynfilter/geometry/two_view.hpp>
#include <limits>

#include "doctest/doctest.h"
#include "geometry/two_view_scene.hpp"

using namespace dynfilter;
using namespace geometry_test;

TEST_CASE("two views: degenerate and odd input is None and never throws") {
  TwoViewEstimator estimator;
  const TwoViewScene scene(TwoViewRecipe{});
  const Camera cam = camera();
  for (int n = 0; n <= 19; ++n) {
    std::vector<int> few = scene.all();
    few.resize(n);
    CHECK(estimator.estimate(scene.reference, scene.current, few, &cam).kind == TwoViewKind::None);
  }
  estimator.options().min_seeds = 0;
  for (int n = 0; n <= 7; ++n) {
    std::vector<int> few = scene.all();
    few.resize(n);
    CHECK(estimator.estimate(scene.reference, scene.current, few).kind == TwoViewKind::None);
  }
  const std::vector<cv::Point2f> same(100, {320, 240});
  std::vector<int> all = scene.all();
  all.resize(100);
  CHECK(estimator.estimate(same, same, all, &cam).kind == TwoViewKind::None);
  std::vector<cv::Point2f> line;
  for (int i = 0; i < 100; ++i) line.emplace_back(5.0F * static_cast<float>(i), 3.0F * static_cast<float>(i));
  const TwoViewModel on_line = estimator.estimate(line, line, all, &cam);
  CHECK(on_line.kind == TwoViewKind::None);
  CHECK(on_line.reason == TwoViewReason::CollinearSeeds);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(estimator.estimate(std::vector<cv::Point2f>(100, {nan, nan}), same, all).kind == TwoViewKind::None);
  TwoViewRecipe chaos;
  chaos.static_count = 0, chaos.mismatch_count = 500;
  const TwoViewScene noise(chaos);
  CHECK(estimator.estimate(noise.reference, noise.current, noise.all(), &cam).kind == TwoViewKind::None);
}
