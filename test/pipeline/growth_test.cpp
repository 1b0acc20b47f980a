// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <limits>
#include <string>
#include <vector>

#include "doctest/doctest.h"

namespace growth_test {

using namespace dynfilter;
using testing::ExactFrame;
using testing::ExactScene;
using testing::MovingBox;

namespace {

/// A third of the features on two movers.
std::vector<ExactFrame> frames(int size) {
  ExactScene scene;
  scene.points(size * 2 / 3).horizon(8).pixel_noise(0.3).depth_noise(0.0014);
  scene.mover(MovingBox(size / 6).at({-0.5, 0, 2.2}).moving({0.03, 0, 0.01}));
  scene.mover(MovingBox(size / 6).at({0.6, 0.1, 2.6}).moving({-0.02, 0.01, 0.02}));
  std::vector<ExactFrame> result;
  for (int k = 0; k < 6; ++k) result.push_back(scene.frame(k));
  return result;
}

struct Cost {
  double features = 0, ms = 0;
};

/// CPU time of the fastest of several runs over the frames: other programs only make it slower.
Cost cost(int size) {
  Pipeline pipeline(load_pipeline("dynfilter", builtin_filters()));
  const std::vector<ExactFrame> sequence = frames(size);
  Cost best{0, std::numeric_limits<double>::infinity()};
  for (const ExactFrame& frame : sequence) best.features += static_cast<double>(frame.size());
  for (int run = 0; run < 7; ++run) {
    pipeline.reset();
    const std::clock_t start = std::clock();
    for (const ExactFrame& frame : sequence) pipeline.before_pose(frame.view());
    best.ms = std::min(best.ms, 1000.0 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return best;
}

}  // namespace

// n log n, and twice that for a machine that is busy or whose caches are small. Quadratic work would take
// eight times that.
TEST_CASE("dynfilter: the time grows with n log n at most") {
  const Cost few = cost(1000), many = cost(16000);
  CAPTURE(few.ms);
  CAPTURE(many.ms);
  const double growth = many.features * std::log(many.features) / (few.features * std::log(few.features));
  CHECK(growth > 15);
  CHECK(many.ms < 2 * growth * few.ms);
}

}  // namespace growth_test
