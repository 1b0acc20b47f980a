// SPDX-License-Identifier: MIT
#include <bitset>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/evidence/history.hpp>
#include <dynfilter/evidence/matched_features.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <limits>

#include "doctest/doctest.h"

namespace matched_features_test {

using namespace dynfilter;

namespace {

int bits_apart(const cv::Mat& a, int row_a, const cv::Mat& b, int row_b) {
  std::size_t bits = 0;
  for (int c = 0; c < a.cols; ++c)
    bits += std::bitset<8>(static_cast<unsigned>(a.at<std::uint8_t>(row_a, c) ^ b.at<std::uint8_t>(row_b, c)))
                .count();
  return static_cast<int>(bits);
}

}  // namespace

TEST_CASE("matched features: the host's index, and the distance as counted bit by bit") {
  const testing::ExactScene scene =
      testing::preset(testing::Preset::General).with_descriptors(10).missing_matches(0.2).mismatches(0.1);
  FrameEvidence evidence;
  const testing::ExactFrame then = scene.frame(0), now = scene.frame(1);
  evidence.begin(then.view(), CallPoint::BeforePose);
  CHECK(evidence.matched_features(evidence.match({})).index(0) == -1);  // there is no earlier frame
  evidence.end(false);
  evidence.begin(now.view(), CallPoint::BeforePose);
  const Match& match = evidence.match({});
  const MatchedFeatures& matched = evidence.matched_features(match);
  CHECK(&matched == &evidence.matched_features(match));  // once per frame
  REQUIRE(matched.has_descriptors());
  int none = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const std::int32_t j = now.reference_index[i];
    CHECK(matched.index(i) == j);
    none += j < 0 ? 1 : 0;
    CHECK(matched.distance_bits(i) ==
          (j < 0 ? -1 : bits_apart(now.descriptors, static_cast<int>(i), then.descriptors, j)));
  }
  CHECK(none > 10);
}

TEST_CASE("matched features: with flow, the feature nearest to where it ends") {
  PastFrame then;
  then.keypoints = {{10, 10, 31}, {20, 20, 31}, {23, 20, 31}};
  then.descriptors = (cv::Mat_<std::uint8_t>(3, 2) << 0, 0, 255, 0, 0, 3);
  Match match;
  match.reference = &then;
  match.correspondences.reset(5);
  match.correspondences.set(0, {10.5F, 10});
  match.correspondences.set(1, {15, 15});     // 5 px and more from all
  match.correspondences.set(2, {21.6F, 20});  // 1.6 px from one, 1.4 px from the other
  match.correspondences.set(3, {20, 20}, 7);  // an index that is none
  const std::vector<cv::KeyPoint> keypoints(5, cv::KeyPoint(50, 50, 31));
  FrameView frame;
  frame.keypoints = keypoints;
  frame.descriptors = (cv::Mat_<std::uint8_t>(5, 2) << 1, 0, 0, 0, 0, 0, 0, 0, 0, 0);
  MatchedFeatures matched;
  matched.assign(frame, match, 2);
  const std::int32_t index[] = {0, -1, 2, -1, -1}, bits[] = {1, -1, 2, -1, -1};
  for (std::size_t i = 0; i < 5; ++i) {
    CAPTURE(i);
    CHECK(matched.index(i) == index[i]);
    CHECK(matched.distance_bits(i) == bits[i]);
  }
  matched.assign(frame, match, 0.1);
  CHECK(matched.index(0) == -1);
  frame.descriptors = cv::Mat::zeros(5, 4, CV_8UC1);  // of another length
  matched.assign(frame, match, 2);
  CHECK(!matched.has_descriptors());
  CHECK(matched.index(0) == 0);
  CHECK(matched.distance_bits(0) == -1);
}

}  // namespace matched_features_test
