// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstddef>
#include <dynfilter/geometry/image_neighbours.hpp>
#include <random>
#include <utility>
#include <vector>

#include "doctest/doctest.h"
#include "support/time_limit.hpp"

namespace image_neighbours_test {

using dynfilter::ImageNeighbours;
using Point = ImageNeighbours::Point;

namespace {

std::vector<int> of_all(const std::vector<Point>& points, const Point& at, int self, std::size_t k,
                        double radius_px, double least_px) {
  std::vector<std::pair<double, int>> all;
  for (std::size_t j = 0; j < points.size(); ++j) {
    const double dx = points[j].x - at.x, dy = points[j].y - at.y, squared = dx * dx + dy * dy;
    if (static_cast<int>(j) != self && squared <= radius_px * radius_px && squared >= least_px * least_px)
      all.emplace_back(squared, static_cast<int>(j));
  }
  std::sort(all.begin(), all.end());
  std::vector<int> nearest;
  for (std::size_t j = 0; j < std::min(k, all.size()); ++j) nearest.push_back(all[j].second);
  return nearest;
}

std::vector<Point> square(std::size_t n, double side_px, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Point> points(n);
  for (Point& p : points) {
    p.x = 100 + side_px * static_cast<double>(random() % 4096U) / 4096;
    p.y = 50 + side_px * static_cast<double>(random() % 4096U) / 4096;
  }
  return points;
}

void check_against_all(const std::vector<Point>& points, double radius_px, double least_px) {
  ImageNeighbours grid;
  grid.build(points, radius_px);
  std::vector<int> found;
  int wrong = 0;
  for (std::size_t i = 0; i < points.size(); i += 7) {
    grid.nearest(points[i].x, points[i].y, static_cast<int>(i), 6, found, least_px);
    wrong += found == of_all(points, points[i], static_cast<int>(i), 6, radius_px, least_px) ? 0 : 1;
  }
  for (const Point& at : {Point{0, 0}, Point{-5e3, 80}, Point{120, 400}, Point{5e5, 5e5}}) {
    grid.nearest(at.x, at.y, -1, 6, found, least_px);
    wrong += found == of_all(points, at, -1, 6, radius_px, least_px) ? 0 : 1;
  }
  CHECK(wrong == 0);
}

}  // namespace

TEST_CASE("the nearest are those of a full search, however dense the points are") {
  for (const double side_px : {20.0, 300.0, 3000.0})
    for (const double least_px : {0.0, 8.0}) {
      std::vector<Point> points = square(1500, side_px, 3);
      check_against_all(points, 60, least_px);
      points.push_back({-9e5, 9e5});
      points.push_back({9e5, -9e5});
      check_against_all(points, 60, least_px);
    }
}

TEST_CASE("a radius around everything takes no more time than a small one") {
  const std::vector<Point> points = square(100'000, 320, 4);
  ImageNeighbours grid;
  std::vector<int> found;
  CHECK(dynfilter_test::seconds([&] {
          grid.build(points, 1000);
          for (std::size_t i = 0; i < points.size(); ++i)
            grid.nearest(points[i].x, points[i].y, static_cast<int>(i), 6, found, 8);
        }) < dynfilter_test::kMost_s);
}

}  // namespace image_neighbours_test
