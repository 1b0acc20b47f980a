// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/evidence/clean_frame.hpp>
#include <string>
#include <vector>

#include "doctest/doctest.h"
#include "support/time_limit.hpp"

namespace clean_frame_limits_test {

using namespace dynfilter;
using dynfilter_test::kMost_s;
using dynfilter_test::seconds;

namespace {

Detection box(float score, float x = 10) {
  Detection d;
  d.box = {x, 20, 30, 40};
  d.class_name = "person";
  d.score = score;
  return d;
}

}  // namespace

TEST_CASE("of a million boxes the best are used, in their order, and a note says so") {
  constexpr std::size_t kGiven = 1'000'000;
  std::vector<Detection> boxes(kGiven, box(0.25F));
  // The best boxes are spread: every 2000th. Of the others the first ones fill the rest.
  for (std::size_t k = 0; k < kGiven; k += 2000)
    boxes[k].score = 0.75F, boxes[k].class_id = static_cast<int>(k);
  FrameView frame;
  frame.detections = DetectionInput{-1, boxes};
  FrameCleaner cleaner;
  CHECK(seconds([&] { cleaner.clean(frame); }) < kMost_s);
  const auto kept = frame.detections->detections;
  REQUIRE(kept.size() == limits::kMaxBoxes);
  std::size_t best = 0, others = 0;
  int last = -1;
  for (const Detection& d : kept) {
    if (d.score < 0.5F) {
      ++others;
      continue;
    }
    ++best;
    CHECK(d.class_id > last);
    last = d.class_id;
  }
  CHECK(best == 500);
  CHECK(others == 500);
  REQUIRE(cleaner.notes().size() == 1);
  CHECK(cleaner.notes()[0] == "1000000 boxes: only the 1000 with the highest scores are used");
}

TEST_CASE("as many boxes as allowed are passed without a copy") {
  const std::vector<Detection> boxes(limits::kMaxBoxes, box(0.5F));
  FrameView frame;
  frame.detections = DetectionInput{-1, boxes};
  FrameCleaner cleaner;
  cleaner.clean(frame);
  CHECK(frame.detections->detections.data() == boxes.data());
  CHECK(cleaner.notes().empty());
}

TEST_CASE("a box with a score out of [0, 1] is not used") {
  const std::vector<Detection> boxes{box(5), box(0.5F, 1), box(-0.1F), box(NAN), box(1, 2), box(0, 3)};
  FrameView frame;
  frame.detections = DetectionInput{-1, boxes};
  FrameCleaner cleaner;
  cleaner.clean(frame);
  const auto kept = frame.detections->detections;
  REQUIRE(kept.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) CHECK(kept[k].box.x == static_cast<float>(k + 1));
  CHECK(cleaner.notes() == std::vector<std::string>{"3 of 6 boxes cannot be used"});
}

TEST_CASE("of more features than allowed none has a position, and a note says so") {
  std::vector<cv::KeyPoint> keypoints;
  for (std::size_t i = 0; i < limits::kMaxFeatures; ++i)
    keypoints.emplace_back(static_cast<float>(3 * (i % 400)), static_cast<float>(i / 400), 1.0F);
  FrameCleaner cleaner;
  FrameView frame;
  frame.keypoints = keypoints;
  cleaner.clean(frame);
  CHECK(frame.keypoints.data() == keypoints.data());
  CHECK(cleaner.notes().empty());

  keypoints.emplace_back(5, 6, 1);
  frame.keypoints = frame.keypoints_undistorted = keypoints;
  cleaner.clean(frame);
  REQUIRE(frame.size() == limits::kMaxFeatures + 1);
  for (const std::size_t i : {std::size_t{0}, limits::kMaxFeatures}) {
    CHECK(std::isnan(frame.keypoints[i].pt.x));
    CHECK(std::isnan(frame.keypoints_undistorted[i].pt.y));
  }
  CHECK(cleaner.notes() == std::vector<std::string>{"100001 features, expected at most 100000: not judged"});
}

TEST_CASE("of more features in a square than it has pixels none has a position, and a note says so") {
  std::vector<cv::KeyPoint> keypoints{{300, 200, 1}, {16, 7.9F, 1}};
  for (std::size_t i = 0; i < limits::kMaxCrowd; ++i)
    keypoints.emplace_back(8 + 0.1F * static_cast<float>(i), 7, 1.0F);
  FrameCleaner cleaner;
  FrameView frame;
  frame.keypoints = frame.keypoints_undistorted = keypoints;
  cleaner.clean(frame);
  CHECK(frame.keypoints.data() == keypoints.data());
  CHECK(cleaner.notes().empty());

  keypoints.emplace_back(15.9F, 0, 1.0F);
  frame.keypoints = frame.keypoints_undistorted = keypoints;
  cleaner.clean(frame);
  CHECK(frame.keypoints[0].pt == cv::Point2f(300, 200));
  CHECK(frame.keypoints[1].pt == cv::Point2f(16, 7.9F));
  for (std::size_t i = 2; i < keypoints.size(); ++i) {
    CHECK(std::isnan(frame.keypoints[i].pt.x));
    CHECK(std::isnan(frame.keypoints_undistorted[i].pt.y));
  }
  CHECK(cleaner.notes() ==
        std::vector<std::string>{"65 keypoints are more than 64 in a square of 8 px: not judged"});
}

TEST_CASE("with many features fewer boxes are used") {
  std::vector<cv::KeyPoint> keypoints;
  for (int i = 0; i < 100'000; ++i)
    keypoints.emplace_back(static_cast<float>(3 * (i % 400)), static_cast<float>(i / 400), 1.0F);
  const std::vector<Detection> boxes(limits::kMaxBoxes, box(0.5F));
  FrameView frame;
  frame.keypoints = keypoints;
  frame.detections = DetectionInput{-1, boxes};
  FrameCleaner cleaner;
  cleaner.clean(frame);
  CHECK(frame.detections->detections.size() == limits::kMaxBoxFeaturePairs / keypoints.size());
  CHECK(cleaner.notes() ==
        std::vector<std::string>{"1000 boxes: only the 200 with the highest scores are used"});
}

}  // namespace clean_frame_limits_test
