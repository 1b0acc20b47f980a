// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/portable_math.hpp>

namespace dynfilter {

/// Rows of a rolling shutter are times. A camera that turns differently while it reads two frames twists one
/// image against the other: a point q of the current frame is where
///   q' = q + s (a x q),  s = row / height - 1/2,
/// would be if all rows of a frame were read at once. `a` is the change, between the frames, of the turn
/// during one readout [rad]. Only this difference can be seen between two frames, not each turn.
struct RowTwist {
  Eigen::Vector3d a_rad = Eigen::Vector3d::Zero();

  bool none() const { return a_rad.isZero(0); }  ///< whether there is none
  /// s of a row as measured, before undistortion; the camera's centre is the middle of the image.
  static double row(const Camera& camera, float v_px) {
    return static_cast<double>(v_px) / (2 * camera.cy_px) - 0.5;
  }
  /// Moves a direction of the row at `s` to where a global shutter had seen it.
  Eigen::Vector3d straighten(const Eigen::Vector3d& q, double s) const { return q + s * a_rad.cross(q); }
};

/// What is known of the time in which a camera reads its rows, and so of a twist before it is measured.
///
/// A twist is about the readout times the change of the rate of turn. A hand trembles between frames, so it
/// is no more than about that: Gaussian around 0. The readout is a constant of the camera, one of six values
/// that are equally likely at first. Each frame's twist says how likely each is (Student t, because a twist
/// may have been fitted to a mover).
class RowReadout {
 public:
  /// Root of the mean square [s].
  double readout_s() const {
    double sum2_s2 = 0;
    for (int k = 0; k < kValues; ++k) sum2_s2 += portable::exp(log_p_[k]) * kReadout_s[k] * kReadout_s[k];
    return std::sqrt(sum2_s2 / sum());
  }
  /// Whether no doubt is left that the rows are not read at once.
  bool rolls() const { return log_p_[0] <= -kNoDoubt_nats; }
  /// Whether nothing speaks for rows that are read at once.
  bool may_roll() const { return kValues * portable::exp(log_p_[0]) <= sum(); }
  /// Standard deviation of a twist, per axis. `change_radps`: of the rate of turn, against the last step.
  double sigma_rad(double change_radps) const {
    const double s = readout_s();
    return s * change_radps + kTremble_rad * s / kReadout_s[kValues - 1];
  }
  /// `twist_rad` and its variances are what a fit gave that expected 0 with `sigma_rad`.
  void learn(double change_radps, double sigma_rad, const Eigen::Vector3d& twist_rad,
             const Eigen::Vector3d& variance_rad2) {
    const double per_prior2 = 1 / (sigma_rad * sigma_rad);
    for (int axis = 0; axis < 3; ++axis) {  // the frame's own word, without what was expected
      const double per_own2 = 1 / variance_rad2(axis) - per_prior2;
      if (!(per_own2 > kLeastShare * per_prior2)) continue;
      const double own_rad = twist_rad(axis) / variance_rad2(axis) / per_own2;
      for (int k = 0; k < kValues; ++k) {
        const double length_rad = kReadout_s[k] * change_radps;
        const double variance = 1 / per_own2 + length_rad * length_rad + kTremble_rad * kTremble_rad;
        log_p_[k] -=
            portable::log(variance) / 2 + (kNu + 1) / 2 * portable::log1p(own_rad * own_rad / variance / kNu);
      }
    }
    const double most = *std::max_element(log_p_, log_p_ + kValues);
    for (double& p : log_p_) p = std::max(p - most, -kMostSure_nats);
  }

 private:
  static constexpr int kValues = 6;
  static constexpr double kReadout_s[kValues] = {0, 0.002, 0.004, 0.008, 0.016, 0.033};
  static constexpr double kTremble_rad = 0.0002;  ///< faster than frames
  static constexpr double kLeastShare = 0.1;      ///< of what is known that a frame must add
  static constexpr double kNu = 3;                ///< degrees of freedom
  static constexpr double kNoDoubt_nats = 4.6;    ///< one in a hundred
  static constexpr double kMostSure_nats = 20;    ///< another camera is learned within seconds

  double sum() const {
    double sum = 0;
    for (const double p : log_p_) sum += portable::exp(p);
    return sum;
  }

  double log_p_[kValues] = {};
};

}  // namespace dynfilter
