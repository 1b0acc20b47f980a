// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

namespace dynfilter {

/// True for a usable depth. NaN, infinite, zero and negative all mean "no depth".
inline bool valid_depth(double depth_m) {
  return depth_m > 0 && std::isfinite(depth_m);
}

/// Noise of a structured-light depth camera along its optical axis,
///   sigma_z(z) = base + quadratic (z - offset)^2   [m].
/// It grows quadratically because depth is the inverse of a disparity with constant noise
/// (Khoshelham and Elberink, Sensors 2012, section 2.3).
/// The defaults are the axial noise of the Kinect (Nguyen, Izadi and Lovell, 3DIMPVT 2012).
/// The model is valid for surfaces viewed at up to about 60 degrees.
/// Silhouettes are much noisier.
struct DepthNoise {
  double base_m = 0.0012;           ///< noise at `offset_m` [m], > 0
  double quadratic_per_m = 0.0019;  ///< growth [1/m]
  double offset_m = 0.4;            ///< depth of least noise [m]

  /// Standard deviation [m] at depth `depth_m` [m].
  double sigma_m(double depth_m) const {
    const double d = depth_m - offset_m;
    return base_m + quadratic_per_m * d * d;
  }
  /// The same sensor with `factor` times the standard deviation at every depth.
  DepthNoise scaled(double factor) const { return {factor * base_m, factor * quadratic_per_m, offset_m}; }
};

}  // namespace dynfilter
