// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/point_grid.hpp>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "doctest/doctest.h"
#include "support/time_limit.hpp"

namespace point_grid_test {

using dynfilter::PointGrid;
using dynfilter::Span;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::vector<cv::Point2f> random_points(int n, float low, float high, unsigned seed) {
  std::mt19937 random(seed);
  const auto draw = [&] { return low + (high - low) * static_cast<float>(random() % 65536U) / 65536.0F; };
  std::vector<cv::Point2f> points;
  for (int i = 0; i < n; ++i) {
    const float x = draw();
    points.emplace_back(x, draw());
  }
  return points;
}

std::vector<std::int32_t> visited(const PointGrid& grid, const cv::Point2f& centre, float radius_px) {
  std::vector<std::int32_t> found;
  grid.around(centre, radius_px, [&](std::int32_t i) { found.push_back(i); });
  return found;
}

using Points = std::vector<cv::Point2d>;

std::vector<int> nearest_of_all(const Points& points, const cv::Point2d& at,
                                const PointGrid::Nearest& wanted) {
  std::vector<std::pair<double, int>> all;
  for (std::size_t j = 0; j < points.size(); ++j) {
    const double dx = points[j].x - at.x, dy = points[j].y - at.y, squared = dx * dx + dy * dy;
    if (static_cast<int>(j) != wanted.self && squared <= wanted.radius_px * wanted.radius_px &&
        squared >= wanted.least_px * wanted.least_px)
      all.emplace_back(squared, static_cast<int>(j));
  }
  std::sort(all.begin(), all.end());
  std::vector<int> nearest;
  for (std::size_t j = 0; j < std::min<std::size_t>(static_cast<std::size_t>(wanted.count), all.size()); ++j)
    nearest.push_back(all[j].second);
  return nearest;
}

Points square(std::size_t n, double side_px, unsigned seed) {
  std::mt19937 random(seed);
  Points points(n);
  for (cv::Point2d& p : points) {
    p.x = 100 + side_px * static_cast<double>(random() % 4096U) / 4096;
    p.y = 50 + side_px * static_cast<double>(random() % 4096U) / 4096;
  }
  return points;
}

void check_nearest(const Points& points, double radius_px, double least_px) {
  PointGrid grid;
  grid.build_for_nearest(Span<const cv::Point2d>(points), static_cast<float>(radius_px / 2));
  std::vector<int> found;
  int wrong = 0;
  const auto check = [&](const cv::Point2d& at, int self) {
    const PointGrid::Nearest wanted{6, radius_px, least_px, self};
    grid.nearest(at, wanted, found);
    wrong += found == nearest_of_all(points, at, wanted) ? 0 : 1;
  };
  for (std::size_t i = 0; i < points.size(); i += 7) check(points[i], static_cast<int>(i));
  for (const cv::Point2d& at :
       {cv::Point2d(0, 0), cv::Point2d(-5e3, 80), cv::Point2d(120, 400), cv::Point2d(5e5, 5e5)})
    check(at, -1);
  CHECK(wrong == 0);
}

/// Checks that every usable point in the circle is visited and no point twice.
/// From a centre among the points, none is visited beyond the circle plus one cell.
/// Points outside belong to the outermost cells.
void check_against_all(const std::vector<cv::Point2f>& points, const std::vector<cv::Point2f>& centres,
                       float cell_px, float radius_px, float largest_cell_px) {
  PointGrid grid;
  grid.build(Span<const cv::Point2f>(points), cell_px);
  int missed = 0, twice = 0, far = 0;
  for (const cv::Point2f& centre : centres) {
    std::vector<std::int32_t> found = visited(grid, centre, radius_px);
    const bool among_points =
        std::any_of(points.begin(), points.end(),
                    [&](const cv::Point2f& p) { return p.x <= centre.x && p.y <= centre.y; }) &&
        std::any_of(points.begin(), points.end(),
                    [&](const cv::Point2f& p) { return p.x >= centre.x && p.y >= centre.y; });
    std::sort(found.begin(), found.end());
    twice += std::adjacent_find(found.begin(), found.end()) != found.end() ? 1 : 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double dx = static_cast<double>(points[i].x) - static_cast<double>(centre.x),
                   dy = static_cast<double>(points[i].y) - static_cast<double>(centre.y);
      const bool seen = std::binary_search(found.begin(), found.end(), static_cast<std::int32_t>(i));
      missed += PointGrid::usable(points[i]) && std::hypot(dx, dy) <= static_cast<double>(radius_px) && !seen;
      const double reach = static_cast<double>(radius_px + largest_cell_px) * 1.001;
      far += among_points && seen && (std::abs(dx) > reach || std::abs(dy) > reach);
    }
  }
  CHECK(missed == 0);
  CHECK(twice == 0);
  CHECK(far == 0);
}

}  // namespace

