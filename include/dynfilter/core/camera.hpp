// SPDX-License-Identifier: MIT
#pragma once

#include <array>

namespace dynfilter {

/// Pinhole camera with OpenCV's radial-tangential distortion.
/// It holds plain numbers only because it crosses plugin boundaries.
struct Camera {
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
  std::array<double, 5> distortion{};  ///< k1 k2 p1 p2 k3; all zero: no distortion
  /// Stereo baseline [m] times fx [px]; 0: not a stereo camera.
  double baseline_fx_px_m = 0;
  int width_px = 0, height_px = 0;  ///< 0: any size

  bool valid() const { return fx_px > 0 && fy_px > 0; }
  /// Stereo baseline [m]; 0: not a stereo camera.
  double baseline_m() const { return fx_px > 0 ? baseline_fx_px_m / fx_px : 0; }
  bool distorted() const { return distortion != std::array<double, 5>{}; }
  bool operator==(const Camera& o) const {
    return fx_px == o.fx_px && fy_px == o.fy_px && cx_px == o.cx_px && cy_px == o.cy_px &&
           distortion == o.distortion && baseline_fx_px_m == o.baseline_fx_px_m && width_px == o.width_px &&
           height_px == o.height_px;
  }
};

}  // namespace dynfilter
