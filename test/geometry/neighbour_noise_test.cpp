// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <optional>
#include <tuple>
#include <vector>

#include "doctest/doctest.h"
#include "rigid_scene.hpp"

namespace neighbour_noise_test {

using namespace dynfilter;

namespace {

/// The same by a full search: of each miss the nearest at least 3 px away with a depth within 10 %.
/// Of equals the first by row, then by column.
double scale_of_all(const std::vector<Miss>& misses, float reach_px) {
  std::vector<float> differences;
  for (const Miss& miss : misses) {
    std::optional<std::tuple<float, float, float, std::size_t>> best;
    for (std::size_t j = 0; j < misses.size(); ++j) {
      const cv::Point2f& place = misses[j].place_px;
      const float dx = place.x - miss.place_px.x, dy = place.y - miss.place_px.y, apart2 = dx * dx + dy * dy;
      if (apart2 > reach_px * reach_px || apart2 < 9) continue;
      if (std::abs(misses[j].depth_m - miss.depth_m) > 0.1F * miss.depth_m) continue;
      const auto found = std::make_tuple(apart2, place.y, place.x, j);
      best = best ? std::min(*best, found) : found;
    }
    if (!best) continue;
    const cv::Point2f d = miss.miss_px - misses[std::get<3>(*best)].miss_px;
    differences.push_back(d.dot(d) / 2);
  }
  return std::sqrt(static_cast<double>(median_in_place(differences)) / (2 * std::log(2.0)));
}

}  // namespace

TEST_CASE("the noise is that of a full search, also of points in rows and columns and in one place") {
  for (const double spacing_px : {0.0, 1.0, 4.0, 16.0})
    for (const double side_px : {60.0, 640.0}) {
      SampleGenerator rng(11);
      std::vector<Miss> misses;
      const auto draw = [&] { return static_cast<float>(rng.normal()); };
      const auto along = [&] {
        const double at = rng.uniform(0, side_px);
        return static_cast<float>(spacing_px > 0 ? spacing_px * std::round(at / spacing_px) : at);
      };
      for (int i = 0; i < 900; ++i) {
        const float x = along(), y = along(), error_px = draw();
        misses.push_back({{x, y}, static_cast<float>(rng.uniform(1, 3)), {error_px, draw()}, 1});
      }
      for (const float reach_px : {5.0F, 20.0F, 40.0F, 500.0F}) {
        CAPTURE(spacing_px);
        CAPTURE(side_px);
        CAPTURE(reach_px);
        NeighbourNoise estimator;
        const std::optional<double> scale = estimator.scale(misses, reach_px);
        if (scale) CHECK(*scale == doctest::Approx(scale_of_all(misses, reach_px)).epsilon(1e-9));
      }
    }
}

// A shift that all neighbours share does not count as noise, nor does its sign.
TEST_CASE("neighbours' differences show the noise, whatever they share") {
  for (const double sigma_px : {0.1, 2.0}) {
    CAPTURE(sigma_px);
    SampleGenerator rng(1);
    std::vector<Miss> misses;
    for (int i = 0; i < 2000; ++i) {
      const auto x = static_cast<float>(rng.uniform(0, 640)), y = static_cast<float>(rng.uniform(0, 480));
      const cv::Point2f noise(static_cast<float>(sigma_px * rng.normal()),
                              static_cast<float>(sigma_px * rng.normal()));
      misses.push_back({{x, y}, 2, cv::Point2f(7, -3) + noise, 1});
    }
    NeighbourNoise estimator;
    const auto scale = estimator.scale(misses, 40);
    REQUIRE(scale.has_value());
    CHECK(*scale > 0.93 * sigma_px);
    CHECK(*scale < 1.07 * sigma_px);
  }
  NeighbourNoise estimator;
  CHECK_FALSE(estimator.scale(std::vector<Miss>(10, Miss{{1, 1}, 2, {0, 0}, 1}), 40).has_value());
}

// Misses of variance s^2 per axis that patches of 40 px share, beside noise of 1 px of each: the whole has
// sqrt(1 + s^2). Half of the pairs may be movers' without any change beyond the bound.
TEST_CASE("the whole noise counts what neighbours share, up to a bound") {
  const auto scene = [](double shared_px, MissAxes axes) {
    SampleGenerator rng(7);
    std::vector<cv::Point2f> patches;
    const auto draw = [&](double sigma) {
      return cv::Point2f(static_cast<float>(sigma * rng.normal()),
                         axes == MissAxes::One ? 0 : static_cast<float>(sigma * rng.normal()));
    };
    for (int k = 0; k < 16 * 12; ++k) patches.push_back(draw(shared_px));
    std::vector<Miss> misses;
    for (int i = 0; i < 3000; ++i) {
      const auto x = static_cast<float>(rng.uniform(0, 640)), y = static_cast<float>(rng.uniform(0, 480));
      const auto patch = static_cast<std::size_t>(y / 40) * 16 + static_cast<std::size_t>(x / 40);
      misses.push_back({{x, y}, 2, patches[patch] + draw(1), 1});
    }
    return misses;
  };
  NeighbourNoise estimator;
  for (const MissAxes axes : {MissAxes::One, MissAxes::Two}) {
    const double alone = estimator.whole_scale(scene(0, axes), 40, axes).value_or(0);
    CHECK(alone == doctest::Approx(1).epsilon(0.07));
    const double with = estimator.whole_scale(scene(2, axes), 40, axes).value_or(0);
    CHECK(with == doctest::Approx(std::sqrt(5)).epsilon(0.15));
    // Shared ones of 100 px are motion, not noise.
    const double unshared = estimator.scale(scene(100, axes), 40, axes).value_or(0);
    const double bounded = estimator.whole_scale(scene(100, axes), 40, axes).value_or(0);
    CHECK(bounded == NeighbourNoise::kMostShared * unshared);
    CHECK(unshared < 1.5);
  }
  CHECK_FALSE(estimator.whole_scale(std::vector<Miss>(10, Miss{{1, 1}, 2, {0, 0}, 1}), 40).has_value());
}

}  // namespace neighbour_noise_test
