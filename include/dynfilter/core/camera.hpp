// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>

namespace dynfilter {

/// Pinhole camera with OpenCV's radial-tangential distortion.
/// It holds plain numbers only because it crosses plugin boundaries.
struct Camera {
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
  std::array<double, 5> distortion{};  ///< k1 k2 p1 p2 k3; all zero: no distortion
  double baseline_fx_px_m = 0;         ///< stereo baseline [m] times fx [px]; 0: not a stereo camera
  int width_px = 0, height_px = 0;     ///< 0: any size

  bool valid() const { return fx_px > 0 && fy_px > 0; }  ///< whether it has focal lengths
  /// Stereo baseline [m]; 0: not a stereo camera.
  double baseline_m() const { return fx_px > 0 ? baseline_fx_px_m / fx_px : 0; }
  bool distorted() const { return distortion != std::array<double, 5>{}; }  ///< any coefficient is not 0
  bool operator==(const Camera& o) const {
    return fx_px == o.fx_px && fy_px == o.fy_px && cx_px == o.cx_px && cy_px == o.cy_px &&
           distortion == o.distortion && baseline_fx_px_m == o.baseline_fx_px_m && width_px == o.width_px &&
           height_px == o.height_px;
  }
};

/// The camera of TUM's freiburg3 sequences: 640x480, no distortion. Scenes are seen by it.
inline Camera freiburg3_camera() {
  Camera camera;
  camera.fx_px = 535.4, camera.fy_px = 539.2, camera.cx_px = 320.1, camera.cy_px = 247.6;
  camera.width_px = 640, camera.height_px = 480;
  return camera;
}

/// True for a usable depth. NaN, infinite, zero and negative all mean "no depth".
inline bool valid_depth(double depth_m) {
  return depth_m > 0 && std::isfinite(depth_m);
}

}  // namespace dynfilter
