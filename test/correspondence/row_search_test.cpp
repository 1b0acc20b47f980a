// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <dynfilter/correspondence/row_search.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "doctest/doctest.h"
#include "random_texture.hpp"

namespace row_search_test {

using namespace dynfilter;

namespace {

const cv::Size kSize(320, 120);

/// Places at which a disparity of up to `most_px` stays in the image.
std::vector<cv::Point2f> places(int most_px) {
  std::vector<cv::Point2f> out;
  for (int y = 8; y < kSize.height - 8; y += 13)
    for (int x = most_px + 12; x < kSize.width - 12; x += 11)
      out.emplace_back(static_cast<float>(x), static_cast<float>(y));
  return out;
}

/// Both images of a wall. What the left one has at x, the right one has at x - disparity.
struct Pair {
  explicit Pair(double disparity_px, unsigned seed = 5) {
    const test::WaveTexture texture = test::WaveTexture::broad(seed);  // not saturated
    left = texture.image(kSize, cv::Point2d(0, 0));
    right = texture.image(kSize, cv::Point2d(disparity_px, 0));
  }
  cv::Mat left, right;
};

/// The whole disparity with the least sum of absolute differences, by definition.
int twin(const Pair& pair, const cv::Point2f& px, int most_px) {
  const int x = cvRound(px.x), y = cvRound(px.y);
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int d = 0; d <= most_px; ++d) {
    const cv::Rect here(x - 8, y - 4, 16, 9);
    const double now = cv::norm(pair.left(here), pair.right(here - cv::Point(d, 0)), cv::NORM_L1);
    if (now < least) least = now, best = d;
  }
  return best;
}

TEST_CASE("a wall's disparity is found to a fifth of a pixel, and so it is if one camera sees it brighter") {
  for (const double disparity_px : {0.0, 0.5, 3.3, 17.75, 64.0, 99.6}) {
    Pair pair(disparity_px);
    for (const int brighter : {0, 25}) {
      pair.right += cv::Scalar(brighter);
      const RowSearch search(pair.left, pair.right);
      std::size_t found = 0, all = 0;
      for (const cv::Point2f& px : places(100)) {
        const float column = search.column(px);
        ++all;
        if (std::isnan(column)) continue;
        ++found;
        CHECK(std::abs(px.x - column - disparity_px) < 0.2);
        if (brighter == 0)
          CHECK(std::abs(px.x - column -
                         static_cast<float>(twin(pair, px, std::min(110, cvRound(px.x) - 9)))) <= 1.01F);
      }
      CAPTURE(disparity_px);
      CAPTURE(brighter);
      CHECK(static_cast<double>(found) >= 0.95 * static_cast<double>(all));
    }
  }
}

TEST_CASE("no column: without texture along the row, beyond the largest disparity, and at the border") {
  const auto found = [](const cv::Mat& left, const cv::Mat& right, const std::vector<cv::Point2f>& at) {
    const RowSearch search(left, right);
    return std::count_if(at.begin(), at.end(),
                         [&](const cv::Point2f& px) { return !std::isnan(search.column(px)); });
  };
  const cv::Mat flat(kSize, CV_8UC1, cv::Scalar(90));
  CHECK(found(flat, flat, places(40)) == 0);
  cv::Mat rows(kSize, CV_8UC1);
  for (int y = 0; y < rows.rows; ++y) rows.row(y).setTo(cv::Scalar(y * 37 % 251));
  CHECK(found(rows, rows, places(40)) == 0);
  const test::WaveTexture here = test::WaveTexture::broad(5), elsewhere = test::WaveTexture::broad(9);
  const std::vector<cv::Point2f> wall = places(150);
  CHECK(found(here.image(kSize, {}), elsewhere.image(kSize, {}), wall) <=
        static_cast<long>(wall.size() / 10));
  CHECK(found(here.image(kSize, {}), here.image(kSize, {200, 0}), wall) <=
        static_cast<long>(wall.size() / 10));
  const Pair near(5);
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const auto right = static_cast<float>(kSize.width), below = static_cast<float>(kSize.height);
  for (const cv::Point2f& px : std::vector<cv::Point2f>{{0, 50},
                                                        {9, 50},
                                                        {right, 50},
                                                        {right - 6, 50},
                                                        {100, 0},
                                                        {100, 3},
                                                        {100, below - 3},
                                                        {100, below},
                                                        {-4, 50},
                                                        {kNone, 50},
                                                        {100, kNone},
                                                        {1e9F, 50}})
    CHECK(std::isnan(RowSearch(near.left, near.right).column(px)));
  CHECK_FALSE(std::isnan(RowSearch(near.left, near.right).column({100, 50})));
}

/// Steps to the most alike of every second patch, or to one beside it, by definition.
int steps(const cv::Mat& from, const cv::Mat& to, const cv::Point& at, int direction, int most) {
  const cv::Rect here(at.x - 8, at.y - 4, 16, 9);
  const auto difference = [&](int step) {
    return cv::norm(from(here), to(here + cv::Point(direction * step, 0)), cv::NORM_L1);
  };
  int even = 0;
  for (int step = 0; step <= most; step += 2)
    if (difference(step) < difference(even)) even = step;
  int best = even;
  for (const int step : {even - 1, even + 1})
    if (step >= 0 && step <= most && difference(step) < difference(best)) best = step;
  return best;
}

TEST_CASE("patches that are left early change nothing: there and back are those of a full search") {
  constexpr int kMost_px = 40;
  Pair pair(17.75);
  cv::Mat noise(kSize, CV_8UC1);
  cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0, 60);
  pair.right = pair.right * 0.7 + noise;  // many a patch is nearly as like as the true one
  const int brighter = cvRound(cv::mean(pair.left)[0] - cv::mean(pair.right)[0]);
  const cv::Mat darker_left = pair.left - cv::Scalar(brighter),
                darker_right = pair.right + cv::Scalar(brighter);
  std::size_t found = 0, refused = 0;
  for (const cv::Point2f& px : places(kMost_px)) {
    const cv::Point at = px;
    const int most = std::min(kMost_px, at.x - 9), there = steps(darker_left, pair.right, at, -1, most);
    const cv::Point partner = at - cv::Point(there, 0);
    const int back =
        steps(darker_right, pair.left, partner, 1, std::min(kMost_px, kSize.width - 8 - partner.x));
    const float column = RowSearch(pair.left, pair.right).column(px, kMost_px);
    if (there == most || std::abs(back - there) > 1) {
      ++refused;
      CHECK(std::isnan(column));
    } else if (!std::isnan(column)) {
      ++found;
      CHECK(std::abs(px.x - column - static_cast<float>(there)) <= 1.0F);
    }
  }
  CHECK(found > 10);
  CHECK(refused > 10);
}

