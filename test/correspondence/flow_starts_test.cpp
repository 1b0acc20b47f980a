// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/correspondence/flow_starts.hpp>
#include <random>
#include <vector>

#include "doctest/doctest.h"

namespace flow_starts_test {

using namespace dynfilter;

namespace {

struct Features {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  DescribedFeatures view() const { return {keypoints, descriptors}; }
};

/// Each with a descriptor that is far from every other one's: 256 random bits.
Features features_at(const std::vector<cv::Point2f>& px, unsigned seed) {
  Features out;
  out.descriptors.create(static_cast<int>(px.size()), 32, CV_8UC1);
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < px.size(); ++i) {
    out.keypoints.emplace_back(px[i], 31.0F);
    for (int b = 0; b < 32; ++b)
      out.descriptors.at<unsigned char>(static_cast<int>(i), b) = static_cast<unsigned char>(random() >> 24U);
  }
  return out;
}

}  // namespace

TEST_CASE("flow_starts: at the match of the descriptor, as far as a near car jumps") {
  const Features now = features_at({{200, 100}, {500, 100}, {220, 100}, {300, 300}}, 1);
  Features then{now.keypoints, now.descriptors.clone()};
  then.keypoints[0].pt += {-90, 20};
  then.keypoints[1].pt += {0, 115};
  then.keypoints[3].pt += {125, 0};                         // too far
  then.descriptors.row(2) = 255 - then.descriptors.row(2);  // matches nothing
  FlowStarts starts;
  const Span<const cv::Point2f> px = starts.find(now.view(), then.view());
  REQUIRE(px.size() == 4);
  CHECK(px[0] == cv::Point2f(110, 120));
  CHECK(px[1] == cv::Point2f(500, 215));
  CHECK(std::isnan(px[2].x));
  CHECK(std::isnan(px[3].x));
}

TEST_CASE("flow_starts: without descriptors nothing is known") {
  const Features now = features_at({{100, 100}, {110, 100}}, 1);
  FlowStarts starts;
  for (const cv::Point2f& px : starts.find({now.keypoints, {}}, now.view())) CHECK(std::isnan(px.x));
  CHECK(starts.find({}, now.view()).empty());
  for (const cv::Point2f& px : starts.find(now.view(), {})) CHECK(std::isnan(px.x));
}

TEST_CASE("flow_starts: the order of the features does not matter") {
  std::mt19937 random(7);
  std::vector<cv::Point2f> px;
  for (int k = 0; k < 300; ++k)
    px.emplace_back(static_cast<float>(random() % 640), static_cast<float>(random() % 60));  // ties, too
  const Features now = features_at(px, 2);
  Features then{now.keypoints, now.descriptors.clone()};
  for (std::size_t i = 0; i < px.size(); ++i) then.keypoints[i].pt += {static_cast<float>(i % 40), 5};
  for (int i = 0; i < 300; i += 2) then.descriptors.row(i) = 255 - then.descriptors.row(i);
  Features turned{now.keypoints, now.descriptors.clone()};
  std::reverse(turned.keypoints.begin(), turned.keypoints.end());
  cv::flip(now.descriptors, turned.descriptors, 0);
  FlowStarts a, b;
  const Span<const cv::Point2f> one = a.find(now.view(), then.view()),
                                other = b.find(turned.view(), then.view());
  for (std::size_t i = 0; i < px.size(); ++i) {
    const cv::Point2f &p = one[i], &q = other[px.size() - 1 - i];
    CHECK((p == q || (std::isnan(p.x) && std::isnan(q.x))));
  }
}

}  // namespace flow_starts_test
