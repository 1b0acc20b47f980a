// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "doctest/doctest.h"

namespace evidence_second_look_test {

using namespace dynfilter;

namespace {

constexpr int kWidth = 640, kHeight = 480, kMargin_px = 120;
constexpr double kFocal_px = 500, kDepth_m = 5;

cv::Mat noise(int amplitude) {
  cv::Mat image(kHeight, kWidth + kMargin_px, CV_8UC1);
  cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, amplitude);
  return image;
}
/// Alike after every 24 px, but for a little noise.
cv::Mat nearly_periodic() {
  cv::Mat image = noise(24);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      image.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(
          image.at<std::uint8_t>(y, x) + 100 + 60 * std::cos(x * CV_2PI / 24) * std::cos(y * CV_2PI / 24));
  return image;
}

/// A wall at 5 m, before a camera that moves sideways until everything is `jump_px` farther left.
class Wall {
 public:
  Wall(const cv::Mat& both, int jump_px) : jump_px_(jump_px) {
    for (int y = 50; y < kHeight - 50; y += 20)
      for (int x = 130; x < kWidth - 130; x += 20)
        features_.emplace_back(static_cast<float>(x), static_cast<float>(y), 31.0F);
    depths_m_.assign(features_.size(), static_cast<float>(kDepth_m));
    depths_m_[0] = -1;  // this one has none
    Camera camera;
    camera.fx_px = camera.fy_px = kFocal_px, camera.cx_px = kWidth / 2.0, camera.cy_px = kHeight / 2.0;
    camera.width_px = kWidth, camera.height_px = kHeight;
    FrameView view;
    view.keypoints = features_, view.depth_m = depths_m_, view.camera = camera;
    view.grey = both.colRange(0, kWidth).clone();
    evidence_.begin(view, CallPoint::BeforePose);
    evidence_.end(false);
    view.id = 1, view.timestamp_s = 0.1, view.grey = both.colRange(jump_px, jump_px + kWidth).clone();
    evidence_.begin(view, CallPoint::BeforePose);
  }
  const Match& first() { return evidence_.match({}); }
  /// With a motion that moves the wall by `expected_px`.
  const Match& second(double expected_px, bool doubted = true) {
    return look(first(), expected_px, features_.size(), doubted);
  }
  const Match& look(const Match& match, double expected_px, std::size_t doubts, bool doubted = true) {
    Pose T_now_then;
    T_now_then.translation_m[0] = -expected_px * kDepth_m / kFocal_px;
    doubted_.assign(doubts, doubted ? 1 : 0);
    return evidence_.second_look(match, T_now_then, doubted_);
  }
  /// Share of the features with a match, and with one within a pixel of where they were.
  double found(const Match& match) const {
    return static_cast<double>(match.correspondences.count()) / static_cast<double>(features_.size());
  }
  double right(const Match& match) const {
    double n = 0;
    for (std::size_t i = 0; i < features_.size(); ++i) {
      if (!match.found(i)) continue;
      const cv::Point2f miss = match.reference_undistorted_px[i] - features_[i].pt;
      n += std::hypot(miss.x - static_cast<float>(jump_px_), miss.y) < 1 ? 1 : 0;
    }
    return n / static_cast<double>(features_.size());
  }

 private:
  int jump_px_;
  std::vector<cv::KeyPoint> features_;
  std::vector<float> depths_m_;
  std::vector<std::uint8_t> doubted_;
  FrameEvidence evidence_;
};

}  // namespace

TEST_CASE("second look: what jumped too far for flow is found where a static point is") {
  Wall wall(noise(256), 90);
  CHECK(wall.right(wall.first()) < 0.1);
  const Match& match = wall.second(90);
  CHECK(wall.right(match) > 0.95);
  CHECK_FALSE(match.found(0));  // without a depth its place is not known
}

TEST_CASE("second look: a wrong motion, or no doubt, changes nothing") {
  Wall wall(noise(256), 90);
  const std::size_t before = wall.first().correspondences.count();
  CHECK(wall.second(90, false).correspondences.count() == before);
  CHECK(wall.second(60).correspondences.count() <= before + 5);  // chance
  CHECK(wall.right(wall.second(60)) < 0.1);
}

TEST_CASE("second look: no reference, too few doubts or no motion: the match as it is") {
  Wall wall(noise(256), 90);
  CHECK(&wall.look(wall.first(), 90, 3) == &wall.first());
  Match nothing;
  CHECK(&wall.look(nothing, 90, wall.first().correspondences.size()) == &nothing);
  CHECK(wall.second(std::nan("")).correspondences.count() == wall.first().correspondences.count());
}

TEST_CASE("second look: two of them in a frame do not disturb each other") {
  Wall wall(noise(256), 90);
  const Match &right = wall.second(90), &wrong = wall.second(60);
  CHECK(wall.right(right) > 0.95);
  CHECK(wall.right(wrong) < 0.1);
}

TEST_CASE("second look: a mismatch gives way to the place that looks more alike, a match stays") {
  Wall jumps(nearly_periodic(), 96);
  const double wrong = jumps.found(jumps.first()) - jumps.right(jumps.first());
  MESSAGE("mismatches: " << wrong << ", right " << jumps.right(jumps.first()));
  REQUIRE(wrong > 0.3);
  const Match& second = jumps.second(96);
  MESSAGE("after it: " << jumps.found(second) - jumps.right(second));
  CHECK(jumps.right(second) > 0.85);
  CHECK(jumps.found(second) - jumps.right(second) < wrong / 4);
  Wall stands(nearly_periodic(), 0);
  const double right = stands.right(stands.first());
  REQUIRE(right > 0.9);
  CHECK(stands.right(stands.second(24)) == right);  // a motion that is a lie
}

}  // namespace evidence_second_look_test
