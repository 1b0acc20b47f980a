// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/random.hpp>
#include <vector>

#include "render/mesh.hpp"
#include "render/texture.hpp"

namespace dynfilter::render {

/// Materials of movers that are not people: several cardboard boxes and a metal frame.
struct CargoMaterials {
  static constexpr int kBoxes = 8;
  std::vector<int> boxes;
  int metal, rubber;

  CargoMaterials(MaterialSet& set, Random& r);
};

/// One cardboard box, centred at its origin.
Model cargo_box(const CargoMaterials& m, const Eigen::Vector3f& size, Random& r);

/// A cart with stacked boxes, `wide_m` along x, half as deep and about `high_m` high.
/// Its origin is on the floor.
Model cargo_cart(const CargoMaterials& m, float wide_m, float high_m, Random& r);

}  // namespace dynfilter::render
