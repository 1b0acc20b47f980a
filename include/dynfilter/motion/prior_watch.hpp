// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/core/portable_math.hpp>

namespace dynfilter {

/// Whether a prior on the camera's motion keeps its promise: chi-square over time. A clock that is late, a
/// bias or wrong axes contradict the background's motion frame after frame. A background that is wrong for a
/// moment, or a jerk, does so once.
class PriorWatch {
 public:
  /// Mean of d^2 (prior_evidence.hpp) from which on the prior is ignored, and below which it counts again.
  static constexpr double kContradicts = 4, kAgrees = 1;
  static constexpr double kMemory_s = 0.25;
  static constexpr double kMost = 25;  ///< of one frame

  bool trusts() const { return trusts_; }
  /// d^2 of the background's motion in this frame.
  void observe(double distance2, double elapsed_s) {
    const double now = 1 - portable::exp(-elapsed_s / kMemory_s);
    mean_ += now * (std::min(distance2, kMost) - mean_);
    trusts_ = trusts_ ? mean_ < kContradicts : mean_ < kAgrees;
  }
  void reset() { *this = {}; }  ///< another stream

 private:
  double mean_ = 0;
  bool trusts_ = true;
};

}  // namespace dynfilter
