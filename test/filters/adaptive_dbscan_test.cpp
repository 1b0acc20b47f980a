// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/cluster/density_clusters.hpp>
#include <dynfilter/filters/dbscan.hpp>
#include <set>

#include "cluster/point_sets.hpp"
#include "doctest/doctest.h"

namespace adaptive_dbscan_test {

using namespace dynfilter;
using point_sets::Points;

namespace {

/// As published: the n x n matrix of distances with sorted rows.
std::vector<DbscanCandidate> from_matrix(const Points& all, int max_k) {
  Points points;
  for (const cv::Point3f& p : all)
    if (detail::finite(p)) points.push_back(p);
  const std::size_t n = points.size();
  std::vector<std::vector<float>> squared(n, std::vector<float>(n));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) squared[i][j] = detail::squared_distance(points[i], points[j]);
  for (auto& row : squared) std::sort(row.begin(), row.end());
  std::vector<DbscanCandidate> candidates;
  for (std::size_t k = 1; k <= static_cast<std::size_t>(max_k) && k < n; ++k) {
    DbscanCandidate c;
    for (const auto& row : squared) c.eps_m += std::sqrt(static_cast<double>(row[k]));
    c.eps_m *= (1 + 1e-5) / static_cast<double>(n);
    std::size_t neighbours = 0;
    for (const auto& row : squared)
      neighbours += static_cast<std::size_t>(
          std::upper_bound(row.begin(), row.end(), detail::squared_radius(c.eps_m)) - row.begin());
    if (c.eps_m >= DbscanParams::kMinEpsM && c.eps_m <= DbscanParams::kMaxEpsM) {
      c.min_points = static_cast<int>((neighbours + n - 1) / n);
      Clusters clusters;
      GridDbscan().run(points, {c.eps_m, c.min_points}, clusters);
      c.clusters = clusters.count;
    }
    candidates.push_back(c);
  }
  return candidates;
}

/// The third k of the first three in a row with equal, non-zero counts; 0: none.
int first_stable(const std::vector<DbscanCandidate>& c) {
  for (std::size_t k = 2; k < c.size(); ++k)
    if (c[k].clusters > 0 && c[k].clusters == c[k - 1].clusters && c[k].clusters == c[k - 2].clusters)
      return static_cast<int>(k) + 1;
  return 0;
}

void check_against_matrix(const Points& points) {
  const auto wanted = from_matrix(points, 30);
  AdaptiveDbscan adaptive;
  const AdaptiveDbscanChoice& choice = adaptive.choose(points);
  CHECK(choice.k == first_stable(wanted));
  CHECK(choice.found == (choice.k > 0));
  REQUIRE(choice.candidates.size() <= wanted.size());
  for (std::size_t k = 0; k < choice.candidates.size(); ++k) {
    CAPTURE(k);
    if (std::isfinite(wanted[k].eps_m))
      CHECK(choice.candidates[k].eps_m == doctest::Approx(wanted[k].eps_m).epsilon(1e-6));
    else
      CHECK_FALSE(std::isfinite(choice.candidates[k].eps_m));
    CHECK(choice.candidates[k].min_points == wanted[k].min_points);
    CHECK(choice.candidates[k].clusters == wanted[k].clusters);
  }
  if (choice.found) CHECK(choice.candidates.size() == static_cast<std::size_t>(choice.k));
}

}  // namespace

TEST_CASE("Eps_k, MinPts_k, cluster counts and the choice are those of the full distance matrix") {
  for (unsigned seed = 0; seed < 6; ++seed) {
    check_against_matrix(point_sets::blobs(220, 1 + static_cast<int>(seed) % 4, 0.15F, seed));
    check_against_matrix(point_sets::box(150, 1.0F, seed));
  }
}

TEST_CASE("distances to neighbours are those of a full search, bit for bit") {
  std::vector<Points> sets{point_sets::blobs(300, 3, 0.2F, 1), point_sets::box(200, 4, 2)};
  for (const auto& [name, points] : point_sets::awkward())
    if (name != "far apart" && points.size() > 17) sets.push_back(points);  // squares of those overflow
  detail::NeighbourDistances distances;
  for (Points& points : sets) {
    points.erase(
        std::remove_if(points.begin(), points.end(), [](const auto& p) { return !detail::finite(p); }),
        points.end());
    for (const std::size_t k : {std::size_t{1}, std::size_t{4}, std::size_t{17}}) {
      distances.measure(points, k);
      int wrong = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        std::vector<float> all;
        for (const cv::Point3f& p : points) all.push_back(detail::squared_distance(points[i], p));
        std::sort(all.begin(), all.end());
        REQUIRE(distances.of(i).size() == k + 1);
        wrong += std::equal(distances.of(i).begin(), distances.of(i).end(), all.begin()) ? 0 : 1;
      }
      CHECK(wrong == 0);
    }
  }
}

