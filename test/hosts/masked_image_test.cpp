// SPDX-License-Identifier: MIT
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/hosts/masked_image.hpp>
#include <limits>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "doctest/doctest.h"

namespace masked_image_test {

using namespace dynfilter;

namespace {

/// Two features, 60 px apart: the first rejected, the second kept.
struct Case {
  std::vector<cv::KeyPoint> keypoints{{{40, 50}, 1.0F}, {{100, 50}, 1.0F}};
  Verdict verdict;
  cv::Size size{160, 100};
  Case() { verdict.decision = {Vote::Dynamic, Vote::Static}; }
};

cv::Mat noise(const cv::Size& size, int type) {
  cv::Mat image(size, type);
  std::mt19937 random(1);
  for (int y = 0; y < image.rows; ++y)
    for (std::size_t x = 0; x < image.elemSize() * static_cast<std::size_t>(image.cols); ++x)
      image.ptr(y)[x] = static_cast<std::uint8_t>(random());
  return image;
}

}  // namespace

TEST_CASE("the mask covers rejected features up to their radius and spares kept ones") {
  Case c;
  MaskedImageParams params;
  params.radius_px = 14;
  MaskedImage adapter(params);
  cv::Mat mask = adapter.mask(c.keypoints, c.verdict, c.size);
  CHECK(mask.at<std::uint8_t>(50, 40) == 255);
  CHECK(mask.at<std::uint8_t>(50, 53) == 255);
  CHECK(mask.at<std::uint8_t>(50, 56) == 0);
  CHECK(mask.at<std::uint8_t>(50, 100) == 0);
  c.keypoints[1].pt = {48, 50};  // a kept feature inside of the disc
  mask = adapter.mask(c.keypoints, c.verdict, c.size);
  CHECK(mask.at<std::uint8_t>(50, 48) == 0);
  CHECK(mask.at<std::uint8_t>(50, 34) == 255);
}

TEST_CASE("depth is none where the mask is set and untouched elsewhere, for either type") {
  const Case c;
  MaskedImage adapter;
  const cv::Mat mask = adapter.mask(c.keypoints, c.verdict, c.size);
  for (const int type : {CV_16UC1, CV_32FC1}) {
    cv::Mat depth(c.size, type, cv::Scalar(7)), out;
    MaskedImage::zero_depth(depth, mask, out);
    CHECK(cv::countNonZero(out) == c.size.area() - cv::countNonZero(mask));
    CHECK(cv::countNonZero(depth) == c.size.area());
    CHECK(cv::countNonZero(out != depth) == cv::countNonZero(mask));
  }
}

TEST_CASE("what is painted over holds no corners, the rest is untouched") {
  const Case c;
  MaskedImage adapter;
  const cv::Mat mask = adapter.mask(c.keypoints, c.verdict, c.size).clone();
  const cv::Mat image = noise(c.size, CV_8UC1);
  cv::Mat out;
  adapter.paint(image, mask, out);
  std::vector<cv::KeyPoint> before, after;
  cv::FAST(image, before, 20);
  cv::FAST(out, after, 20);
  const auto inside = [](const std::vector<cv::KeyPoint>& all) {
    return std::count_if(all.begin(), all.end(),
                         [](const cv::KeyPoint& k) { return cv::norm(k.pt - cv::Point2f(40, 50)) < 10; });
  };
  CHECK(inside(before) > 0);
  CHECK(inside(after) == 0);
  cv::Mat far;
  cv::dilate(mask, far, cv::Mat::ones(25, 25, CV_8U));
  CHECK(cv::countNonZero((out != image) & (far == 0)) == 0);
  adapter.paint(noise(c.size, CV_8UC3), mask, out);  // colour too
  CHECK(out.type() == CV_8UC3);
}

TEST_CASE("nothing rejected, NaN positions, other sizes: copies, no trouble") {
  Case c;
  c.verdict.decision = {Vote::Static, Vote::Unknown};
  MaskedImage adapter;
  const cv::Mat image = noise(c.size, CV_8UC1);
  cv::Mat out;
  adapter.paint(image, adapter.mask(c.keypoints, c.verdict, c.size), out);
  CHECK(cv::countNonZero(out != image) == 0);
  c.verdict.decision = {Vote::Dynamic, Vote::Dynamic};
  c.keypoints[0].pt.x = std::numeric_limits<float>::quiet_NaN();
  c.keypoints[1].pt.x = 1e6F;
  CHECK(cv::countNonZero(adapter.mask(c.keypoints, c.verdict, c.size)) == 0);
  const cv::Mat other(20, 20, CV_16UC1, cv::Scalar(3));
  MaskedImage::zero_depth(other, adapter.mask(c.keypoints, c.verdict, c.size), out);
  CHECK(cv::countNonZero(out) == 400);
}

}  // namespace masked_image_test
