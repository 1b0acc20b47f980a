// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/hosts/host_mask.hpp>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"
#include "hosts/mask_host_stand_ins.hpp"

namespace host_mask_test {

using namespace dynfilter;

namespace {

/// Three features: the first and the last are rejected, the last one near a kept one.
struct Case {
  std::vector<cv::KeyPoint> keypoints{{{40, 50}, 1.0F}, {{110, 50}, 1.0F}, {{120, 50}, 1.0F}};
  stand_ins::Points points{{40, 50}, {110, 50}, {120, 50}};
  Verdict verdict;
  cv::Mat image = cv::Mat::zeros(100, 160, CV_8UC1);
  Case() { verdict.decision = {Vote::Dynamic, Vote::Unknown, Vote::Dynamic}; }

  cv::Mat mask(MaskPolarity polarity) const {
    return HostMask(polarity).image(keypoints, verdict, image.size()).clone();
  }
};

/// The kept one of Case.
void check_kept(const stand_ins::Points& left) {
  REQUIRE(left.size() == 1);
  CHECK(left[0] == cv::Point2f(110, 50));
}

}  // namespace

TEST_CASE("one polarity is the inverse of the other") {
  const Case c;
  const cv::Mat nonzero_drops = c.mask(MaskPolarity::NonzeroDrops),
                zero_drops = c.mask(MaskPolarity::ZeroDrops);
  CHECK(nonzero_drops.at<uchar>(50, 40) == 255);
  CHECK(zero_drops.at<uchar>(50, 40) == 0);
  CHECK(zero_drops.at<uchar>(50, 110) == 255);
  CHECK(cv::countNonZero(nonzero_drops + zero_drops != 255) == 0);
}

TEST_CASE("a disc is 1.2 times larger per octave") {
  Case c;
  c.keypoints[0].octave = 3;
  MaskedImageParams params;
  params.radius_px = 10;
  const cv::Mat mask =
      HostMask(MaskPolarity::NonzeroDrops, params).image(c.keypoints, c.verdict, c.image.size());
  const int radius_px = cvRound(10 * std::pow(1.2, 3));
  CHECK(mask.at<uchar>(50, 40 + radius_px) == 255);
  CHECK(mask.at<uchar>(50, 40 + radius_px + 1) == 0);
}

TEST_CASE("depth has holes where the mask drops, in every type") {
  const Case c;
  for (const int type : {CV_16UC1, CV_32FC1}) {
    const cv::Mat depth(c.image.size(), type, cv::Scalar(3));
    HostMask host(MaskPolarity::ZeroDrops);  // the polarity is that of the mask image only
    const cv::Mat holes = host.depth(c.keypoints, c.verdict, depth);
    CHECK(holes.type() == type);
    CHECK(cv::countNonZero(holes == 0) == cv::countNonZero(c.mask(MaskPolarity::NonzeroDrops)));
    CHECK(cv::countNonZero(depth == 0) == 0);
  }
}

TEST_CASE("ids and status follow the verdict") {
  const Case c;
  std::vector<int> rejected{99};
  rejected_ids(c.verdict, std::vector<int>{7, 8, 9}, rejected);
  CHECK(rejected == std::vector<int>{7, 9});
  std::vector<uchar> status;
  keep_status(c.verdict, status);
  CHECK(status == std::vector<uchar>{0, 1, 0});
}

TEST_CASE("a parameter out of range is an error") {
  MaskedImageParams params;
  params.radius_px = -1;
  CHECK_THROWS_AS(HostMask(MaskPolarity::ZeroDrops, params), ConfigError);
}

TEST_CASE("stella_vslam drops what is rejected") {
  const Case c;
  stand_ins::StellaSystem slam{c.points};
  slam.feed_monocular_frame(c.image, 0.0, c.mask(MaskPolarity::ZeroDrops));
  check_kept(slam.features);
}

TEST_CASE("OpenVINS drops live tracks that are rejected") {
  const Case c;
  stand_ins::OpenVinsTracker tracker{c.points};
  tracker.feed_new_camera({{c.image}, {c.mask(MaskPolarity::NonzeroDrops)}});
  check_kept(tracker.tracks);
}

TEST_CASE("RTAB-Map finds no feature in the holes of the depth image") {
  const Case c;
  const cv::Mat depth(c.image.size(), CV_16UC1, cv::Scalar(1500));
  HostMask host(MaskPolarity::ZeroDrops);
  const cv::Mat mask = stand_ins::rtabmap_feature_mask(host.depth(c.keypoints, c.verdict, depth));
  stand_ins::Points left;
  for (const cv::Point2f& p : c.points)
    if (mask.at<uchar>(p) != 0) left.push_back(p);
  check_kept(left);
}

TEST_CASE("Kimera-VIO draws into the mask: it gets a copy") {
  const Case c;
  HostMask host(MaskPolarity::ZeroDrops);
  const cv::Mat& mask = host.image(c.keypoints, c.verdict, c.image.size());
  const cv::Mat before = mask.clone();
  stand_ins::KimeraFrame frame{c.image, mask.clone(), {}};
  check_kept(stand_ins::kimera_detected(frame, c.points, 5));
  frame.keypoints_ = {{110, 50}};
  CHECK(stand_ins::kimera_detected(frame, c.points, 5).empty());
  CHECK(cv::countNonZero(mask != before) == 0);
}

TEST_CASE("VINS-Fusion reduces all its arrays by one status") {
  const Case c;
  stand_ins::VinsFeatureTracker tracker{c.points, c.points, {4, 5, 6}, {1, 2, 3}};
  std::vector<uchar> status;
  keep_status(c.verdict, status);
  stand_ins::reduceVector(tracker.prev_pts, status);
  stand_ins::reduceVector(tracker.cur_pts, status);
  stand_ins::reduceVector(tracker.ids, status);
  stand_ins::reduceVector(tracker.track_cnt, status);
  check_kept(tracker.cur_pts);
  CHECK(tracker.ids == std::vector<int>{5});
  CHECK(tracker.track_cnt == std::vector<int>{2});
}

}  // namespace host_mask_test
