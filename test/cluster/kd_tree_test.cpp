// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/cluster/flann_neighbours.hpp>
#include <dynfilter/cluster/kd_tree.hpp>

#include "cluster/point_sets.hpp"
#include "doctest/doctest.h"

namespace kd_tree_test {

using namespace dynfilter;
using point_sets::Points;

namespace {

std::vector<KdTree::Neighbour> all_sorted(const Points& points, const cv::Point3f& query) {
  std::vector<KdTree::Neighbour> all;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (detail::finite(points[i]))
      all.push_back({detail::squared_distance(points[i], query), static_cast<std::int32_t>(i)});
  std::sort(all.begin(), all.end());
  return all;
}

int wrong_neighbours(const Points& points, const Points& queries) {
  KdTree tree;
  tree.build(points);
  FlannNeighbours flann;
  flann.build(points);
  std::vector<KdTree::Neighbour> found;
  std::vector<float> by_flann;
  int wrong = 0;
  for (const cv::Point3f& query : queries) {
    const auto all = all_sorted(points, query);
    for (const std::size_t k : {std::size_t{1}, std::size_t{4}, std::size_t{17}}) {
      tree.nearest(query, k, found);
      if (found.size() != std::min(k, all.size())) return -1;
      for (std::size_t i = 0; i < found.size(); ++i)
        wrong += found[i].index != all[i].index || found[i].squared_distance != all[i].squared_distance;
      flann.nearest(query, found.size(), by_flann);
      for (std::size_t i = 0; i < by_flann.size(); ++i)
        wrong += std::abs(by_flann[i] - all[i].squared_distance) > 1e-5F * all[i].squared_distance;
    }
    for (const double radius_m : {0.01, 0.125, 2.0}) {
      const KdTree::Neighbour near = tree.nearest_within(query, radius_m);
      const bool there = !all.empty() && all[0].squared_distance <= detail::squared_radius(radius_m);
      wrong += there ? near.index != all[0].index : near.index != -1;
    }
  }
  return wrong;
}

}  // namespace

TEST_CASE("the nearest neighbours are those of a full search, equal distances by index") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Points points = point_sets::blobs(300, 3, 0.2F, seed);
    CHECK(wrong_neighbours(points, points) == 0);
    CHECK(wrong_neighbours(points, point_sets::box(100, 4, seed + 50)) == 0);
  }
}

TEST_CASE("so they are for awkward points") {
  for (const auto& [name, points] : point_sets::awkward()) {
    const auto& shown = name;  // clang 14 captures no structured binding
    CAPTURE(shown);
    if (name == "far apart") continue;  // squared distances overflow
    Points queries;
    for (const cv::Point3f& p : points)
      if (detail::finite(p)) queries.push_back(p);
    CHECK(wrong_neighbours(points, queries) == 0);
  }
}

TEST_CASE("a query that is not finite finds nothing") {
  KdTree tree;
  tree.build(point_sets::box(50, 1, 1));
  std::vector<KdTree::Neighbour> found;
  tree.nearest({std::nanf(""), 0, 0}, 3, found);
  CHECK(found.empty());
  CHECK(tree.nearest_within({0, 0, std::numeric_limits<float>::infinity()}, 1e6).index == -1);
  tree.nearest({0, 0, 0}, 0, found);
  CHECK(found.empty());
}

}  // namespace kd_tree_test
