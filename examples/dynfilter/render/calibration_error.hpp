// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/camera.hpp>

namespace dynfilter::render {

/// Simulates a calibration with errors scaled by `size`.
/// At 1, focal lengths are off by 0.5 % and the principal point by 3 px.
/// In addition, k1 moves the first corner of the image by 1 px.
/// Signs and direction are drawn from the seed. `camera` has no distortion.
Camera with_calibration_error(const Camera& camera, double size, std::uint64_t seed);

}  // namespace dynfilter::render
