// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/cluster/density_clusters.hpp>
#include <limits>
#include <numeric>
#include <set>

#include "cluster/flann_dbscan.hpp"
#include "cluster/point_sets.hpp"
#include "doctest/doctest.h"

namespace dbscan_test {

using namespace dynfilter;
using dynfilter_test::flann_dbscan;
using point_sets::Points;

namespace {

/// The definition, all pairs: core points, clusters of core points as connected components.
struct Twin {
  Twin(const Points& points, const DbscanParams& params) : points_(points), params_(params) {
    const std::size_t n = points.size();
    core.assign(n, 0);
    component.assign(n, -1);
    for (std::size_t i = 0; i < n; ++i) {
      int neighbours = 0;
      for (std::size_t j = 0; j < n; ++j) neighbours += near(i, j) ? 1 : 0;
      core[i] = neighbours >= params.min_points ? 1 : 0;
    }
    for (std::size_t i = 0; i < n; ++i)
      if (core[i] != 0 && component[i] < 0) flood(i, count++);
  }
  bool near(std::size_t i, std::size_t j) const {
    return detail::finite(points_[i]) && detail::finite(points_[j]) &&
           detail::squared_distance(points_[i], points_[j]) <= detail::squared_radius(params_.eps_m);
  }
  /// Components of the core points near point i, which a border point may join.
  std::set<int> choices(std::size_t i) const {
    std::set<int> found;
    for (std::size_t j = 0; j < points_.size(); ++j)
      if (core[j] != 0 && near(i, j)) found.insert(component[j]);
    return found;
  }

  std::vector<std::uint8_t> core;
  std::vector<int> component;
  int count = 0;

 private:
  void flood(std::size_t start, int name) {
    std::vector<std::size_t> open{start};
    component[start] = name;
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      for (std::size_t j = 0; j < points_.size(); ++j)
        if (core[j] != 0 && component[j] < 0 && near(i, j)) component[j] = name, open.push_back(j);
    }
  }
  const Points& points_;
  DbscanParams params_;
};

void check_against_definition(const Points& points, const DbscanParams& params, const Clusters& clusters) {
  const Twin twin(points, params);
  REQUIRE(clusters.label.size() == points.size());
  CHECK(clusters.core == twin.core);
  REQUIRE(clusters.count == twin.count);
  std::vector<int> name(static_cast<std::size_t>(twin.count), -1);  // ours -> the twin's
  int wrong = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (twin.core[i] == 0) continue;
    REQUIRE(clusters.label[i] >= 0);
    int& known = name[static_cast<std::size_t>(clusters.label[i])];
    if (known < 0) known = twin.component[i];
    wrong += known != twin.component[i] ? 1 : 0;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (twin.core[i] != 0) continue;
    const std::set<int> choices = twin.choices(i);
    if (choices.empty())
      wrong += clusters.label[i] != Clusters::kNoise ? 1 : 0;
    else
      wrong += clusters.label[i] < 0 || choices.count(name[static_cast<std::size_t>(clusters.label[i])]) == 0;
  }
  CHECK(wrong == 0);
}

void check_both(const Points& points, const DbscanParams& params) {
  CAPTURE(params.eps_m);
  CAPTURE(params.min_points);
  Clusters clusters;
  GridDbscan().run(points, params, clusters);
  check_against_definition(points, params, clusters);
  flann_dbscan(points, params, clusters);
  check_against_definition(points, params, clusters);
}

}  // namespace

TEST_CASE("grid and FLANN give the clusters of the definition") {
  for (unsigned seed = 0; seed < 4; ++seed)
    for (const double eps_m : {0.03, 0.1, 0.3})
      for (const int min_points : {1, 2, 4, 9}) {
        check_both(point_sets::blobs(250, 4, 0.12F, seed), {eps_m, min_points});
        check_both(point_sets::box(250, 1.0F, seed), {eps_m, min_points});
      }
}

TEST_CASE("awkward distributions are clustered by the definition too") {
  for (const auto& [name, points] : point_sets::awkward()) {
    const auto& shown = name;  // clang 14 captures no structured binding
    CAPTURE(shown);
    for (const double eps_m : {0.001, 0.05, 0.125, 5.0})
      for (const int min_points : {1, 3, 7}) check_both(points, {eps_m, min_points});
  }
}

TEST_CASE("two blobs and a stray, by hand") {
  // Spacing 1: ends have 2 neighbours with themselves, inner points 3.
  const Points points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {10, 0, 0}, {11, 0, 0}, {12, 0, 0}, {50, 0, 0}};
  Clusters clusters;
  GridDbscan().run(points, {1.0, 3}, clusters);
  CHECK(clusters.count == 2);
  CHECK(clusters.label == std::vector<std::int32_t>{0, 0, 0, 1, 1, 1, -1});
  CHECK(clusters.core == std::vector<std::uint8_t>{0, 1, 0, 0, 1, 0, 0});
}

TEST_CASE("a point on the border of two clusters goes to the nearer core point") {
  // Cores at 1 and 3.8, with three points within 1 each.
  // The point at 2 is 1 from the first core and farther from the other.
  Points points{{0, 0, 0}, {1, 0, 0}, {1, 0.5F, 0}, {2, 0, 0}, {2.9F, 0, 0}, {2.9F, 0.5F, 0}, {3.8F, 0, 0}};
  Clusters clusters;
  GridDbscan().run(points, {1.0, 4}, clusters);
  REQUIRE(clusters.count == 2);
  CHECK(clusters.core[3] == 0);
  CHECK(clusters.label[3] == clusters.label[4]);
}