// A strip with a disparity of 30 px hides 26 px to the left of it, where the disparity is 4 px.
TEST_CASE("what the right camera does not see has no column") {
  constexpr int kNear_px = 30, kFar_px = 4, kFrom = 160, kTo = 220;
  Pair wall(kFar_px);
  const Pair strip(kNear_px, 8);
  strip.left.colRange(kFrom, kTo).copyTo(wall.left.colRange(kFrom, kTo));
  strip.right.colRange(kFrom - kNear_px, kTo - kNear_px)
      .copyTo(wall.right.colRange(kFrom - kNear_px, kTo - kNear_px));
  const RowSearch search(wall.left, wall.right);
  std::size_t hidden = 0, none = 0;
  for (int y = 8; y < kSize.height - 8; y += 7)
    for (int x = kFrom - 17; x <= kFrom - 9; x += 2) {
      ++hidden;
      none += std::isnan(search.column({static_cast<float>(x), static_cast<float>(y)})) ? 1U : 0U;
    }
  CHECK(static_cast<double>(none) >= 0.9 * static_cast<double>(hidden));
  for (int y = 8; y < kSize.height - 8; y += 7)
    CHECK(search.column({190, static_cast<float>(y)}) == doctest::Approx(190 - kNear_px).epsilon(0.002));
}

}  // namespace

}  // namespace row_search_test
