// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <dynfilter/core/random.hpp>

#include "render/skeleton.hpp"

namespace dynfilter::render {

/// Yaw, pitch and roll of a hand-held camera that rotates about all axes at once.
/// Repeats after kPeriod_s. The largest angular rate within a period is the given one.
class HandTurn {
 public:
  static constexpr double kPeriod_s = 3;

  HandTurn() = default;
  HandTurn(double peak_rad_s, Random& random);

  Eigen::Matrix3d rotation(double time_s) const {
    return turn(angle_rad(0, time_s), Eigen::Vector3d::UnitY()) *
           turn(angle_rad(1, time_s), Eigen::Vector3d::UnitX()) *
           turn(angle_rad(2, time_s), Eigen::Vector3d::UnitZ());
  }

 private:
  static double harmonic_rad_s(int k) { return 2 * M_PI * (k + 1) / kPeriod_s; }

  double angle_rad(int axis, double time_s) const;

  double peak_rate_rad_s() const;

  void scale(double factor);

  double amplitude_rad_[3][3] = {}, phase_rad_[3][3] = {};  // yaw, pitch, roll
};

/// Fast irregular jitter: three sines per axis between 5 and 8 Hz with drifting phase.
class HandShake {
 public:
  HandShake() = default;
  explicit HandShake(Random& random);

  /// About 1 degree and 3 mm, standard deviation.
  Eigen::Isometry3d pose(double time_s) const;

 private:
  double wave(int i, double time_s) const;

  double rate_rad_s_[6][3] = {}, phase_rad_[6][3] = {};
};

}  // namespace dynfilter::render