TEST_CASE("a grid visits what lies in a circle, each once, and little else") {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const auto points = random_points(400, -50, 700, seed), centres = random_points(60, -150, 800, seed + 9);
    for (const float cell_px : {3.0F, 20.0F, 2000.0F})
      for (const float radius_px : {0.0F, 2.0F, 45.0F})
        check_against_all(points, centres, cell_px, radius_px, std::max(cell_px, 750.0F / 256));
    check_against_all(points, points, 15, 30, 15);
  }
}

TEST_CASE("outliers do not make the cells of all others large") {
  auto points = random_points(3000, 100, 700, 5);
  points.emplace_back(-9e5F, -9e5F);
  points.emplace_back(9e5F, 9e5F);
  const auto centres = random_points(60, 0, 800, 6);
  check_against_all(points, centres, 20, 45, 20);
  check_against_all(points, {points.end() - 3, points.end()}, 20, 45, 20);
}

TEST_CASE("identical points, one point, none") {
  const std::vector<cv::Point2f> same(50, cv::Point2f(12.5F, 7.0F));
  check_against_all(same, same, 10, 0, 10);
  PointGrid grid;
  CHECK(visited(grid, {0, 0}, 10).empty());  // before anything was built
  grid.build(Span<const cv::Point2f>(same), 10);
  CHECK(visited(grid, {12.5F, 7}, 0).size() == 50);
  CHECK(visited(grid, {500, 500}, 1e9F).size() == 50);
  const std::vector<cv::Point2f> one{{3, 4}}, none;
  grid.build(Span<const cv::Point2f>(one), 10);
  CHECK(visited(grid, {3, 4}, 1) == std::vector<std::int32_t>{0});
  grid.build(Span<const cv::Point2f>(none), 10);
  CHECK(grid.empty());
  CHECK(visited(grid, {3, 4}, 1).empty());
}

TEST_CASE("coordinates that are none or beyond a million pixels are left out, large ones are found") {
  auto points = random_points(200, 0, 640, 4);
  points[3] = {kNan, 20}, points[9] = {20, kNan}, points[20] = {kInfinity, 0}, points[21] = {0, -kInfinity};
  points[40] = {1e30F, -1e30F}, points[41] = {-2e6F, 4};
  check_against_all(points, random_points(50, 0, 640, 5), 10, 30, 10);
  points[100] = {9e5F, -9e5F};  // makes cells of 7,000 px and more
  check_against_all(points, points, 10, 30, 8000);
  PointGrid grid;
  grid.build(Span<const cv::Point2f>(points), 10);
  CHECK(visited(grid, {0, 0}, kInfinity).size() == 200 - 6);
  for (const cv::Point2f& odd : {points[3], points[9], points[20], points[40]})
    CHECK(visited(grid, odd, 100).empty());
}

TEST_CASE("sizes of cells and circles that are none") {
  const auto points = random_points(100, 0, 640, 6);
  PointGrid grid;
  for (const float cell_px : {0.0F, -5.0F, kNan}) {
    grid.build(Span<const cv::Point2f>(points), cell_px);
    CHECK(visited(grid, {320, 240}, 1000).size() == 100);
  }
  CHECK(visited(grid, {320, 240}, kNan).size() <= 100);
  CHECK(visited(grid, {320, 240}, -50).empty());
}

