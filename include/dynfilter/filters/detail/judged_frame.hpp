// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/geometry/depth_noise.hpp>

namespace dynfilter::detail {

/// What background_motion judges a frame by, for the time of one call.
struct JudgedFrame {
  const Evidence& evidence;
  const Match& match;
  const FeatureTracks& tracks;
  const Camera& camera;
  DepthNoise sensor;                 ///< of the frame's depths
  bool stereo;                       ///< then features without depth have evidence of their own, too
  double neighbour_px, neighbour_m;  ///< of a neighbourhood: radius, and largest difference in depth

  std::size_t size() const { return evidence.size(); }
  float depth_m(std::size_t i) const { return evidence.depths_m()[i]; }
  /// Difference in depth of features on one surface: a stereo camera's noise alone exceeds any fixed one.
  float reach_m(double least_m, float depth_m) const {
    if (!stereo || std::isnan(depth_m)) return static_cast<float>(least_m);
    const double noise_m = kReachSigmas * std::sqrt(2.0) * sensor.sigma_m(static_cast<double>(depth_m));
    return static_cast<float>(std::sqrt(least_m * least_m + noise_m * noise_m));
  }
  static constexpr double kReachSigmas = 3;  ///< of two depths' noise
};

}  // namespace dynfilter::detail
