// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/motion/detail/motion_selection.hpp>
#include <numeric>
#include <vector>

#include "doctest/doctest.h"

namespace motion_selection_test {

using namespace dynfilter;

namespace {

using Motions = std::vector<std::size_t>;
const std::vector<double> kFactors = {0.63, 1.0, 1.6, 2.5, 4.0};

/// Squared residuals of several motions at points.
struct Problem {
  Problem(std::size_t motion_count, std::size_t point_count)
      : motions(motion_count),
        points(point_count),
        image2_px2(motions * points, 0.0F),
        depth2(motions * points, 0.0F),
        weights(points, 1.0F),
        prices(motions, 15.0F) {}

  float& image2(std::size_t h, std::size_t k) { return image2_px2[h * points + k]; }
  float image2(std::size_t h, std::size_t k) const { return image2_px2[h * points + k]; }
  MotionSelection::Input input() const {
    return {motions, points, points, image2_px2, depth2, weights, prices, noise_px};
  }

  std::size_t motions, points;
  std::vector<float> image2_px2, depth2, weights, prices;
  double noise_px = 0.3;
};

// ---- the formulas of the header, written down again: exact logarithms, double, one set at a time

double loss(double chi2) {
  return 2.5 * std::log1p(chi2 / 3);
}

/// Nats that a set of motions costs at a noise.
double description(const Problem& p, const Motions& set, double factor) {
  const double s2 = factor * factor * p.noise_px * p.noise_px;
  double cost = std::pow(std::log(factor) / 0.5, 2) / 2 * 30;
  for (const std::size_t h : set) cost += static_cast<double>(p.prices[h]);
  for (std::size_t k = 0; k < p.points; ++k) {
    double least = loss(10 * 10 / s2);
    for (const std::size_t h : set)
      least = std::min(least, loss(static_cast<double>(p.image2(h, k)) / s2 +
                                   static_cast<double>(p.depth2[h * p.points + k])));
    cost += static_cast<double>(p.weights[k]) * (least + 2 * std::log(factor * p.noise_px));
  }
  return cost;
}

struct Best {
  double cost = 1e300, factor = 0;
  Motions set;
};
/// The shortest description of all sets of motions and all noise levels.
Best shortest(const Problem& p) {
  Best best;
  for (const double factor : kFactors)
    for (unsigned bits = 1; bits < 1U << p.motions; ++bits) {
      Motions set;
      for (std::size_t h = 0; h < p.motions; ++h)
        if ((bits >> h & 1U) != 0) set.push_back(h);
      if (const double cost = description(p, set, factor); cost < best.cost) best = {cost, factor, set};
    }
  return best;
}

Motions sorted(Motions set) {
  std::sort(set.begin(), set.end());
  return set;
}

/// Points in groups: motion g explains group g, with Gaussian noise. Its other residuals are `apart_px`.
/// The motions after the groups explain nothing.
Problem groups(const std::vector<int>& sizes, std::size_t others, double sigma_px, double apart_px,
               std::uint64_t seed) {
  SampleGenerator rng(seed);
  const auto n = static_cast<std::size_t>(std::accumulate(sizes.begin(), sizes.end(), 0));
  Problem p(sizes.size() + others, n);
  std::size_t k = 0;
  for (std::size_t g = 0; g < sizes.size(); ++g)
    for (int i = 0; i < sizes[g]; ++i, ++k)
      for (std::size_t h = 0; h < p.motions; ++h) {
        const double x = sigma_px * rng.normal() + (h == g ? 0 : apart_px), y = sigma_px * rng.normal();
        p.image2(h, k) = static_cast<float>(x * x + y * y);
        p.depth2[h * n + k] = static_cast<float>(std::pow(rng.normal(), 2));
      }
  return p;
}

}  // namespace

// The polynomial for log(1 + x) is off by 3e-4 at most, which times 2.5 and a point's weight bounds the
// difference of the costs.
TEST_CASE("the description is as short as the shortest of all sets, or as greedy search finds it") {
  MotionSelection selection;
  int exact = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    CAPTURE(seed);
    SampleGenerator rng(100 + seed);
    Problem p = groups({80 + static_cast<int>(rng.below(60)), 20 + static_cast<int>(rng.below(40)),
                        static_cast<int>(rng.below(30))},
                       2, rng.uniform(0.1, 1), rng.uniform(1, 6), seed);
    for (float& weight : p.weights) weight = static_cast<float>(rng.uniform(0.2, 1));
    const Motions selected = selection.select(p.input());
    const double factor = selection.noise_px() / p.noise_px, cost = description(p, selected, factor);
    const Best best = shortest(p);
    const double slack = 2.5 * 3e-4 * static_cast<double>(p.points) * 2;
    CHECK(cost >= best.cost - 1e-6);
    CHECK(cost <= best.cost + 15);  // at worst one motion more
    exact += cost <= best.cost + slack ? 1 : 0;
  }
  CHECK(exact >= 38);
}