TEST_CASE("every usable point is an entry of one cell, and ranges name the same points as around") {
  auto points = random_points(300, 0, 300, 7);
  points[5] = {kNan, 0};
  PointGrid grid;
  grid.for_each_cell([](std::size_t, std::size_t) { FAIL("nothing was built"); });
  grid.build(Span<const cv::Point2f>(points), 20);
  std::size_t next = 0;
  bool apart = false;
  grid.for_each_cell([&](std::size_t begin, std::size_t end) {
    CHECK(begin == next);
    next = end;
    for (std::size_t e = begin; e < end; ++e) {
      const cv::Point2f d = points[static_cast<std::size_t>(grid.entries()[e])] -
                            points[static_cast<std::size_t>(grid.entries()[begin])];
      apart = apart || std::abs(d.x) > 20.01F || std::abs(d.y) > 20.01F;
    }
  });
  CHECK(next == 299);
  CHECK_FALSE(apart);
  std::vector<std::int32_t> found;
  grid.ranges_around({150, 150}, 40, [&](std::size_t begin, std::size_t end) {
    found.insert(found.end(), grid.entries().begin() + static_cast<std::ptrdiff_t>(begin),
                 grid.entries().begin() + static_cast<std::ptrdiff_t>(end));
  });
  CHECK(found == visited(grid, {150, 150}, 40));
}

TEST_CASE("the nearest are those of a full search, however dense the points are") {
  for (const double side_px : {20.0, 300.0, 3000.0})
    for (const double least_px : {0.0, 8.0})
      for (const double radius_px : {0.0, 15.0, 60.0, 2000.0}) {
        Points points = square(700, side_px, 3);
        points.push_back(points[0]);  // twice the same
        check_nearest(points, radius_px, least_px);
        points.emplace_back(-9e5, 9e5);
        points.emplace_back(9e5, -9e5);
        check_nearest(points, radius_px, least_px);
      }
}

TEST_CASE("the nearest are told apart by less than a float resolves") {
  Points points;
  for (int i = 0; i < 40; ++i) points.emplace_back(3e5 + 1e-4 * ((7 * i) % 40), 50);
  check_nearest(points, 1, 0);
  for (cv::Point2d& p : points) std::swap(p.x, p.y);
  check_nearest(points, 1, 0);
}

TEST_CASE("of points that are as near, those with the smaller index come first") {
  Points points;
  for (int i = 0; i < 400; ++i) points.emplace_back(10 * ((7 * i) % 20), 10 * (i / 20));
  std::shuffle(points.begin(), points.end(), std::mt19937(8));
  check_nearest(points, 15, 0);
  check_nearest(points, 90, 8);
}

TEST_CASE("a radius around everything takes no more time than a small one") {
  const Points points = square(100'000, 320, 4);
  const auto taken_s = [&](double radius_px) {
    PointGrid grid;
    std::vector<int> found;
    return dynfilter_test::seconds([&] {
      grid.build_for_nearest(Span<const cv::Point2d>(points), static_cast<float>(radius_px / 2));
      for (std::size_t i = 0; i < points.size(); ++i)
        grid.nearest(points[i], {6, radius_px, 8, static_cast<int>(i)}, found);
    });
  };
  double ratio = 1e9;  // the quietest of three: machines share their processors
  for (int k = 0; k < 3; ++k) ratio = std::min(ratio, taken_s(1000) / taken_s(12));
  CHECK(ratio < 2);
}

TEST_CASE("keypoints are places too") {
  std::vector<cv::KeyPoint> keypoints;
  for (int x = 0; x < 100; x += 10) keypoints.emplace_back(static_cast<float>(x), 5.0F, 1.0F);
  PointGrid grid;
  grid.build(Span<const cv::KeyPoint>(keypoints), 5);
  CHECK(visited(grid, {30, 5}, 1) == std::vector<std::int32_t>{3});
}

}  // namespace point_grid_test