namespace {

/// The definition leaves the choice of a border point open. Ours is the nearest core point.
void check_borders(const Points& points, const DbscanParams& params) {
  Clusters clusters;
  GridDbscan().run(points, params, clusters);
  check_against_definition(points, params, clusters);
  int borders = 0, wrong = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (clusters.core[i] != 0 || clusters.label[i] < 0) continue;
    ++borders;
    std::size_t nearest = i;
    float nearest2 = std::numeric_limits<float>::infinity();
    for (std::size_t j = 0; j < points.size(); ++j) {
      const float d2 = detail::squared_distance(points[i], points[j]);
      if (clusters.core[j] != 0 && d2 < nearest2) nearest2 = d2, nearest = j;
    }
    wrong += clusters.label[i] != clusters.label[nearest] ? 1 : 0;
  }
  CHECK(borders > 10);
  CHECK(wrong == 0);
}

}  // namespace

// The dense ones have more than a hundred pairs to test for each point, so that they are clustered by cells.
TEST_CASE("border points go to the nearest core point, in sparse and in dense sets") {
  check_borders(point_sets::blobs(600, 4, 0.12F, 1), {0.1, 6});
  check_borders(point_sets::box(500, 1.0F, 2), {0.08, 3});
  check_borders(point_sets::blobs(1200, 3, 0.1F, 3), {0.15, 90});
  check_borders(point_sets::joined(point_sets::box(800, 0.5F, 4), point_sets::box(300, 2.0F, 5)),
                {0.25, 150});
}

// Two heaps of 300 points, each with a core point on the way to the other one, 0.9 and 0.8 from a point
// between them.
TEST_CASE("between dense clusters, too, a border point goes to the nearer core point") {
  for (const float side : {-1.0F, 1.0F}) {
    CAPTURE(side);
    Points points = point_sets::joined(Points(300, cv::Point3f(-1.8F * side, 0, 0)),
                                       Points(300, cv::Point3f(1.7F * side, 0, 0)));
    points.emplace_back(-0.9F * side, 0, 0);
    points.emplace_back(0.8F * side, 0, 0);
    points.emplace_back(0, 0, 0);
    Clusters clusters;
    GridDbscan().run(points, {1.0, 200}, clusters);
    REQUIRE(clusters.count == 2);
    CHECK(clusters.core[600] == 1);
    CHECK(clusters.core[601] == 1);
    CHECK(clusters.core[602] == 0);
    CHECK(clusters.label[602] == clusters.label[300]);
    CHECK(clusters.label[602] != clusters.label[0]);
  }
}

// Cores at -1 and +1 along an axis, each with two points of its own. The point at 0 is 1 from both.
TEST_CASE("of two core points at one distance the one with the smaller z, y and x counts, in any order") {
  const cv::Point3f axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                    sides[] = {{0, 0.5F, 0}, {0.5F, 0, 0}, {0.5F, 0, 0}};
  for (int axis = 0; axis < 3; ++axis)
    for (const bool turned : {false, true}) {
      CAPTURE(axis);
      CAPTURE(turned);
      const cv::Point3f &a = axes[axis], &s = sides[axis];
      Points points{-a, -a + s, -a - s, {0, 0, 0}, a, a + s, a - s};
      if (turned) std::reverse(points.begin(), points.end());
      Clusters clusters;
      GridDbscan().run(points, {1.0, 4}, clusters);
      REQUIRE(clusters.count == 2);
      CHECK(clusters.core[3] == 0);
      CHECK(clusters.label[3] == clusters.label[turned ? 6 : 0]);
    }
}

TEST_CASE("the order of the points does not matter") {
  const Points points = point_sets::joined(point_sets::lattice(4, 0.1F), point_sets::blobs(200, 3, 0.1F, 8));
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(3);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  Points shuffled;
  for (const std::size_t i : order) shuffled.push_back(points[i]);
  Clusters a, b;
  GridDbscan dbscan;
  dbscan.run(points, {0.1, 4}, a);
  dbscan.run(shuffled, {0.1, 4}, b);
  REQUIRE(a.count == b.count);
  std::vector<std::int32_t> name(static_cast<std::size_t>(a.count), -1);
  int wrong = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::int32_t la = a.label[order[k]], lb = b.label[k];
    wrong += (la < 0) != (lb < 0) || a.core[order[k]] != b.core[k] ? 1 : 0;
    if (la < 0 || lb < 0) continue;
    std::int32_t& known = name[static_cast<std::size_t>(la)];
    if (known < 0) known = lb;
    wrong += known != lb ? 1 : 0;
  }
  CHECK(wrong == 0);
}

TEST_CASE("heaps of equal points take no longer than others") {
  // 40,000 points in two separate clusters: all pairs would be 400 million.
  const Points heaps =
      point_sets::joined(Points(20000, cv::Point3f(0, 0, 0)), Points(20000, cv::Point3f(0.1001F, 0, 0)));
  Clusters clusters;
  GridDbscan().run(heaps, {0.1, 5}, clusters);
  CHECK(clusters.count == 2);
}

TEST_CASE("a radius or a count that makes no sense is refused") {
  Clusters clusters;
  CHECK_THROWS_AS(GridDbscan().run({}, {0.0, 4}, clusters), ConfigError);
  CHECK_THROWS_AS(GridDbscan().run({}, {std::nan(""), 4}, clusters), ConfigError);
  CHECK_THROWS_AS(GridDbscan().run({}, {0.1, 0}, clusters), ConfigError);
  CHECK_THROWS_AS(flann_dbscan({}, {-1, 4}, clusters), ConfigError);
}

}  // namespace dbscan_test
