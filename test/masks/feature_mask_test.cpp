// SPDX-License-Identifier: MIT
#include "masks/feature_mask.hpp"

#include <opencv2/core.hpp>

#include "doctest/doctest.h"
#include "masks/mask_truth.hpp"

using namespace dynfilter::masks;
using dynfilter::Vote;

namespace feature_mask_test {

const cv::Size kSize(640, 480);
const cv::Rect kMover(200, 120, 160, 200);

/// A grid of features, those in the mover rejected.
std::vector<JudgedFeature> grid(int step_px) {
  std::vector<JudgedFeature> features;
  for (int y = step_px / 2; y < kSize.height; y += step_px)
    for (int x = step_px / 2; x < kSize.width; x += step_px)
      features.push_back({cv::KeyPoint(static_cast<float>(x), static_cast<float>(y), 31),
                          kMover.contains({x, y}) ? Vote::Dynamic : Vote::Static});
  return features;
}

cv::Mat labels() {
  cv::Mat truth = cv::Mat::zeros(kSize, CV_8UC1);
  truth(kMover).setTo(1);
  return truth;
}

double iou(const cv::Mat& mask) {
  MaskCounts counts;
  counts.add(mask, labels());
  return counts.intersection_over_union();
}

TEST_CASE("what is between the features of one group is masked, and no kept feature is") {
  FeatureMask drawer(kSize);
  const std::vector<JudgedFeature> features = grid(40);
  const cv::Mat& mask = drawer.draw(features, {});
  // The mover without half a step at each side is between its features.
  const cv::Rect between(kMover.x + 20, kMover.y + 20, kMover.width - 40, kMover.height - 40);
  CHECK(cv::countNonZero(mask(between)) == between.area());
  for (const JudgedFeature& f : features)
    CHECK((mask.at<std::uint8_t>(cv::Point(f.keypoint.pt)) != 0) == (f.decision == Vote::Dynamic));
  CHECK(iou(mask) > static_cast<double>(between.area()) / kMover.area());
}

TEST_CASE("two groups that are far apart are not joined") {
  FeatureMask drawer(kSize);
  std::vector<JudgedFeature> features;
  for (const int left : {100, 400})
    for (int i = 0; i < 9; ++i)
      features.push_back(
          {cv::KeyPoint(static_cast<float>(left + 20 * (i % 3)), static_cast<float>(200 + 20 * (i / 3)), 31),
           Vote::Dynamic});
  const cv::Mat& mask = drawer.draw(features, {});
  CHECK(mask.at<std::uint8_t>(220, 120) != 0);
  CHECK(mask.at<std::uint8_t>(220, 420) != 0);
  CHECK(cv::countNonZero(mask(cv::Rect(200, 0, 160, 480))) == 0);
}

TEST_CASE("a few rejected features among kept ones are wrong matches") {
  FeatureMask drawer(kSize);
  std::vector<JudgedFeature> features = grid(40);
  for (JudgedFeature& f : features) f.decision = Vote::Static;
  features[50].decision = features[51].decision = Vote::Dynamic;
  CHECK(cv::countNonZero(drawer.draw(features, {})) == 0);
}

TEST_CASE("depth cuts the mask at the mover's outline") {
  FeatureMask drawer(kSize);
  // No kept feature limits the mask: a white wall is behind the mover.
  std::vector<JudgedFeature> features;
  for (const JudgedFeature& f : grid(20))
    if (f.decision == Vote::Dynamic) features.push_back(f);
  cv::Mat depth(kSize, CV_16UC1, cv::Scalar(4000));
  depth(kMover).setTo(2000);
  const double without = iou(drawer.draw(features, {}));
  const double with = iou(drawer.draw(features, {depth, 0.001}));
  CHECK(with > without);
  CHECK(with > 0.98);
}

TEST_CASE("half of the way to a kept feature is free, on one surface, too") {
  FeatureMask drawer(kSize);
  std::vector<JudgedFeature> features;
  for (int y = 100; y <= 300; y += 10) {
    for (int x = 200; x <= 300; x += 10)
      features.push_back({cv::KeyPoint(static_cast<float>(x), static_cast<float>(y), 31), Vote::Dynamic});
    features.push_back({cv::KeyPoint(320, static_cast<float>(y), 31), Vote::Static});
  }
  const cv::Mat depth(kSize, CV_16UC1, cv::Scalar(2000));
  const cv::Mat& mask = drawer.draw(features, {depth, 0.001});
  CHECK(cv::countNonZero(mask(cv::Rect(200, 100, 109, 200))) == 109 * 200);
  CHECK(cv::countNonZero(mask(cv::Rect(312, 100, 100, 200))) == 0);
}

TEST_CASE("shares of masks against labels") {
  cv::Mat mask = cv::Mat::zeros(kSize, CV_8UC1);
  mask(cv::Rect(kMover.x, kMover.y, kMover.width, kMover.height / 2)).setTo(255);
  mask(cv::Rect(0, 0, 100, 10)).setTo(255);
  MaskCounts counts;
  counts.add(mask, labels());
  CHECK(counts.movers_masked() == doctest::Approx(0.5));
  CHECK(counts.static_lost() == doctest::Approx(1000.0 / (640 * 480 - kMover.area())));
  CHECK(counts.intersection_over_union() == doctest::Approx(16000.0 / (kMover.area() + 1000)));
  CHECK(std::isnan(MaskCounts().intersection_over_union()));
}

}  // namespace feature_mask_test
