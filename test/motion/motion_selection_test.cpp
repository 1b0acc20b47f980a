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
using detail::MotionSelection;

namespace {

using Motions = std::vector<std::size_t>;

/// Squared residuals of several motions at points. Rows are padded to whole eights.
struct Problem {
  Problem(std::size_t motion_count, std::size_t point_count)
      : motions(motion_count),
        points(point_count),
        stride((points + 7) / 8 * 8),
        image2_px2(motions * stride, 0.0F),
        depth2(motions * stride, 0.0F),
        weights(stride, 0.0F) {
    std::fill_n(weights.begin(), points, 1.0F);
  }

  float& image2(std::size_t h, std::size_t k) { return image2_px2[h * stride + k]; }
  float image2(std::size_t h, std::size_t k) const { return image2_px2[h * stride + k]; }
  MotionSelection::Input input() const {
    return {motions, stride, image2_px2, depth2, weights, price, fit_px};
  }

  std::size_t motions, points, stride;
  std::vector<float> image2_px2, depth2, weights;
  double price = 0.5, fit_px = 0.6;
};

// ---- the formulas of the header, written down again: double, one set at a time

/// What a set of motions explains, in points of weight 1.
double coverage(const Problem& p, const Motions& set) {
  const double s2 = p.fit_px * p.fit_px;
  double sum = 0;
  for (std::size_t k = 0; k < p.points; ++k) {
    double most = 0;
    for (const std::size_t h : set)
      most = std::max(most, 1 / (1 + static_cast<double>(p.image2(h, k)) / s2 +
                                 static_cast<double>(p.depth2[h * p.stride + k])));
    sum += static_cast<double>(p.weights[k]) * most;
  }
  return sum;
}
double value(const Problem& p, const Motions& set) {
  return coverage(p, set) - p.price * static_cast<double>(set.size());
}

/// Of all sets of at most `most` motions, the one with the largest value.
template <class Value>
double largest(const Problem& p, std::size_t most, const Value& value_of, Motions* best = nullptr) {
  double largest = -1e300;
  for (unsigned bits = 1; bits < 1U << p.motions; ++bits) {
    Motions set;
    for (std::size_t h = 0; h < p.motions; ++h)
      if ((bits >> h & 1U) != 0) set.push_back(h);
    if (set.size() > most || !(value_of(p, set) > largest)) continue;
    largest = value_of(p, set);
    if (best != nullptr) *best = set;
  }
  return largest;
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

// 1 - 1/e is the bound of the greedy search (Nemhauser, Wolsey and Fisher, 1978). It is met with much room.
TEST_CASE("the selection is worth as much as the best of all sets, or as greedy search finds") {
  MotionSelection selection;
  int exact = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    CAPTURE(seed);
    SampleGenerator rng(100 + seed);
    Problem p = groups({80 + static_cast<int>(rng.below(60)), 20 + static_cast<int>(rng.below(40)),
                        static_cast<int>(rng.below(30))},
                       2, rng.uniform(0.1, 1), rng.uniform(1, 6), seed);
    p.price = rng.uniform(0.5, 5);
    for (std::size_t k = 0; k < p.points; ++k) p.weights[k] = static_cast<float>(rng.uniform(0.2, 1));
    const Motions selected = selection.select(p.input());
    const double best = largest(p, p.motions, value);
    CHECK(value(p, selected) <= best + 1e-4);
    CHECK(value(p, selected) >= best - p.price);  // at worst one motion more
    CHECK(coverage(p, selected) >= (1 - std::exp(-1.0)) * largest(p, selected.size(), coverage));
    exact += value(p, selected) >= best - 1e-4 ? 1 : 0;
  }
  CHECK(exact >= 38);
}

TEST_CASE("each point is given to the selected motion that explains it best") {
  Problem p = groups({80, 40, 30}, 2, 0.4, 3, 17);
  MotionSelection selection;
  const Motions selected = selection.select(p.input());
  REQUIRE(selected.size() == 3);
  for (std::size_t k = 0; k < p.points; ++k) {
    CAPTURE(k);
    double most = 0;
    for (const std::size_t h : selected)
      most = std::max(most, 1 / (1 + static_cast<double>(p.image2(h, k)) / 0.36 +
                                 static_cast<double>(p.depth2[h * p.stride + k])));
    const std::size_t h = selected[selection.owner(k)];
    CHECK(static_cast<double>(selection.fit(k)) == doctest::Approx(most).epsilon(1e-4));
    CHECK(1 / (1 + static_cast<double>(p.image2(h, k)) / 0.36 +
               static_cast<double>(p.depth2[h * p.stride + k])) ==
          doctest::Approx(most).epsilon(1e-4));
  }
}

// The second half is 5 px off under the first motion: its fit is 1 / (1 + 25 / 0.36) = 0.014. So a motion of
// its own gains a hundred points, far above a price of a half.
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

// At a fit width of 0.6 px, a group at 0.6 px has a fit of a half. A motion of its own gains the other half:
// 2 points for a group of 4, and 10 for one of 20. The price is 5.
TEST_CASE("a second motion must gain more than its price") {
  for (const int own : {4, 20}) {
    CAPTURE(own);
    const std::size_t n = 200;
    Problem p(2, n);
    p.price = 5;
    for (std::size_t k = 0; k < n; ++k) {
      const bool second = k < static_cast<std::size_t>(own);
      p.image2(0, k) = second ? 0.36F : 0.18F;
      p.image2(1, k) = second ? 0 : 100;
    }
    MotionSelection selection;
    const Motions selected = sorted(selection.select(p.input()));
    Motions best;
    largest(p, 2, value, &best);
    CHECK(selected == best);
    CHECK(selected == (own == 4 ? Motions{0} : Motions{0, 1}));
  }
}

namespace {

/// A motion between two others: 0.3 px off everywhere, where each of the others explains one half exactly.
/// It also explains `own` points of its own, each with this weight.
Problem compromise(std::size_t own, float weight) {
  const std::size_t half = 100, n = 2 * half + own;
  Problem p(3, n);
  for (std::size_t k = 0; k < n; ++k) {
    p.image2(0, k) = k < 2 * half ? 0.09F : 0;
    p.image2(1, k) = k < half ? 0 : 25;
    p.image2(2, k) = k >= half && k < 2 * half ? 0 : 25;
    p.weights[k] = k < 2 * half ? 1 : weight;
  }
  return p;
}

}  // namespace

// Half a width off is a fit of 0.8. So the compromise explains 160 of 200 points, and each of the others 100.
// It comes first and stays: beside both others it explains no point best, so it is never the background.
TEST_CASE("a motion that others made superfluous comes first and costs nothing but its price") {
  MotionSelection selection;
  CHECK(selection.select(compromise(0, 1).input()) == Motions{0, 1, 2});
  CHECK(selection.select(compromise(20, 1).input()) == Motions{0, 1, 2});
}

// 100 points of weight 0.1 are worth less than 40 of weight 1.
TEST_CASE("the motion that explains most by weight comes first") {
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

// Each has a fit of 1 / (1 + 400 / 0.36) at the same points, so a second one only adds its price.
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
  for (float& image2 : p.image2_px2) image2 *= 4;
  p.fit_px *= 2;
  CHECK(selection.select(p.input()) == selected);
}

TEST_CASE("the order of points and motions does not matter") {
  const Problem p = groups({90, 50, 30}, 6, 0.3, 4, 9);  // motions that fill more than a pack
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
