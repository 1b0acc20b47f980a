// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/render/furniture.hpp>
#include <dynfilter/render/lighting.hpp>
#include <dynfilter/render/mesh.hpp>
#include <vector>

namespace dynfilter::render {

/// All that does not move in a scene: a room, a hall or a street.
struct Surroundings {
  std::vector<Model> models;        ///< world frame, shaded
  std::vector<Detectable> objects;  ///< entry i is instance first_instance + i + 1
  Lighting lighting;
};

}  // namespace dynfilter::render
