// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/motion/neighbour_field.hpp>
#include <limits>
#include <vector>

#include "doctest/doctest.h"

namespace neighbour_field_test {

using namespace dynfilter;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Feature {
  cv::Point2f px;
  float depth_m, value;
  float weight = 1;
};

/// With clusters, exact duplicates, missing depths and invalid positions.
std::vector<Feature> features(std::uint64_t seed, int count) {
  SampleGenerator rng(seed);
  std::vector<Feature> all;
  for (int i = 0; i < count; ++i) {
    const double spread = i % 3 == 0 ? 15 : 640;
    Feature f{{static_cast<float>(rng.uniform(0, spread)), static_cast<float>(rng.uniform(0, 0.75 * spread))},
              static_cast<float>(rng.uniform(1, 2)),
              static_cast<float>(rng.uniform(-2, 5))};
    if (i % 5 == 4) f.weight = 0;
    if (i % 11 == 0) f.depth_m = kNan;
    if (i % 13 == 0 && i > 0) f = all.back();
    if (i % 29 == 0) f.px.x = kNan;
    if (i % 31 == 0) f.px.y = 1e30F;
    all.push_back(f);
  }
  return all;
}

struct Built {
  NeighbourPlaces places;
  NeighbourPlaces::Field field;

  NeighbourPlaces::Sum around(const Feature& at, float reach_px) const {
    return places.around(field, at.px, at.depth_m, reach_px, 0.12F);
  }
};

Built field_of(const std::vector<Feature>& all, float cell_px) {
  std::vector<cv::Point2f> places_px;
  std::vector<float> depths_m;
  for (const Feature& f : all) places_px.push_back(f.px), depths_m.push_back(f.depth_m);
  Built built;
  built.places.build(places_px, depths_m, cell_px);
  built.places.lay_out(
      built.field, [&](std::size_t i) { return all[i].value; }, [&](std::size_t i) { return all[i].weight; });
  return built;
}

/// Reference implementation of the definition, over all features.
void sum_around(const std::vector<Feature>& all, const Feature& at, double reach_px, double near_m,
                double& values, double& weights) {
  values = weights = 0;
  for (const Feature& f : all) {
    if (!PointGrid::usable(f.px)) continue;
    const double dx = f.px.x - at.px.x, dy = f.px.y - at.px.y;
    const double weight = 1 - (dx * dx + dy * dy) / (reach_px * reach_px);
    if (weight <= 0 || std::abs(f.depth_m - at.depth_m) > static_cast<float>(near_m)) continue;
    values += weight * f.weight * f.value;
    weights += weight * f.weight;
  }
}

}  // namespace

TEST_CASE("neighbour field: what looking at every feature finds, whatever the cells and the reach") {
  for (const int count : {0, 1, 2, 3, 5, 50, 400}) {
    const std::vector<Feature> all = features(static_cast<std::uint64_t>(count) + 1, count);
    for (const float cell_px : {1.0F, 12.5F, 25.0F, 2000.0F}) {
      const Built field = field_of(all, cell_px);
      for (const float reach_px : {3.0F, 25.0F, 100.0F})
        for (const Feature& at : all) {
          const NeighbourPlaces::Sum found = field.around(at, reach_px);
          double values = 0, weights = 0;
          if (PointGrid::usable(at.px))
            sum_around(all, at, static_cast<double>(reach_px), 0.12, values, weights);
          CHECK(static_cast<double>(found.weights) == doctest::Approx(weights).epsilon(1e-4));
          CHECK(std::abs(static_cast<double>(found.values) - values) < 1e-3 * (1 + weights));
          CHECK(field.places.any_around(field.field, at.px, at.depth_m, reach_px, 0.12F) == (weights > 0));
        }
    }
  }
}

TEST_CASE("neighbour field: the order of the features does not matter, bit for bit") {
  std::vector<Feature> all = features(7, 300);
  const Built field = field_of(all, 25);
  const std::vector<Feature> asked = all;
  SampleGenerator rng(3);
  for (std::size_t i = all.size(); i-- > 1;)
    std::swap(all[i], all[rng.below(static_cast<std::uint32_t>(i + 1))]);
  const Built shuffled = field_of(all, 25);
  for (const Feature& at : asked) {
    const NeighbourPlaces::Sum a = field.around(at, 25), b = shuffled.around(at, 25);
    CHECK(a.values == b.values);
    CHECK(a.weights == b.weights);
  }
}

// Copies at one place with different values, as of a corner found at two scales.
TEST_CASE("neighbour field: nor does the order of different values at one place") {
  std::vector<Feature> all;
  for (int i = 0; i < 7; ++i)
    all.push_back({{10, 10}, i < 3 ? 1.0F : kNan, 1.0F / static_cast<float>(3 * i + 1)});
  const NeighbourPlaces::Sum sum = field_of(all, 25).around(all[0], 25);
  std::reverse(all.begin(), all.end());
  CHECK(field_of(all, 25).around(all[0], 25).values == sum.values);
  std::swap(all[0], all[5]);
  CHECK(field_of(all, 25).around(all[0], 25).values == sum.values);
}

TEST_CASE("neighbour field: nothing after clear()") {
  Built field = field_of(features(1, 50), 25);
  field.places.clear();
  CHECK(field.around({{5, 5}, 1.5F, 0}, 100).weights == 0.0F);
}

}  // namespace neighbour_field_test
