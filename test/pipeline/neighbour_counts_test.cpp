// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/pipeline/detail/neighbour_counts.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "doctest/doctest.h"
#include "support/time_limit.hpp"

namespace neighbour_counts_test {

using dynfilter::NeighbourCounts;
using Points = std::vector<cv::Point3f>;

namespace {

NeighbourCounts::Counts marks(std::uint32_t i) {
  return {i % 3 == 0 ? 1 : 0, i % 2 == 0 ? 1 : 0};
}

Points cloud(std::size_t n, unsigned steps, unsigned seed) {
  std::mt19937 random(seed);
  const auto draw = [&] { return static_cast<float>(random() % steps) / static_cast<float>(steps); };
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const float x = draw(), y = draw();
    points.emplace_back(x, y, draw());
  }
  return points;
}

}  // namespace

TEST_CASE("counts are those of all pairs") {
  for (const unsigned steps :
       {1U, 4U, 1000U}) {  // all at one place, on a lattice whose spacing is the radius, free
    Points points = cloud(700, steps, steps);
    points.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F);
    NeighbourCounts tree;
    tree.build(points);
    tree.mark(marks);
    const double radius_m = 0.25;
    int wrong = 0;
    for (const cv::Point3f& at : points) {
      NeighbourCounts::Counts expected;
      for (std::size_t j = 0; j < points.size(); ++j)
        if (dynfilter::detail::squared_distance(at, points[j]) <= dynfilter::detail::squared_radius(radius_m))
          expected.add(marks(static_cast<std::uint32_t>(j)));
      const NeighbourCounts::Counts found = tree.around(at, radius_m);
      wrong += found.first == expected.first && found.second == expected.second ? 0 : 1;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("100,000 points within the radius of each other") {
  const Points points = cloud(100'000, 1000, 7);
  NeighbourCounts tree;
  for (const double radius_m : {0.01, 0.3, 2.0})
    CHECK(dynfilter_test::seconds([&] {
            tree.build(points);
            tree.mark(marks);
            for (std::size_t i = 0; i < points.size(); i += 10) tree.around(points[i], radius_m);
          }) < dynfilter_test::kMost_s);
}

TEST_CASE("without points nothing is counted") {
  NeighbourCounts tree;
  CHECK(tree.around({0, 0, 0}, 1).first == 0);
  tree.build(Points());
  tree.mark(marks);
  CHECK(tree.around({0, 0, 0}, 1).second == 0);
}

}  // namespace neighbour_counts_test
