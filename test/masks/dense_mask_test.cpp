// SPDX-License-Identifier: MIT
#include <dynfilter/dense/dense_mask.hpp>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"
#include "masks/mask_truth.hpp"

namespace dense_mask_test {

using namespace dynfilter;
using masks::MaskCounts;

const cv::Size kSize(640, 480);
const cv::Rect kMover(200, 120, 160, 200);

struct Feature {
  cv::KeyPoint keypoint;
  Vote decision = Vote::Unknown;
};
using Features = std::vector<Feature>;

struct Judged {
  std::vector<cv::KeyPoint> keypoints;
  Verdict verdict;
};
Judged judged(const Features& features) {
  Judged all;
  for (const Feature& f : features)
    all.keypoints.push_back(f.keypoint), all.verdict.decision.push_back(f.decision);
  return all;
}

/// Of a host's mask, 255 on what it drops.
cv::Mat drawn(const Features& features, const DepthImage& depth = {}) {
  const Judged all = judged(features);
  return DenseMask().image(all.keypoints, all.verdict, kSize, depth).clone();
}

/// A grid of features, those in the mover rejected.
Features grid(int step_px) {
  Features features;
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
  const Features features = grid(40);
  const cv::Mat mask = drawn(features);
  // The mover without half a step at each side is between its features.
  const cv::Rect between(kMover.x + 20, kMover.y + 20, kMover.width - 40, kMover.height - 40);
  CHECK(cv::countNonZero(mask(between)) == between.area());
  for (const Feature& f : features)
    CHECK((mask.at<std::uint8_t>(cv::Point(f.keypoint.pt)) != 0) == (f.decision == Vote::Dynamic));
  CHECK(iou(mask) > static_cast<double>(between.area()) / kMover.area());
}

TEST_CASE("two groups that are far apart are not joined") {
  Features features;
  for (const int left : {100, 400})
    for (int i = 0; i < 9; ++i)
      features.push_back(
          {cv::KeyPoint(static_cast<float>(left + 20 * (i % 3)), static_cast<float>(200 + 20 * (i / 3)), 31),
           Vote::Dynamic});
  const cv::Mat mask = drawn(features);
  CHECK(mask.at<std::uint8_t>(220, 120) != 0);
  CHECK(mask.at<std::uint8_t>(220, 420) != 0);
  CHECK(cv::countNonZero(mask(cv::Rect(200, 0, 160, 480))) == 0);
}

TEST_CASE("a few rejected features among kept ones are wrong matches") {
  Features features = grid(40);
  for (Feature& f : features) f.decision = Vote::Static;
  features[50].decision = features[51].decision = Vote::Dynamic;
  CHECK(cv::countNonZero(drawn(features)) == 0);
}

TEST_CASE("depth cuts the mask at the mover's outline") {
  // No kept feature limits the mask: a white wall is behind the mover.
  Features features;
  for (const Feature& f : grid(20))
    if (f.decision == Vote::Dynamic) features.push_back(f);
  cv::Mat depth(kSize, CV_16UC1, cv::Scalar(4000));
  depth(kMover).setTo(2000);
  const double without = iou(drawn(features));
  const double with = iou(drawn(features, {depth, 0.001}));
  CHECK(with > without);
  CHECK(with > 0.98);
}

TEST_CASE("a feature at the outline that reads the wall, or no depth, gets the depth of its neighbours") {
  Features features;
  for (const Feature& f : grid(20))
    if (f.decision == Vote::Dynamic) features.push_back(f);
  cv::Mat depth(kSize, CV_16UC1, cv::Scalar(4000));
  depth(kMover).setTo(2000);
  // Dark hair: the first row of features has no depth, and a wall is above.
  depth(cv::Rect(kMover.x, kMover.y, kMover.width, 20)).setTo(0);
  // Beside the mover, on the wall: the match followed the outline.
  const cv::Point beside(kMover.x - 10, kMover.y + 100);
  features.push_back({cv::KeyPoint(cv::Point2f(beside), 31), Vote::Dynamic});
  const cv::Mat mask = drawn(features, {depth, 0.001});
  CHECK(cv::countNonZero(mask(cv::Rect(kMover.x, 0, kMover.width, kMover.y))) == 0);
  CHECK(cv::countNonZero(mask(cv::Rect(0, 0, kMover.x, kSize.height))) == 0);
  CHECK(iou(mask) > 0.95);
}

TEST_CASE("polarity, restored features and holes in depth are those of the mask") {
  const Features features = grid(20);
  Judged all = judged(features);
  const cv::Mat depth = [] {
    cv::Mat image(kSize, CV_32FC1, cv::Scalar(4));
    image(kMover).setTo(2);
    return image;
  }();
  const cv::Mat mask = drawn(features, {depth, 1});
  DenseMask zero(MaskPolarity::ZeroDrops);
  CHECK(cv::countNonZero(zero.image(all.keypoints, all.verdict, kSize, {depth, 1}) != 255 - mask) == 0);
  CHECK(cv::countNonZero((zero.depth(all.keypoints, all.verdict, {depth, 1}) == 0) != mask) == 0);
  // What the floor gave back to the tracker is the mover's all the same.
  all.verdict.restored.assign(all.verdict.size(), 0);
  for (std::size_t i = 0; i < all.verdict.size(); ++i)
    if (all.verdict.decision[i] == Vote::Dynamic)
      all.verdict.decision[i] = Vote::Unknown, all.verdict.restored[i] = 1;
  CHECK(cv::countNonZero(DenseMask().image(all.keypoints, all.verdict, kSize, {depth, 1}) != mask) == 0);
}

TEST_CASE("odd input: no features, an empty image, depth of another size or type, features outside") {
  DenseMask dense;
  CHECK(cv::countNonZero(dense.image({}, Verdict(), kSize)) == 0);
  CHECK(dense.image({}, Verdict(), cv::Size()).empty());
  CHECK(dense.depth({}, Verdict(), {}).empty());
  Features features = grid(20);
  const cv::Mat mask = drawn(features);
  for (const cv::Mat& odd :
       {cv::Mat(10, 10, CV_32FC1, cv::Scalar(2)), cv::Mat(kSize, CV_8UC1, cv::Scalar(2))})
    CHECK(cv::countNonZero(drawn(features, {odd, 1}) != mask) == 0);
  for (const cv::Point2f p : {cv::Point2f(-5, 3), cv::Point2f(NAN, 3), cv::Point2f(640, 480)})
    features.push_back({cv::KeyPoint(p, 31), Vote::Dynamic});
  features.push_back(features.front());  // two in one place
  CHECK(cv::countNonZero(drawn(features) != mask) == 0);
}

TEST_CASE("half of the way to a kept feature is free, on one surface, too") {
  Features features;
  for (int y = 100; y <= 300; y += 10) {
    for (int x = 200; x <= 300; x += 10)
      features.push_back({cv::KeyPoint(static_cast<float>(x), static_cast<float>(y), 31), Vote::Dynamic});
    features.push_back({cv::KeyPoint(320, static_cast<float>(y), 31), Vote::Static});
  }
  const cv::Mat depth(kSize, CV_16UC1, cv::Scalar(2000));
  const cv::Mat mask = drawn(features, {depth, 0.001});
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

}  // namespace dense_mask_test