// 100 points at 5 px under the first motion: 2.5 log(1 + 25 / 0.27) = 11.3 nats each, far above a price of 15
// in sum. Under the motion that explains them: 0.
TEST_CASE("two motions that each explain a half are both selected, the larger one first") {
  Problem p(3, 220);
  for (std::size_t k = 0; k < 220; ++k) {
    p.image2(0, k) = k < 100 ? 0 : 25;
    p.image2(1, k) = k < 100 ? 25 : 0;
    p.image2(2, k) = 25;
  }
  MotionSelection selection;
  CHECK(selection.select(p.input()) == Motions{1, 0});
}

// At noise s, a group at distance e costs n 2.5 log(1 + e^2 / 3 s^2). With s = 0.3 px and e = 0.6 px that is
// 2.1 nats a point, so 15 nats are reached between 7 and 8 points. The least noise level, 0.63 s, is not
// chosen: residuals of 0.42 px in all other points fix the noise.
TEST_CASE("a second motion must save more than its price") {
  for (const int own : {4, 20}) {
    CAPTURE(own);
    const std::size_t n = 200;
    Problem p(2, n);
    for (std::size_t k = 0; k < n; ++k) {
      const bool second = k < static_cast<std::size_t>(own);
      p.image2(0, k) = second ? 0.36F : 0.18F;
      p.image2(1, k) = second ? 0 : 100;
    }
    MotionSelection selection;
    const Motions selected = sorted(selection.select(p.input()));
    CHECK(selected == shortest(p).set);
    CHECK(selected == (own == 4 ? Motions{0} : Motions{0, 1}));
  }
}

namespace {

/// A motion between two others: 0.6 px off everywhere, where each of the others explains one half exactly.
/// It also explains `own` points of its own, each with this weight.
Problem compromise(std::size_t own, float weight) {
  const std::size_t half = 100, n = 2 * half + own;
  Problem p(3, n);
  for (std::size_t k = 0; k < n; ++k) {
    p.image2(0, k) = k < 2 * half ? 0.36F : 0;
    p.image2(1, k) = k < half ? 0 : 25;
    p.image2(2, k) = k >= half && k < 2 * half ? 0 : 25;
    p.weights[k] = k < 2 * half ? 1 : weight;
  }
  return p;
}

}  // namespace

// At 0.3 px the cut-off is 2.5 log(1 + 100 / 0.27) = 14.8 nats. The compromise costs 2.1 nats a point and
// saves 12.7 nats at 200 points. Each of the others saves 14.8 at 100 points and 3.5 at 100. So it comes
// first.
// Beside both others it saves nothing at these points, and 11.3 nats at each of its own.
TEST_CASE("a motion that others made superfluous is dropped, unless it saves its price elsewhere") {
  MotionSelection selection;
  CHECK(sorted(selection.select(compromise(0, 1).input())) == Motions{1, 2});
  CHECK(sorted(selection.select(compromise(20, 0.02F).input())) == Motions{1, 2});  // 4.5 nats
  CHECK(selection.select(compromise(20, 1).input()) == Motions{0, 1, 2});           // 226 nats
}

// 100 points of weight 0.1 save less than 40 of weight 1.
TEST_CASE("the motion that saves most by weight comes first") {
  Problem p(2, 140);
  for (std::size_t k = 0; k < 140; ++k) {
    p.image2(0, k) = k < 100 ? 0 : 25;
    p.image2(1, k) = k < 100 ? 25 : 0;
    p.weights[k] = k < 100 ? 0.1F : 1;
  }
  MotionSelection selection;
  CHECK(selection.select(p.input()) == Motions{1, 0});
}

TEST_CASE("one motion only is selected, whatever it explains") {
  Problem p(1, 50);
  MotionSelection selection;
  CHECK(selection.select(p.input()) == Motions{0});
  std::fill(p.image2_px2.begin(), p.image2_px2.end(), 1e9F);
  CHECK(selection.select(p.input()) == Motions{0});
}

