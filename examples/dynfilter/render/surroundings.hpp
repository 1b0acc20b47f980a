// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "render/furniture.hpp"
#include "render/lighting.hpp"
#include "render/mesh.hpp"

namespace dynfilter::render {

/// All that does not move in a scene: a room, a hall or a street.
struct Surroundings {
  std::vector<Model> models;        ///< world frame, shaded
  std::vector<Detectable> objects;  ///< entry i is instance first_instance + i + 1
  Lighting lighting;
};

}  // namespace dynfilter::render
