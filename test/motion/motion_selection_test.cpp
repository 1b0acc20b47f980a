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

/// Squared residuals of several motions at points. Rows are padded to whole fours.
struct Problem {
  Problem(std::size_t motion_count, std::size_t point_count)
      : motions(motion_count),
        points(point_count),
        stride((points + 3) / 4 * 4),
        image2_px2(motions * stride, 0.0F),
        depth2(motions * stride, 0.0F),
        weights(stride, 0.0F) {
    std::fill_n(weights.begin(), points, 1.0F);
  }

  float& image2(std::size_t h, std::size_t k) { return image2_px2[h * stride + k]; }
  float image2(std::size_t h, std::size_t k) const { return image2_px2[h * stride + k]; }
  MotionSelection::Input input() const {
    return {motions, stride, image2_px2, depth2, weights, price, noise_px};
  }

  std::size_t motions, points, stride;
  std::vector<float> image2_px2, depth2, weights;
  double price = 15, noise_px = 0.3;
};

// ---- the formulas of the header, written down again: exact logarithms, double, one set at a time

double loss(double chi2) {
  return 2.5 * std::log1p(chi2 / 3);
}

/// Nats that a set of motions costs.
double description(const Problem& p, const Motions& set) {
  const double s2 = p.noise_px * p.noise_px;
  double cost = p.price * static_cast<double>(set.size());
  for (std::size_t k = 0; k < p.points; ++k) {
    double least = loss(10 * 10 / s2);
    for (const std::size_t h : set)
      least = std::min(least, loss(static_cast<double>(p.image2(h, k)) / s2 +
                                   static_cast<double>(p.depth2[h * p.stride + k])));
    cost += static_cast<double>(p.weights[k]) * least;
  }
  return cost;
}

struct Best {
  double cost = 1e300;
  Motions set;
};
/// The shortest description of all sets of motions.
Best shortest(const Problem& p) {
  Best best;
  for (unsigned bits = 1; bits < 1U << p.motions; ++bits) {
    Motions set;
    for (std::size_t h = 0; h < p.motions; ++h)
      if ((bits >> h & 1U) != 0) set.push_back(h);
    if (const double cost = description(p, set); cost < best.cost) best = {cost, set};
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
        p.depth2[h * p.stride + k] = static_cast<float>(std::pow(rng.normal(), 2));
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
    for (std::size_t k = 0; k < p.points; ++k) p.weights[k] = static_cast<float>(rng.uniform(0.2, 1));
    const double cost = description(p, selection.select(p.input()));
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
// 2.1 nats a point, so 15 nats are reached between 7 and 8 points.
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
// first, and stays: beside both others it explains no point best, so it is never the background.
TEST_CASE("a motion that others made superfluous comes first and costs nothing but its price") {
  MotionSelection selection;
  CHECK(selection.select(compromise(0, 1).input()) == Motions{0, 1, 2});
  CHECK(selection.select(compromise(20, 1).input()) == Motions{0, 1, 2});
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

// Beyond 10 px every motion costs the same, so a second one only adds its price.
TEST_CASE("of motions that explain nothing, one is selected") {
  Problem p(5, 60);
  std::fill(p.image2_px2.begin(), p.image2_px2.end(), 400.0F);
  MotionSelection selection;
  CHECK(selection.select(p.input()) == Motions{0});
}

TEST_CASE("without motions nothing is selected") {
  MotionSelection selection;
  CHECK(selection.select(Problem(0, 10).input()).empty());
  CHECK(selection.select(Problem(0, 0).input()).empty());
}

TEST_CASE("pixels of another size change nothing") {
  Problem p = groups({120, 60}, 3, 0.3, 3, 7);
  MotionSelection selection;
  const Motions selected = selection.select(p.input());
  // The cut-off stays at 10 px. No residual reaches it before or after.
  for (float& image2 : p.image2_px2) image2 *= 4;
  p.noise_px *= 2;
  CHECK(selection.select(p.input()) == selected);
}

TEST_CASE("the order of points and motions does not matter") {
  const Problem p = groups({90, 50, 30}, 6, 0.3, 4, 9);  // motions that fill more than two packs of four
  MotionSelection selection;
  const Motions selected = selection.select(p.input());
  CHECK(selected == Motions{0, 1, 2});
  Problem turned = p;
  for (std::size_t h = 0; h < p.motions; ++h)
    for (std::size_t k = 0; k < p.points; ++k)
      turned.image2(p.motions - 1 - h,
                    p.points - 1 - k) = p.image2(h, k),
                                   turned.depth2[(p.motions - 1 - h) * p.stride + p.points - 1 - k] =
                                       p.depth2[h * p.stride + k];
  Motions back = selection.select(turned.input());
  for (std::size_t& h : back) h = p.motions - 1 - h;
  CHECK(back == selected);
}

TEST_CASE("padding and infinite residuals are harmless") {
  const Problem p = groups({90, 49}, 2, 0.3, 4, 11);
  Problem padded = p;
  for (std::size_t h = 0; h < p.motions; ++h) padded.image2(h, p.points) = static_cast<float>(-h) * 1e6F;
  MotionSelection selection;
  const Motions selected = selection.select(p.input());
  CHECK(selection.select(padded.input()) == selected);

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
      twice.depth2[h * twice.stride + k] = p.depth2[h * p.stride + k / 2];
    }
  std::fill_n(twice.weights.begin(), twice.points, 0.5F);
  MotionSelection selection;
  const Motions selected = selection.select(p.input());
  CHECK(selection.select(twice.input()) == selected);
}

}  // namespace motion_selection_test
