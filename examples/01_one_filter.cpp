// SPDX-License-Identifier: MIT
// Runs one rejector on a synthetic scene with exact truth.
#include <cstdio>
#include <dynfilter/filters/trajectory_consistency.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>

int main() {
  using namespace dynfilter;
  const testing::ExactScene scene =
      testing::preset(testing::Preset::General).pixel_noise(0.3).depth_noise(0.0014);
  TrajectoryConsistencyFilter filter;
  const testing::Score score(testing::judge(filter, scene, 8), scene.frame(8));
  std::printf("%s: recall %.2f, static kept %.2f\n", filter.name().c_str(), score.recall(),
              score.static_kept());
  return score.recall() > 0.9 && score.static_kept() > 0.9 ? 0 : 1;
}
