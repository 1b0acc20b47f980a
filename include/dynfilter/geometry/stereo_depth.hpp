// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <limits>

namespace dynfilter {

/// A smaller disparity is no depth: its error is a fifth of it with twice the usual noise, and the mean of
/// 1 / disparity is 4 % too large. The feature is a direction then.
constexpr float kLeastDisparity_px = 10 * static_cast<float>(DepthNoise::kDisparity_px);

/// Depth [m] of a feature at the undistorted column `left_u_px`. NaN without a match and for small disparities.
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
