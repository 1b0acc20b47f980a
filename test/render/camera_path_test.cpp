// SPDX-License-Identifier: MIT
#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "doctest/doctest.h"
#include "render/mesh_distance.hpp"
#include "render/scenes.hpp"

namespace camera_path_test {

using namespace dynfilter;

TEST_CASE("no camera goes through a wall or a piece of furniture") {
  constexpr float kClear_m = 0.2F;
  constexpr double kStep_s = 0.05, kLast_s = 20;
  for (const std::string name : {"hall", "walking_xyz", "walking_halfsphere", "shake", "turn_60", "street"})
    for (const std::uint64_t seed : {1U, 2U}) {
      const render::Scene scene = render::make_scene(name, seed);
      render::MeshDistance still;
      for (const render::Model& model : scene.surroundings->models) still.add(model);
      still.build();
      for (double t = 0; t < kLast_s; t += kStep_s) {
        const Eigen::Vector3f eye = scene.camera->pose(t).translation().cast<float>();
        if (still.nearest(eye, kClear_m).distance_m < kClear_m) {
          FAIL_CHECK(name << ", seed " << seed << ": something is nearer than 0.2 m after " << t << " s");
          break;
        }
      }
    }
}

}  // namespace camera_path_test
