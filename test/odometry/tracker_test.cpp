// SPDX-License-Identifier: MIT
#include <odometry/tracker.hpp>
#include <random>

#include "doctest/doctest.h"
#include "test_images.hpp"

namespace tracker_test {

using namespace dynfilter::odometry;

namespace {

const Pinhole kCamera(odometry_test::camera(), 40.0);

/// A feature of the last frame, and what looks like it in this one: at the true place, or like it elsewhere.
struct Frames {
  FrameFeatures last, now;
  std::mt19937 random{7};

  double within(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  }
  static void add(FrameFeatures& features, cv::Point2d px, double depth_m, const Descriptor& descriptor) {
    features.keypoints.emplace_back(cv::Point2f(px), 31.F, -1.F, 0.F, 0);
    features.descriptors.push_back(descriptor);
    features.depth_m.push_back(static_cast<float>(depth_m));
    features.map_point.push_back(-1);
    features.spread.emplace_back();
    features.keypoints_undistorted = features.keypoints;
  }
  Descriptor look() {
    Descriptor d;
    for (auto& word : d) word = (static_cast<std::uint64_t>(random()) << 32) | random();
    return d;
  }
};

}  // namespace

// The camera turns by 20 px in a frame, beyond the first window of 15 px. There 150 of 210 features have
// something alike that agrees with nothing, and 25 are on the lens: as many as a pose needs.
TEST_CASE("tracker: if most matches contradict the pose, wider windows are tried") {
  const double turn_rad = 20 / kCamera.fx_px;
  Eigen::Isometry3d turned = Eigen::Isometry3d::Identity();
  turned.linear() = Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  Frames f;
  for (int i = 0; i < 210; ++i) {
    const cv::Point2d then(f.within(40, 600), f.within(40, 440));
    const Descriptor look = f.look();
    Frames::add(f.last, then, 2, look);
    if (i < 25) {
      Frames::add(f.now, then, 2, look);
      continue;
    }
    const Eigen::Vector3d seen = turned * kCamera.back_project(then.x, then.y, 2), px = kCamera.project(seen);
    Frames::add(f.now, {px.x(), px.y()}, seen.z(), look);
    Descriptor alike = look;
    alike[0] ^= 0xffff;
    if (i < 175) Frames::add(f.now, {then.x + f.within(-9, 9), then.y + f.within(-9, 9)}, 2, alike);
  }
  OdometryOptions options;
  Tracker tracker(kCamera, options);
  tracker.set_image({640, 480});
  tracker.frame_done(true, 0, f.last, Eigen::Isometry3d::Identity());
  tracker.index(f.now);
  Eigen::Isometry3d pose;
  REQUIRE(tracker.track_last_frame(Map(), Eigen::Isometry3d::Identity(), f.now, pose));
  CHECK((pose.linear() - turned.linear()).norm() < 1e-3);
  CHECK(pose.translation().norm() < 0.01);
}

}  // namespace tracker_test
