// SPDX-License-Identifier: MIT
#include "render/calibration_error.hpp"

#include <cmath>
#include <dynfilter/core/random.hpp>

namespace dynfilter::render {

Camera with_calibration_error(const Camera& camera, double size, std::uint64_t seed) {
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

}  // namespace dynfilter::render
