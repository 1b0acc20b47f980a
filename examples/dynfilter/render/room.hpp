// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/random.hpp>
#include <vector>

#include "render/furniture.hpp"
#include "render/room_materials.hpp"
#include "render/surroundings.hpp"
#include "render/texture.hpp"

namespace dynfilter::render {

/// The office of every scene: 8 x 7.6 m, z up, origin in the middle of the floor.
/// Cameras look north (+y) over a double desk with a partition behind it.
/// Shelves, cabinets and more desks are along the walls.
class Room : public Surroundings {
 public:
  /// `chairs`: x, y, yaw of additional chairs. Instances are numbered from `first_instance` + 1.
  Room(MaterialSet& set, Random& random, RoomLook look, const std::vector<Eigen::Vector3f>& chairs,
       int first_instance);

 private:
  static constexpr float kHalfX = 4.0F, kHalfY = 3.8F, kHigh = 2.8F;

  static void shell(FurnitureBuilder& b);

  static void skirting(FurnitureBuilder& b);

  static void desks(FurnitureBuilder& b);

  static void along_walls(FurnitureBuilder& b);

  static void south_wall(FurnitureBuilder& b);
};

}  // namespace dynfilter::render