// Beyond 10 px every motion costs the same, so a second one only adds its price. The price decides.
TEST_CASE("of motions that explain nothing, the cheapest is selected alone") {
  Problem p(5, 60);
  std::fill(p.image2_px2.begin(), p.image2_px2.end(), 400.0F);
  p.prices = {15, 15, 8, 15, 15};
  MotionSelection selection;
  CHECK(selection.select(p.input()) == Motions{2});
}

TEST_CASE("without motions nothing is selected") {
  MotionSelection selection;
  CHECK(selection.select(Problem(0, 10).input()).empty());
  CHECK(selection.select(Problem(0, 0).input()).empty());
}

TEST_CASE("the noise is measured among the levels") {
  MotionSelection selection;
  for (const double factor : kFactors) {
    CAPTURE(factor);
    const Problem p = groups({400}, 3, 0.3 * factor, 40, 5);
    CHECK(selection.select(p.input()) == Motions{0});
    CHECK(selection.noise_px() == doctest::Approx(shortest(p).factor * 0.3));
    // A Student t with 3 degrees of freedom is fitted to Gaussian noise, so one level lower is right, too.
    CHECK(selection.noise_px() <= 0.3 * factor * 1.01);
    CHECK(selection.noise_px() >= 0.3 * factor * 0.61);
  }
}

TEST_CASE("pixels of another size change nothing but the noise") {
  Problem p = groups({120, 60}, 3, 0.3, 3, 7);
  MotionSelection selection;
  const Motions selected = selection.select(p.input());
  const double noise_px = selection.noise_px();
  // The cut-off stays at 10 px. No residual reaches it before or after.
  for (float& image2 : p.image2_px2) image2 *= 4;
  p.noise_px *= 2;
  CHECK(selection.select(p.input()) == selected);
  CHECK(selection.noise_px() == doctest::Approx(2 * noise_px));
}

TEST_CASE("the order of points and motions does not matter") {
  const Problem p = groups({90, 50, 30}, 6, 0.3, 4, 9);  // motions that fill more than two packs of four
  MotionSelection selection;
  const Motions selected = selection.select(p.input());
  const double noise_px = selection.noise_px();
  CHECK(selected == Motions{0, 1, 2});
  Problem turned = p;
  for (std::size_t h = 0; h < p.motions; ++h)
    for (std::size_t k = 0; k < p.points; ++k)
      turned.image2(p.motions - 1 - h,
                    p.points - 1 - k) = p.image2(h, k),
                                   turned.depth2[(p.motions - 1 - h) * p.points + p.points - 1 - k] =
                                       p.depth2[h * p.points + k];
  Motions back = selection.select(turned.input());
  for (std::size_t& h : back) h = p.motions - 1 - h;
  CHECK(back == selected);
  CHECK(selection.noise_px() == noise_px);
}

TEST_CASE("padding between the rows and infinite residuals are harmless") {
  const Problem p = groups({90, 50}, 2, 0.3, 4, 11);
  Problem wide(p.motions, p.points + 5);
  std::fill(wide.image2_px2.begin(), wide.image2_px2.end(), -1e30F);
  for (std::size_t h = 0; h < p.motions; ++h)
    for (std::size_t k = 0; k < p.points; ++k) {
      wide.image2(h, k) = p.image2(h, k);
      wide.depth2[h * wide.points + k] = p.depth2[h * p.points + k];
    }
  MotionSelection selection;
  const Motions selected = selection.select(p.input());
  MotionSelection::Input input = wide.input();
  input.points = p.points;
  CHECK(selection.select(input) == selected);

  Problem infinite = p;
  infinite.image2(3, 0) = infinite.image2(0, 1) = INFINITY;
  infinite.image2(3, 2) = NAN;
  CHECK(sorted(selection.select(infinite.input())) == sorted(selected));
}

TEST_CASE("a weight counts as that share of a point") {
  Problem p = groups({100, 40}, 1, 0.3, 4, 13);
  Problem twice(p.motions, 2 * p.points);
  for (std::size_t h = 0; h < p.motions; ++h)
    for (std::size_t k = 0; k < 2 * p.points; ++k) {
      twice.image2(h, k) = p.image2(h, k / 2);
      twice.depth2[h * twice.points + k] = p.depth2[h * p.points + k / 2];
    }
  std::fill(twice.weights.begin(), twice.weights.end(), 0.5F);
  MotionSelection selection;
  const Motions selected = selection.select(p.input());
  const double noise_px = selection.noise_px();
  CHECK(selection.select(twice.input()) == selected);
  CHECK(selection.noise_px() == noise_px);
}

}  // namespace motion_selection_test
