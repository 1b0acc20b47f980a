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

/// Radius of the disc of feature 0, of the given octave.
int radius_of(const cv::Mat& mask, const cv::Point& centre = {40, 50}) {
  int radius_px = 0;
  while (mask.at<uchar>(centre + cv::Point(radius_px + 1, 0)) != 0) ++radius_px;
  CHECK(mask.at<uchar>(centre - cv::Point(radius_px, 0)) != 0);
  CHECK(mask.at<uchar>(centre - cv::Point(radius_px + 1, 0)) == 0);
  return radius_px;
}

TEST_CASE("the radius is that of the sensor, times a factor per octave") {
  Case c;
  const auto radii = [&](int octave, const MaskedImageParams& params = MaskedImageParams()) {
    c.keypoints[0].octave = octave;
    HostMask host(MaskPolarity::NonzeroDrops, params);
    return std::pair(radius_of(host.rgbd_image(c.keypoints, c.verdict, c.image.size())),
                     radius_of(host.image(c.keypoints, c.verdict, c.image.size())));
  };
  CHECK(radii(0) == std::pair(14, 7));
  CHECK(radii(3) == std::pair(24, 12));  // 14 * 1.2^3 = 24.2, 7 * 1.2^3 = 12.1
  MaskedImageParams params;
  params.octave_scale = 1;
  CHECK(radii(3, params) == std::pair(14, 7));
  params.octave_scale = 1.5, params.radius_px = 8, params.radius_without_depth_px = 4;
  CHECK(radii(2, params) == std::pair(18, 9));
  params.octave_scale = MaskedImageParams::kMostPerOctave;  // 4^16 px would overflow
  c.keypoints[0].octave = 99;
  const cv::Mat all =
      HostMask(MaskPolarity::NonzeroDrops, params).image(c.keypoints, c.verdict, c.image.size());
  CHECK(cv::countNonZero(all) > c.image.size().area() / 2);
}

TEST_CASE("the right image is masked at the features' disparities") {
  const Case c;
  HostMask host(MaskPolarity::NonzeroDrops);
  const cv::Mat left = host.image(c.keypoints, c.verdict, c.image.size()).clone();
  // Alike for all: the mask is that of the left image, shifted.
  std::vector<float> right_u_px{40 - 25, 110 - 25, 120 - 25};
  cv::Mat right = host.right_image(c.keypoints, c.verdict, right_u_px, c.image.size()).clone();
  const cv::Rect shifted(0, 0, c.image.cols - 25, c.image.rows);
  CHECK(cv::countNonZero(right(shifted) != left(shifted + cv::Point(25, 0))) == 0);
  CHECK(cv::countNonZero(right) == cv::countNonZero(left));
  // Of each its own: the kept one is far from the rejected ones, and hides nothing of their discs.
  right_u_px = {30, 60, 100};
  right = host.right_image(c.keypoints, c.verdict, right_u_px, c.image.size()).clone();
  CHECK(radius_of(right, {30, 50}) == 7);
  CHECK(radius_of(right, {100, 50}) == 7);
  CHECK(right.at<uchar>(50, 60) == 0);
  // Without a match there is no disc, and a missing array is one without matches.
  right_u_px = {-1, 60, std::nanf("")};
  CHECK(cv::countNonZero(host.right_image(c.keypoints, c.verdict, right_u_px, c.image.size())) == 0);
  CHECK(cv::countNonZero(host.right_image(c.keypoints, c.verdict, std::vector<float>(), c.image.size())) ==
        0);
  CHECK(c.keypoints[0].pt.x == 40.F);
}

TEST_CASE("depth has holes where the mask drops, in every type") {
  const Case c;
  for (const int type : {CV_16UC1, CV_32FC1}) {
    const cv::Mat depth(c.image.size(), type, cv::Scalar(3));
    HostMask host(MaskPolarity::ZeroDrops);  // the polarity is that of the mask image only
    const cv::Mat holes = host.depth(c.keypoints, c.verdict, depth).clone();
    CHECK(holes.type() == type);
    const cv::Mat mask = host.rgbd_image(c.keypoints, c.verdict, depth.size());
    CHECK(cv::countNonZero((holes == 0) != (mask == 0)) == 0);
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
  using P = MaskedImageParams;
  for (double P::*member :
       {&P::radius_px, &P::radius_without_depth_px, &P::keep_radius_px, &P::octave_scale}) {
    for (const double wrong : {-1.0, P::kMax_px + 1, std::nan("")}) {
      P params;
      params.*member = wrong;
      CHECK_THROWS_AS(HostMask(MaskPolarity::ZeroDrops, params), ConfigError);
    }
  }
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