// Two pairs. Eps_1 is 1 (two clusters), Eps_2 9.5 and Eps_3 10.5 (the inner points are one cluster): no three
// in a row.
TEST_CASE("n points have n - 1 candidates, also if none is chosen") {
  AdaptiveDbscan adaptive;
  const AdaptiveDbscanChoice& choice = adaptive.choose(Points{{0, 0, 0}, {1, 0, 0}, {10, 0, 0}, {11, 0, 0}});
  CHECK_FALSE(choice.found);
  REQUIRE(choice.candidates.size() == 3);
  const double eps_m[] = {1, 9.5, 10.5};
  const int min_points[] = {2, 3, 4}, clusters[] = {2, 1, 1};
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(choice.candidates[k].eps_m == doctest::Approx(eps_m[k]).epsilon(1e-4));
    CHECK(choice.candidates[k].min_points == min_points[k]);
    CHECK(choice.candidates[k].clusters == clusters[k]);
  }
  for (unsigned seed = 0; seed < 20; ++seed)
    for (const int n : {4, 5, 6, 8}) check_against_matrix(point_sets::box(n, 1.0F, seed));
}

TEST_CASE("so they are for awkward points") {
  for (const auto& [name, points] : point_sets::awkward()) {
    const auto& shown = name;  // clang 14 captures no structured binding
    CAPTURE(shown);
    if (name == "none" || name == "one" || name == "two" || name == "only odd ones") {
      CHECK_FALSE(AdaptiveDbscan().choose(points).found);
      continue;
    }
    check_against_matrix(points);
  }
}

// On a line of spacing s, an inner point has two neighbours at s and two at 2 s.
// The two ends have theirs at s, 2 s, 3 s, 4 s.
// With 100 points Eps_1 = s, so inner points have 3 points within it, ends 2.
// The mean is 2.98, so MinPts_1 = 3.
TEST_CASE("a line, by hand") {
  const Points points = point_sets::line(100, 0.5F);
  AdaptiveDbscan adaptive;
  const AdaptiveDbscanChoice& choice = adaptive.choose(points);
  REQUIRE(choice.candidates.size() >= 2);
  CHECK(choice.candidates[0].eps_m == doctest::Approx(0.5).epsilon(1e-4));
  CHECK(choice.candidates[0].min_points == 3);
  CHECK(choice.candidates[0].clusters == 1);
  CHECK(choice.candidates[1].eps_m == doctest::Approx(0.5 * (98 * 1 + 2 * 2) / 100.0).epsilon(1e-4));
}

TEST_CASE("two people two metres apart never share a cluster, and most of them is clustered") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    Points points;
    point_sets::Source source(seed);
    for (int i = 0; i < 160; ++i)
      points.emplace_back((i % 2 == 0 ? -1.0F : 1.0F) + 0.15F * source.bell(), 0.3F * source.bell(),
                          2.5F + 0.08F * source.bell());
    const AdaptiveDbscanChoice choice = AdaptiveDbscan().choose(points);
    REQUIRE(choice.found);
    Clusters clusters;
    GridDbscan().run(points, choice.params, clusters);
    int clustered = 0;
    std::vector<std::set<int>> people(static_cast<std::size_t>(clusters.count));
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (clusters.label[i] < 0) continue;
      ++clustered;
      people[static_cast<std::size_t>(clusters.label[i])].insert(static_cast<int>(i % 2));
    }
    CHECK(clustered >= 96);
    for (const std::set<int>& in_cluster : people) CHECK(in_cluster.size() == 1);
  }
}

TEST_CASE("a long list of pairs is not kept, and that changes nothing") {
  // One cluster and a few distant points.
  // The mean distance exceeds the cluster, so nearly all pairs are within it.
  const Points points = point_sets::joined(point_sets::box(400, 0.05F, 2), point_sets::box(12, 60, 3));
  check_against_matrix(points);
}

TEST_CASE("of too many points some are looked at") {
  const Points points = point_sets::box(5000, 2, 3);
  AdaptiveDbscanLimits limits;
  limits.max_points = 500;
  Points some;
  for (std::size_t i = 0; i < 500; ++i) some.push_back(points[i * 10]);
  const AdaptiveDbscanChoice a = AdaptiveDbscan(limits).choose(points), b = AdaptiveDbscan().choose(some);
  CHECK(a.params.eps_m == b.params.eps_m);
  CHECK(a.k == b.k);
  limits.max_k = 2;
  CHECK_FALSE(AdaptiveDbscan(limits).choose(points).found);
}

}  // namespace adaptive_dbscan_test
