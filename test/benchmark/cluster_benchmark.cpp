// SPDX-License-Identifier: MIT
// GridDbscan against a FLANN radius loop, and the adaptive choice of parameters against the published sorted
// n x n matrix.
// `ratio` is the quotient of the medians in the same run.
// The points are those of a depth image: surfaces of a room with people.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <dynfilter/cluster/density_clusters.hpp>
#include <dynfilter/filters/dbscan.hpp>
#include <map>

#include "benchmark/ratio.hpp"
#include "cluster/flann_dbscan.hpp"
#include "cluster/point_sets.hpp"

using namespace dynfilter;
using dynfilter_test::flann_dbscan;
using point_sets::Points;

namespace {

constexpr std::size_t kSets = 8;

/// A floor, a wall and five people-sized cylinders, with noise.
Points room(int n, float scale, unsigned seed) {
  point_sets::Source source(seed);
  Points points;
  for (int i = 0; i < n; ++i) {
    const unsigned what = source.below(10);
    if (what == 0) {
      points.emplace_back(scale * source.uniform(-2, 2), 1.2F, scale * source.uniform(1, 4));
    } else if (what == 1) {
      points.emplace_back(scale * source.uniform(-2, 2), scale * source.uniform(-1, 1.2F), 4 * scale);
    } else {
      const auto person = static_cast<float>(what % 5);
      const float angle = source.uniform(0, 6.2832F), height = source.uniform(-0.8F, 0.8F);
      points.emplace_back(scale * (person - 2 + 0.25F * std::cos(angle)), scale * height,
                          scale * (2.5F + 0.2F * person + 0.15F * std::sin(angle)));
    }
    points.back() += cv::Point3f(source.bell(), source.bell(), source.bell()) * 0.01F;
  }
  return points;
}

std::vector<Points> rooms(int n, float scale) {
  std::vector<Points> sets;
  for (unsigned s = 0; s < kSets; ++s) sets.push_back(room(n, scale, s + 1));
  return sets;
}

/// Surfaces grow with n, so that the number of neighbours is constant.
void dbscan(benchmark::State& state) {
  const auto n = static_cast<int>(state.range(0));
  const auto sets = rooms(n, std::sqrt(static_cast<float>(n) / 1000.0F));
  const DbscanParams params{0.2, 6};
  GridDbscan grid;
  Clusters ours, theirs;
  bench::compare(
      state, kSets, [&](std::size_t s) { grid.run(sets[s], params, ours); },
      [&](std::size_t s) { flann_dbscan(sets[s], params, theirs); });
  state.counters["clusters"] = ours.count;
  state.counters["noise"] = static_cast<double>(std::count(ours.label.begin(), ours.label.end(), -1));
}

/// Eps_k and MinPts_k for k = 1 ... 30 from the sorted matrix, without clustering.
double published(const Points& points, std::vector<float>& matrix) {
  const std::size_t n = points.size();
  matrix.resize(n * n);
  for (std::size_t i = 0; i < n; ++i) {
    float* row = &matrix[i * n];
    for (std::size_t j = 0; j < n; ++j) row[j] = detail::squared_distance(points[i], points[j]);
    std::sort(row, row + n);
  }
  double sum = 0;
  for (std::size_t k = 1; k <= 30; ++k) {
    double eps_m = 0, neighbours = 0;
    for (std::size_t i = 0; i < n; ++i) eps_m += std::sqrt(static_cast<double>(matrix[i * n + k]));
    const float radius2 = detail::squared_radius(eps_m / static_cast<double>(n));
    for (std::size_t i = 0; i < n; ++i) {
      const float* row = &matrix[i * n];
      neighbours += static_cast<double>(std::upper_bound(row, row + n, radius2) - row);
    }
    sum += eps_m + neighbours;
  }
  return sum;
}

/// Ours includes all clusterings up to the choice, the reference none.
void adaptive(benchmark::State& state) {
  const auto sets = rooms(static_cast<int>(state.range(0)), 1);
  AdaptiveDbscanLimits limits;
  limits.max_points = 100000;
  AdaptiveDbscan adaptive(limits);
  std::vector<float> matrix;
  double k = 0;
  bench::compare(
      state, kSets, [&](std::size_t s) { k = adaptive.choose(sets[s]).k; },
      [&](std::size_t s) { benchmark::DoNotOptimize(published(sets[s], matrix)); });
  state.counters["k"] = k;
}

/// Uniform pixels of a 640 x 480 image, in the plane z = 0.
Points pixels(int n, unsigned seed) {
  point_sets::Source source(seed);
  Points points;
  for (int i = 0; i < n; ++i) points.emplace_back(source.uniform(0, 640), source.uniform(0, 480), 0.0F);
  return points;
}

constexpr std::size_t kNeighbours = 16;  // the first block of AdaptiveDbscan

/// Sorted distances to the nearest neighbours by a full search.
double full_search(const Points& points, std::vector<float>& row) {
  double sum = 0;
  row.resize(points.size());
  for (const cv::Point3f& p : points) {
    std::transform(points.begin(), points.end(), row.begin(),
                   [&](const cv::Point3f& q) { return detail::squared_distance(p, q); });
    std::partial_sort(row.begin(), row.begin() + kNeighbours + 1, row.end());
    for (std::size_t k = 0; k <= kNeighbours; ++k) sum += std::sqrt(static_cast<double>(row[k]));
  }
  return sum;
}

/// Distances of all points to their nearest neighbours, as the adaptive choice of Eps measures them.
/// With two dimensions the points are pixels of an image, with three those of a room.
void neighbour_distances(benchmark::State& state) {
  const auto n = static_cast<int>(state.range(1));
  std::vector<Points> sets = rooms(n, 1);
  if (state.range(0) == 2)
    for (unsigned s = 0; s < kSets; ++s) sets[s] = pixels(n, s + 1);
  detail::NeighbourDistances distances;
  std::vector<float> row;
  double ours = 0, theirs = 0;
  bench::compare(
      state, kSets,
      [&](std::size_t s) {
        ours = 0;
        distances.measure(sets[s], kNeighbours);
        for (std::size_t i = 0; i < sets[s].size(); ++i)
          for (const float d2 : distances.of(i)) ours += std::sqrt(static_cast<double>(d2));
      },
      [&](std::size_t s) { theirs = full_search(sets[s], row); });
  state.counters["relative_difference"] = std::abs(ours - theirs) / theirs;
}

}  // namespace

BENCHMARK(neighbour_distances)
    ->ArgsProduct({{2, 3}, {500, 1000, 2000, 5000, 10000}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(dbscan)->Arg(1000)->Arg(10000)->Arg(100000)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(adaptive)->Arg(500)->Arg(1000)->Arg(2000)->Arg(4000)->UseManualTime()->Unit(
    benchmark::kMillisecond);

BENCHMARK_MAIN();
