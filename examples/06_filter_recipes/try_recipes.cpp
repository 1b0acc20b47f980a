// SPDX-License-Identifier: MIT
#include <cstdio>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>

#include "recipes.hpp"

namespace testing = dynfilter::testing;

/// Votes on frame 8, after frames 0 to 7, compared with the truth.
void report(dynfilter::Filter& filter, const testing::ExactScene& scene) {
  const testing::Score score(testing::judge(filter, scene, 8), scene.frame(8));
  std::printf("%-18s recall %.3f  static kept %.3f\n", filter.name().c_str(),
              score.recall(), score.static_kept());
}

int main() {
  const auto general = testing::preset(testing::Preset::General).pixel_noise(0.3);

  const auto arm = testing::MovingBox(60).at({0, 0, 0.8}).moving({0.01, 0, 0});
  recipes::TooNearParams params;
  params.min_depth_m = 1;
  recipes::TooNear too_near(params);
  report(too_near, testing::ExactScene().mover(arm));

  recipes::OffTheLine off_the_line;
  report(off_the_line, general);

  const auto kinect = testing::ExactScene(general).depth_noise(0.0014);
  recipes::OffTheMotion off_the_motion;
  report(off_the_motion, kinect);
  report(off_the_motion, testing::ExactScene(kinect).gap(5));

  recipes::OffTheHostsPose off_the_hosts_pose;
  report(off_the_hosts_pose, testing::ExactScene(kinect).gap(5).with_poses());
}
