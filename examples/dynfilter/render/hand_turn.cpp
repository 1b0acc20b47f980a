// SPDX-License-Identifier: MIT
#include "render/hand_turn.hpp"

#include <algorithm>

namespace dynfilter::render {

HandTurn::HandTurn(double peak_rad_s, Random& random) {
  static constexpr double kRate[3][3] = {{0.15, 1.0, 0.35}, {0.1, 0.35, 0.6}, {0.25, 0.7, 0.3}};
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 3; ++k) {
      amplitude_rad_[axis][k] = 0.3 * kRate[axis][k] * random.uniform(0.7, 1.3) / harmonic_rad_s(k);
      phase_rad_[axis][k] = random.uniform(0, 2 * M_PI);
    }
  }
  for (int round = 0; round < 8; ++round) scale(peak_rad_s / peak_rate_rad_s());
}

double HandTurn::angle_rad(int axis, double time_s) const {
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += amplitude_rad_[axis][k] * std::sin(harmonic_rad_s(k) * time_s + phase_rad_[axis][k]);
  return sum;
}

inline double HandTurn::peak_rate_rad_s() const {
  constexpr int kSamples = 600;
  constexpr double kStep_s = kPeriod_s / kSamples;
  double peak = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Matrix3d step = rotation(i * kStep_s).transpose() * rotation((i + 1) * kStep_s);
    peak = std::max(peak, Eigen::AngleAxisd(step).angle() / kStep_s);
  }
  return peak;
}

inline void HandTurn::scale(double factor) {
  for (auto& axis : amplitude_rad_)
    for (double& amplitude : axis) amplitude *= factor;
}

HandShake::HandShake(Random& random) {
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 3; ++k) {
      rate_rad_s_[i][k] = 2 * M_PI * (5.0 + k + random.uniform());
      phase_rad_[i][k] = random.uniform(0, 2 * M_PI);
    }
  }
}

Eigen::Isometry3d HandShake::pose(double time_s) const {
  const Eigen::Matrix3d rotation = turn(0.014 * wave(0, time_s), Eigen::Vector3d::UnitY()) *
                                   turn(0.013 * wave(1, time_s), Eigen::Vector3d::UnitX()) *
                                   turn(0.009 * wave(2, time_s), Eigen::Vector3d::UnitZ());
  return frame_at(0.0025 * Eigen::Vector3d(wave(3, time_s), wave(4, time_s), wave(5, time_s)), rotation);
}

inline double HandShake::wave(int i, double time_s) const {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += std::sin(rate_rad_s_[i][k] * time_s + phase_rad_[i][k]);
  return sum;
}

}  // namespace dynfilter::render
