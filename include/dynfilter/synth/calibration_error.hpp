// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/synth/random.hpp>

namespace dynfilter::synth {

/// Simulates a calibration with errors scaled by `size`.
/// At 1, focal lengths are off by 0.5 % and the principal point by 3 px.
/// In addition, k1 moves the first corner of the image by 1 px.
/// Signs and direction are drawn from the seed. `camera` has no distortion.
inline Camera with_calibration_error(const Camera& camera, double size, std::uint64_t seed) {
  Camera wrong = camera;
  if (size == 0) return wrong;
  Random random(seed, 0xCA);
  const double focal = 1 + (random.chance(0.5) ? 0.005 : -0.005) * size;
  const double angle = random.uniform(0, 2 * CV_PI);
  wrong.fx_px *= focal;
  wrong.fy_px *= focal;
  wrong.cx_px += 3 * size * std::cos(angle);
  wrong.cy_px += 3 * size * std::sin(angle);
  const double corner = std::hypot(camera.cx_px / camera.fx_px, camera.cy_px / camera.fy_px);
  const double corner_px = corner * (camera.fx_px + camera.fy_px) / 2;
  wrong.distortion[0] = (random.chance(0.5) ? 1 : -1) * size / (corner_px * corner * corner);
  return wrong;
}

}  // namespace dynfilter::synth
