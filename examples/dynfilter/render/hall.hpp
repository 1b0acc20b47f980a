// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/random.hpp>

#include "render/cart.hpp"
#include "render/furniture.hpp"
#include "render/surroundings.hpp"
#include "render/texture.hpp"

namespace dynfilter::render {

/// A workshop hall of 16 x 20 x 6 m, z up, origin in the middle of the floor. Racks with boxes along the
/// walls, benches, carts and pillars in the middle, pipes under the ceiling.
class Hall : public Surroundings {
 public:
  static constexpr float kHalfX = 8.0F, kHalfY = 10.0F, kHigh = 6.0F;

  /// Instances are numbered from `first_instance` + 1.
  Hall(MaterialSet& set, Random& random, int first_instance);

 private:
  static void shell(FurnitureBuilder& b);
  static void racks(FurnitureBuilder& b);
  static void workplaces(FurnitureBuilder& b);
  static void overhead(FurnitureBuilder& b);
  void cargo(const CargoMaterials& cargo, Random& random);
};

}  // namespace dynfilter::render
