// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/random.hpp>

#include "render/mesh.hpp"
#include "render/street_materials.hpp"

namespace dynfilter::render {

enum class CarKind { Saloon, Hatchback, Van };

/// A car, 1.75 m wide and 4.1 to 4.9 m long. Its front is at +y, its origin on the road below its middle.
/// `instance`: number of the detectable object.
Model car_model(const CarPaint& paint, CarKind kind, int instance);

/// A bus, 10.5 m long and 3 m high. Front and origin as those of a car.
Model bus_model(MaterialSet& set, Random& random, int instance);

}  // namespace dynfilter::render
