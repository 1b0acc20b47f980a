// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <limits>

namespace dynfilter {

/// Noise of a structured-light depth camera along its optical axis,
///   sigma_z(z) = base + quadratic (z - offset)^2   [m].
/// It grows quadratically because depth is the inverse of a disparity with constant noise (Khoshelham and
/// Elberink, Sensors 2012, section 2.3).
/// The defaults are the axial noise of the Kinect (Nguyen, Izadi and Lovell, 3DIMPVT 2012).
/// The model is valid for surfaces viewed at up to about 60 degrees. Silhouettes are much noisier.
struct DepthNoise {
  double base_m = 0.0012;           ///< noise at `offset_m` [m], > 0
  double quadratic_per_m = 0.0019;  ///< growth [1/m]
  double offset_m = 0.4;            ///< depth of least noise [m]

  /// Of a stereo pair: sigma_z = z^2 / (f b) sigma_d, with a constant noise of the disparity.
  /// `baseline_fx_px_m`: baseline times focal length, > 0.
  static DepthNoise of_stereo(double baseline_fx_px_m) {
    return {kStereoBase_m, kDisparity_px / baseline_fx_px_m, 0};
  }
  static constexpr double kDisparity_px = 0.25;   ///< of patches matched along a row, with interpolation
  static constexpr double kStereoBase_m = 0.001;  ///< a depth is never exact

  /// Standard deviation [m] at depth `depth_m` [m].
  double sigma_m(double depth_m) const {
    const double d = depth_m - offset_m;
    return base_m + quadratic_per_m * d * d;
  }
  /// The same sensor with `factor` times the standard deviation at every depth.
  DepthNoise scaled(double factor) const { return {factor * base_m, factor * quadratic_per_m, offset_m}; }
};

/// A smaller disparity is no depth. With twice the usual noise its error is a fifth of it, and the mean of 1
/// / disparity is 4 % too large. The feature is a direction then.
constexpr float kLeastDisparity_px = 10 * static_cast<float>(DepthNoise::kDisparity_px);

/// Depth [m] of a feature at the undistorted column `left_u_px`. NaN: no match, or a small disparity.
inline float stereo_depth_m(float left_u_px, float right_u_px, double baseline_fx_px_m) {
  const float disparity_px = left_u_px - right_u_px;
  return valid_right(right_u_px) && disparity_px >= kLeastDisparity_px
             ? static_cast<float>(baseline_fx_px_m) / disparity_px
             : std::numeric_limits<float>::quiet_NaN();
}

/// Noise of the frame's depths, by what measured them.
inline DepthNoise depth_noise_of(const FrameView& frame) {
  return is_stereo(frame) ? DepthNoise::of_stereo(frame.camera->baseline_fx_px_m) : DepthNoise();
}

}  // namespace dynfilter
