// SPDX-License-Identifier: MIT
#include "masks/instances.hpp"

#include <opencv2/core.hpp>

#include "doctest/doctest.h"

using namespace dynfilter::masks;
using dynfilter::Detection;

namespace instances_test {

const cv::Size kSize(120, 80);

Detection box(const cv::Rect& at, const std::string& name) {
  Detection d;
  d.box = cv::Rect2f(at), d.class_name = name;
  return d;
}
cv::Mat blank() {
  return cv::Mat::zeros(kSize, CV_8UC1);
}

TEST_CASE("a box takes the detector's own mask") {
  std::vector<Detection> found{box({10, 10, 30, 40}, "car")};
  found[0].mask = blank();
  found[0].mask(cv::Rect(12, 12, 20, 30)).setTo(255);
  Semantics seen;
  seen.detections = &found;
  const std::vector<Instance> instances = instances_of(seen, kSize);
  REQUIRE(instances.size() == 1);
  CHECK(instances[0].mask.box() == cv::Rect(12, 12, 20, 30));
  CHECK(instances[0].class_name == "car");
}

TEST_CASE("the regions of one label that a box is around are one object, also if something cuts it") {
  const std::vector<Detection> found{box({10, 10, 60, 40}, "person"), box({52, 10, 40, 40}, "person")};
  Semantics seen;
  seen.detections = &found;
  seen.labels = blank();
  seen.labels(cv::Rect(52, 10, 40, 40)).setTo(9);  // behind the other one
  seen.labels(cv::Rect(10, 10, 20, 40)).setTo(7);
  seen.labels(cv::Rect(50, 10, 20, 40)).setTo(7);  // a pillar between them
  const std::vector<Instance> instances = instances_of(seen, kSize);
  REQUIRE(instances.size() == 2);
  CHECK(instances[1].mask.box() == cv::Rect(70, 10, 22, 40));
  CHECK(instances[0].mask.box() == cv::Rect(10, 10, 60, 40));
  CHECK(instances[0].mask.area() == 2 * 20 * 40);
}

TEST_CASE("two boxes share a region of two people; a box without pixels has no mask") {
  const std::vector<Detection> found{box({10, 10, 40, 40}, "person"), box({50, 10, 40, 40}, "person"),
                                     box({100, 60, 15, 15}, "car")};
  Semantics seen;
  seen.detections = &found;
  seen.labels = blank();
  seen.labels(cv::Rect(10, 10, 80, 40)).setTo(255);
  const std::vector<Instance> instances = instances_of(seen, kSize);
  REQUIRE(instances.size() == 2);
  CHECK(std::abs(instances[0].mask.box().width - 40) <= 1);
  CHECK(instances[0].mask.overlap(instances[1].mask) == 0);
  CHECK(instances[0].mask.area() + instances[1].mask.area() == 80 * 40);
}

TEST_CASE("without a mask the depth image shows the object in the box") {
  const std::vector<Detection> found{box({30, 20, 40, 40}, "cart")};
  Semantics seen;
  seen.detections = &found;
  seen.depth = cv::Mat(kSize, CV_16UC1, cv::Scalar(4000));
  seen.depth(cv::Rect(34, 22, 32, 36)).setTo(2000);
  seen.depth_unit_m = 0.001;
  const std::vector<Instance> instances = instances_of(seen, kSize);
  REQUIRE(instances.size() == 1);
  CHECK(instances[0].mask.box() == cv::Rect(34, 22, 32, 36));
}

TEST_CASE("a label image alone: its connected regions, at any size") {
  Semantics seen;
  seen.labels = cv::Mat::zeros(kSize / 2, CV_8UC1);
  seen.labels(cv::Rect(5, 5, 10, 20)).setTo(1);
  seen.labels(cv::Rect(30, 5, 10, 20)).setTo(1);
  seen.labels(cv::Rect(40, 5, 10, 20)).setTo(2);
  seen.labels(cv::Rect(0, 0, 2, 2)).setTo(3);  // too small to vote
  const std::vector<Instance> instances = instances_of(seen, kSize);
  REQUIRE(instances.size() == 3);
  CHECK(instances[0].mask.box() == cv::Rect(10, 10, 20, 40));
  CHECK(instances[2].class_name == "label 2");
  CHECK(instances_of({}, kSize).empty());
}

}  // namespace instances_test
