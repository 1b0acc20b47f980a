// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/core/portable_math.hpp>

namespace dynfilter {

/// The probability that a prior on the camera's motion is wrong, learned over time. A clock that is late, a
/// bias or wrong axes contradict the background's motion frame after frame. A background that is wrong for a
/// moment, or a jerk, does so once. Log-odds, with the squared distance d^2 of the background's motion:
///   odds += (elapsed / memory) (d^2 / 2 - break_even), within +-5.
class PriorWatch {
 public:
  static constexpr double kFirstOdds = -1.4;  ///< 0.2: before it has proved itself
  static constexpr double kMostOdds = 5;      ///< doubt and trust can both be overcome in half a second
  static constexpr double kMemory_s = 0.25;
  static constexpr double kBreakEven = 2;  ///< d = 2: two deviations, where errors in common are not known
  static constexpr double kMost = 25;      ///< d^2 of one frame

  /// In [0, 1].
  double wrong() const { return 1 / (1 + portable::exp(-odds_)); }
  bool trusts() const { return odds_ < 0; }
  void observe(double distance2, double elapsed_s) {
    const double now = std::min(1.0, elapsed_s / kMemory_s);
    odds_ += now * (std::min(distance2, kMost) / 2 - kBreakEven);
    odds_ = std::clamp(odds_, -kMostOdds, kMostOdds);
  }
  void reset() { *this = {}; }  ///< another stream

 private:
  double odds_ = kFirstOdds;
};

}  // namespace dynfilter
