// SPDX-License-Identifier: MIT
#include <algorithm>
#include <odometry/spread.hpp>
#include <random>

#include "doctest/doctest.h"

namespace spread_test {

using dynfilter::odometry::Spreader;

namespace {
constexpr int kWidth = 640, kHeight = 480;

std::vector<cv::KeyPoint> random_corners(int n, float x0, float y0, float width, float height,
                                         unsigned seed) {
  std::mt19937 random(seed);
  std::vector<cv::KeyPoint> corners;
  for (int i = 0; i < n; ++i) {
    const float x = x0 + width * static_cast<float>(random() % 10000) / 10000.F;
    const float y = y0 + height * static_cast<float>(random() % 10000) / 10000.F;
    corners.emplace_back(x, y, 31.F, -1.F, static_cast<float>(random() % 255));
  }
  return corners;
}
}  // namespace

TEST_CASE("fewer corners than wanted all stay") {
  auto corners = random_corners(50, 0, 0, kWidth, kHeight, 1);
  CHECK(Spreader().spread(corners, {kWidth, kHeight}, 50).size() == 50);
  corners.clear();
  CHECK(Spreader().spread(corners, {kWidth, kHeight}, 50).empty());
}

TEST_CASE("a crowd does not take the places of the rest of the image") {
  auto corners = random_corners(3000, 100, 100, 60, 60, 2);  // strong texture in 1 % of the image
  for (auto& corner : corners) corner.response += 1000;
  const auto rest = random_corners(3000, 0, 0, kWidth, kHeight, 3);
  corners.insert(corners.end(), rest.begin(), rest.end());
  const auto taken = Spreader().spread(corners, {kWidth, kHeight}, 500);
  CHECK(taken.size() >= 475);
  CHECK(taken.size() <= 500);
  int cells[6][8] = {};
  for (const auto& k : taken) ++cells[static_cast<int>(k.pt.y / 80)][static_cast<int>(k.pt.x / 80)];
  for (const auto& row : cells)
    for (const int count : row) CHECK(count >= 4);  // 10.4 on average
  const auto crowd = std::count_if(taken.begin(), taken.end(), [](const cv::KeyPoint& k) {
    return k.pt.x > 100 && k.pt.x < 160 && k.pt.y > 100 && k.pt.y < 160;
  });
  CHECK(crowd < 25);
}

TEST_CASE("no two that stay are close, and of two close ones the stronger stays") {
  auto corners = random_corners(5000, 0, 0, kWidth, kHeight, 4);
  const auto taken = Spreader().spread(corners, {kWidth, kHeight}, 400);
  float closest = 1e9F;
  for (std::size_t i = 0; i < taken.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      closest = std::min(closest, std::max(std::abs(taken[i].pt.x - taken[j].pt.x),
                                           std::abs(taken[i].pt.y - taken[j].pt.y)));
  CHECK(closest > 8.F);  // a square of 16 px per corner would fill a third of the image
  const auto strongest = std::max_element(
      corners.begin(), corners.end(), [](const auto& a, const auto& b) { return a.response < b.response; });
  CHECK(taken.front().response == strongest->response);
}

TEST_CASE("the order of the corners does not matter") {
  auto corners = random_corners(2000, 0, 0, kWidth, kHeight, 5), reversed = corners;
  std::reverse(reversed.begin(), reversed.end());
  Spreader a, b;
  const auto& first = a.spread(corners, {kWidth, kHeight}, 300);
  const auto& second = b.spread(reversed, {kWidth, kHeight}, 300);
  REQUIRE(first.size() == second.size());
  bool same = true;
  for (std::size_t i = 0; i < first.size(); ++i) same = same && first[i].pt == second[i].pt;
  CHECK(same);
}

}  // namespace spread_test
