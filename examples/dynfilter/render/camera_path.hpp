// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <dynfilter/core/random.hpp>
#include <memory>

#include "render/hand_turn.hpp"
#include "render/motion.hpp"
#include "render/route.hpp"

namespace dynfilter::render {

/// Camera (x right, y down, z forward) at `eye` that looks at `target` with a level horizon.
/// World z is up.
Eigen::Isometry3d look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

/// Static to Halfsphere are the camera motions of TUM.
/// Sideways is along x only, Tracking follows a walking person.
/// Turn is the motion of freiburg1_rpy at a given rate.
/// Driving is on the roof of a car, Flying that of a fast flying robot in a hall.
enum class CameraStyle {
  Static,
  Xyz,
  Rpy,
  Halfsphere,
  Sideways,
  Tracking,
  Turn,
  Shake,
  Tripod,
  Driving,
  Flying
};

/// Smooth hand-held motion. A function of time only, different per seed.
class CameraMotion {
 public:
  struct Options {
    CameraStyle style = CameraStyle::Static;
    Eigen::Vector3d eye_m{0, -2.3, 1.45}, target_m{0, 0.8, 0.98};
    std::shared_ptr<const Walking> tracked;
    double peak_deg_s = 0;                 ///< Turn: largest angular rate
    std::shared_ptr<const Driving> drive;  ///< Driving: the car
  };

  CameraMotion(const Options& options, Random& random);

  Eigen::Isometry3d pose(double time_s) const;

 private:
  double wave(double time_s, double period_s, int phase) const {
    return std::sin(2 * M_PI * time_s / period_s + phase_[phase]);
  }

  /// About 1 mm and 0.06 degrees, standard deviation.
  Eigen::Isometry3d tremor(double t) const;

  Eigen::Isometry3d xyz(double t) const;

  /// At most about 45 degrees per second.
  Eigen::Isometry3d rpy(double t) const;

  Eigen::Isometry3d turned(double t) const;

  Eigen::Isometry3d shaken(double t) const;

  Eigen::Isometry3d halfsphere(double t) const;

  Eigen::Isometry3d sideways(double t) const;

  Eigen::Isometry3d tracking(double t) const;

  Eigen::Isometry3d driving(double t) const;

  /// Up to about 3 m/s and 80 degrees per second.
  Eigen::Isometry3d flying(double t) const;

  Options options_;
  double phase_[8];
  HandTurn turn_;
  HandShake shake_;
};

}  // namespace dynfilter::render
