// SPDX-License-Identifier: MIT
#include "masks/run_mask.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"

using dynfilter::masks::RunMask;

namespace run_mask_test {

cv::Mat random_mask(int seed, cv::Size size) {
  cv::RNG random(static_cast<std::uint64_t>(seed));
  cv::Mat grey(size, CV_8UC1);
  random.fill(grey, cv::RNG::UNIFORM, 0, 256);
  return grey > 150;
}

cv::Mat painted(const RunMask& mask, cv::Size size) {
  cv::Mat image = cv::Mat::zeros(size, CV_8UC1);
  mask.paint(image);
  return image;
}

TEST_CASE("a mask comes back as it was, and counts as its pixels do") {
  const cv::Size size(37, 23);
  for (int seed = 1; seed < 20; ++seed) {
    const cv::Mat a = random_mask(seed, size), b = random_mask(100 + seed, size);
    const RunMask runs_a(a), runs_b(b);
    CHECK(cv::countNonZero(painted(runs_a, size) != a) == 0);
    CHECK(runs_a.area() == cv::countNonZero(a));
    CHECK(runs_a.box() == cv::boundingRect(a));
    CHECK(runs_a.overlap(runs_b) == cv::countNonZero(a & b));
    CHECK(runs_a.intersection_over_union(runs_b) ==
          doctest::Approx(static_cast<double>(cv::countNonZero(a & b)) / cv::countNonZero(a | b)));
    for (int y = -1; y <= size.height; ++y)
      for (int x = -1; x <= size.width; ++x) {
        const bool inside = x >= 0 && y >= 0 && x < size.width && y < size.height;
        CHECK(runs_a.contains({x, y}) == (inside && a.at<std::uint8_t>(y, x) != 0));
      }
  }
}

TEST_CASE("a crop has a place; a mask moves, grows and is cut at the border") {
  const cv::Size size(100, 80);
  const RunMask box(cv::Mat(10, 20, CV_8UC1, cv::Scalar(255)), {30, 40});
  CHECK(box.box() == cv::Rect(30, 40, 20, 10));
  CHECK(box.moved({7, -3}, 1, size).box() == cv::Rect(37, 37, 20, 10));
  CHECK(box.moved({0, 0}, 2, size).box() == cv::Rect(20, 35, 40, 20));
  CHECK(box.moved({60, 0}, 1, size).box() == cv::Rect(90, 40, 10, 10));
  CHECK(box.moved({80, 0}, 1, size).empty());
  CHECK(RunMask().moved({1, 1}, 1, size).empty());
  cv::Mat small = cv::Mat::zeros(45, 35, CV_8UC1);
  box.paint(small);  // part of it is outside
  CHECK(cv::countNonZero(small) == 5 * 5);
  CHECK(RunMask().intersection_over_union(RunMask()) == 0);
}

}  // namespace run_mask_test
