// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/motion/rigid_background.hpp>

#include "geometry/rigid_scene.hpp"

namespace motion_test {

using dynfilter::RigidBackgroundScene;

/// The scene of a test's columns: reference_m, current_m, pixels, mobility and seeds, which must outlive it.
template <class Columns>
RigidBackgroundScene scene_of(const Columns& columns) {
  RigidBackgroundScene scene;
  scene.camera = geometry_test::camera();
  scene.reference_m = columns.reference_m;
  scene.current_m = columns.current_m;
  scene.pixels = columns.pixels;
  scene.mobility = columns.mobility;
  scene.seeds = columns.seeds;
  return scene;
}

}  // namespace motion_test
