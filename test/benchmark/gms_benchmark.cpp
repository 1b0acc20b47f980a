// SPDX-License-Identifier: MIT
// GMS against a port of the published algorithm.
// Like opencv_contrib's matchGMS, which Debian's OpenCV lacks, it searches a dense matrix of cell pairs per
// grid placement row by row.
// `ratio` is the quotient of the medians in the same run, `equal` the share of equal decisions.
#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>

#include <cmath>
#include <dynfilter/filters/detail/grid_motion_statistics.hpp>
#include <random>

#include "benchmark/ratio.hpp"

using namespace dynfilter;

namespace {

constexpr std::size_t kSets = 8;
const cv::Size kSize(640, 480);

struct MatchSet {
  std::vector<cv::Point2f> first, second;
};

/// A camera that rotates and approaches, features at different depths, 30 % mismatches.
MatchSet matches(int n, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return static_cast<float>(low + (high - low) * static_cast<double>(random()) / 4294967296.0);
  };
  MatchSet set;
  for (int i = 0; i < n; ++i) {
    const cv::Point2f p(uniform(0, 640), uniform(0, 480));
    cv::Point2f q(320 + (p.x - 320) * 1.05F + 12 + 8 * std::sin(p.x / 90), 240 + (p.y - 240) * 1.05F - 5);
    if (uniform(0, 1) < 0.3F || q.x < 0 || q.y < 0 || q.x >= 639 || q.y >= 479)
      q = {uniform(0, 639), uniform(0, 479)};
    set.first.push_back(p);
    set.second.push_back(q);
  }
  return set;
}

/// The published algorithm, with its dense matrix.
class Published {
 public:
  void run(const MatchSet& set, std::vector<std::uint8_t>& inlier) {
    const std::size_t n = set.first.size();
    inlier.assign(n, 0);
    first_.resize(n), second_.resize(n), pair_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      first_[i] = {set.first[i].x / 640.0F, set.first[i].y / 480.0F};
      second_[i] = {set.second[i].x / 640.0F, set.second[i].y / 480.0F};
    }
    for (int type = 0; type < 4; ++type) {
      motion_ = cv::Mat::zeros(kCells, kCells, CV_32SC1);
      partner_.assign(kCells, -1);
      in_cell_.assign(kCells, 0);
      assign(type);
      verify();
      for (std::size_t i = 0; i < n; ++i)
        if (pair_[i].first >= 0 && partner_[static_cast<std::size_t>(pair_[i].first)] == pair_[i].second)
          inlier[i] = 1;
    }
  }

 private:
  static constexpr int kSide = 20, kCells = kSide * kSide;

  static int left(const cv::Point2f& p, int type) {
    const float dx = (type & 1) != 0 ? 0.5F : 0, dy = (type & 2) != 0 ? 0.5F : 0;
    const int x = static_cast<int>(std::floor(p.x * kSide + dx)),
              y = static_cast<int>(std::floor(p.y * kSide + dy));
    if (x >= kSide || y >= kSide || (dx > 0 && x < 1) || (dy > 0 && y < 1)) return -1;
    return x + y * kSide;
  }
  static int right(const cv::Point2f& p) {
    return static_cast<int>(std::floor(p.x * kSide)) + static_cast<int>(std::floor(p.y * kSide)) * kSide;
  }
  void assign(int type) {
    for (std::size_t i = 0; i < first_.size(); ++i) {
      const int l = left(first_[i], type), r = type == 0 ? right(second_[i]) : pair_[i].second;
      pair_[i] = {l, r};
      if (l < 0 || r < 0) continue;
      ++motion_.at<int>(l, r);
      ++in_cell_[static_cast<std::size_t>(l)];
    }
  }
  static int neighbour(int cell, int j) {
    const int x = cell % kSide + j % 3 - 1, y = cell / kSide + j / 3 - 1;
    return x < 0 || y < 0 || x >= kSide || y >= kSide ? -1 : x + y * kSide;
  }
  void verify() {
    for (int l = 0; l < kCells; ++l) {
      if (in_cell_[static_cast<std::size_t>(l)] == 0) continue;
      int most = 0, best = -1;
      for (int r = 0; r < kCells; ++r)
        if (motion_.at<int>(l, r) > most) most = motion_.at<int>(l, r), best = r;
      int score = 0, pairs = 0;
      double threshold = 0;
      for (int j = 0; j < 9; ++j) {
        const int ll = neighbour(l, j), rr = neighbour(best, j);
        if (ll < 0 || rr < 0) continue;
        score += motion_.at<int>(ll, rr);
        threshold += in_cell_[static_cast<std::size_t>(ll)];
        ++pairs;
      }
      partner_[static_cast<std::size_t>(l)] = score < 6.0 * std::sqrt(threshold / pairs) ? -2 : best;
    }
  }

  cv::Mat motion_;
  std::vector<int> partner_, in_cell_;
  std::vector<cv::Point2f> first_, second_;
  std::vector<std::pair<int, int>> pair_;
};

void gms(benchmark::State& state, GmsParams params) {
  std::vector<MatchSet> sets;
  for (unsigned s = 0; s < kSets; ++s) sets.push_back(matches(static_cast<int>(state.range(0)), s + 1));
  GridMotionStatistics statistics(params);
  Published published;
  std::vector<std::uint8_t> ours, theirs;
  bench::compare(
      state, kSets,
      [&](std::size_t s) { statistics.run(sets[s].first, kSize, sets[s].second, kSize, {}, ours); },
      [&](std::size_t s) { published.run(sets[s], theirs); });
  double equal = 0;
  for (const MatchSet& set : sets) {
    statistics.run(set.first, kSize, set.second, kSize, {}, ours);
    published.run(set, theirs);
    for (std::size_t i = 0; i < ours.size(); ++i) equal += ours[i] == theirs[i] ? 1 : 0;
  }
  state.counters["equal"] = equal / static_cast<double>(kSets * sets[0].first.size());
}

GmsParams as_published() {
  GmsParams params;
  params.grid_cells = 20;
  params.factor = 6;
  params.every_pair = false;
  return params;
}

}  // namespace

BENCHMARK_CAPTURE(gms, published, as_published())
    ->Arg(1000)
    ->Arg(2000)
    ->Arg(10000)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(gms, by_default, GmsParams())
    ->Arg(1000)
    ->Arg(2000)
    ->Arg(10000)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

BENCHMARK_MAIN();
