// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/geometry/depth_noise.hpp>

namespace dynfilter::mapping {

/// Detects jumps between two surfaces of a depth image.
/// Neighbours differ by more than a share of the depth and three standard deviations of its noise.
class DepthJump {
 public:
  explicit DepthJump(double max_step_share) : share_(static_cast<float>(max_step_share)) {}

  /// Depths [m], 0: no depth. A pixel without depth is never part of a jump.
  /// Branchless, so that compilers vectorise it.
  DYNFILTER_AS_CALLER bool operator()(float a_m, float b_m) const {
    const float nearer = a_m < b_m ? a_m : b_m;
    const float limit = base_m_ + nearer * (share_ + quadratic_per_m_ * nearer);
    return (static_cast<int>(nearer > 0) & static_cast<int>(std::abs(a_m - b_m) > limit)) != 0;
  }

 private:
  float share_;
  float base_m_ = 3 * static_cast<float>(DepthNoise().base_m),
        quadratic_per_m_ = 3 * static_cast<float>(DepthNoise().quadratic_per_m);
};

}  // namespace dynfilter::mapping
