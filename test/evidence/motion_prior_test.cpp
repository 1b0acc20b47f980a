// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstddef>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "doctest/doctest.h"

namespace evidence_motion_prior_test {

using namespace dynfilter;

namespace {

constexpr int kWidth = 640, kHeight = 480, kJump_px = 90;

/// White noise, of which the upper levels of a pyramid show nothing.
cv::Mat noise() {
  cv::Mat image(kHeight, kWidth + kJump_px, CV_8UC1);
  cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

/// With a long lens, what is far jumps by the same way everywhere when the camera turns.
Camera long_lens() {
  Camera camera;
  camera.fx_px = camera.fy_px = 4000, camera.cx_px = kWidth / 2.0, camera.cy_px = kHeight / 2.0;
  camera.width_px = kWidth, camera.height_px = kHeight;
  return camera;
}

/// Share of the features that are found within a pixel of where they were, and that are found at all.
struct Found {
  double right = 0, all = 0;
};

Found turn_by_a_jump(const std::optional<MotionPrior>& prior) {
  const cv::Mat both = noise();
  const cv::Mat then = both.colRange(0, kWidth).clone(),
                now = both.colRange(kJump_px, kJump_px + kWidth).clone();
  std::vector<cv::KeyPoint> features;
  for (int y = 40; y < kHeight - 40; y += 20)
    for (int x = 40; x < kWidth - 40 - kJump_px; x += 20)
      features.emplace_back(static_cast<float>(x), static_cast<float>(y), 31.0F);
  FrameEvidence evidence;
  FrameView view;
  view.keypoints = features, view.camera = long_lens(), view.grey = then;
  evidence.begin(view, CallPoint::BeforePose);
  evidence.end(false);
  view.id = 1, view.timestamp_s = 0.1, view.grey = now, view.motion_prior = prior;
  evidence.begin(view, CallPoint::BeforePose);
  const Match& match = evidence.match({});
  Found found;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!match.found(i)) continue;
    const cv::Point2f miss = match.reference_undistorted_px[i] - features[i].pt - cv::Point2f(kJump_px, 0);
    found.all += 1, found.right += std::hypot(miss.x, miss.y) < 1 ? 1 : 0;
  }
  const auto n = static_cast<double>(features.size());
  evidence.end(false);
  return {found.right / n, found.all / n};
}

/// What was at column u + 90 is at u now: in the camera's frame, the scene turned to the left.
MotionPrior turn(double angle_rad) {
  const Eigen::Matrix3d R = rotation_about(Eigen::Vector3d::UnitY(), -angle_rad);
  return MotionPrior::turn(R, 1e-8 * Eigen::Matrix3d::Identity());
}

}  // namespace

TEST_CASE("a jump that flow cannot bridge alone: features are found where a gyroscope expects them") {
  const double angle_rad = std::atan(kJump_px / 4000.0);
  const Found alone = turn_by_a_jump({}), with = turn_by_a_jump(turn(angle_rad));
  MESSAGE("right: " << alone.right << " without a prior, " << with.right << " with one");
  CHECK(alone.right < 0.1);
  CHECK(with.right > 0.95);
  CHECK(with.all - with.right < 0.02);
}

TEST_CASE("a prior that lies about the turn adds no wrong matches") {
  const Found alone = turn_by_a_jump({}), with = turn_by_a_jump(turn(-0.02));
  CHECK(with.all - with.right <= alone.all - alone.right + 0.02);
}

}  // namespace evidence_motion_prior_test
