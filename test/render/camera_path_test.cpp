// SPDX-License-Identifier: MIT
#include <Eigen/Core>
#include <algorithm>
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
      REQUIRE(still.size() > 0);
      float nearest_m = kClear_m;
      for (double t = 0; t < kLast_s; t += kStep_s) {
        const Eigen::Vector3f eye = scene.camera->pose(t).translation().cast<float>();
        nearest_m = std::min(nearest_m, still.nearest(eye, kClear_m).distance_m);
      }
      CAPTURE(name);
      CAPTURE(seed);
      CHECK(nearest_m == kClear_m);
    }
}

}  // namespace camera_path_test
