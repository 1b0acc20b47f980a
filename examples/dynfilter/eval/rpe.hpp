// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "eval/statistics.hpp"
#include "io/trajectory.hpp"

namespace dynfilter::eval {

/// Relative pose error: translation [m] and rotation [deg].
struct RpeResult {
  std::size_t pairs = 0;
  ErrorStatistics translation_m;
  /// All in degrees. The TUM tools print the median in radians under the name "deg".
  ErrorStatistics rotation_deg;
};

namespace detail {

std::vector<double> stamps_s(const io::Trajectory& trajectory);

inline double angle_rad(const Eigen::Matrix3d& R) {
  return std::acos(std::min(1.0, std::max(-1.0, (R.trace() - 1) / 2)));
}

}  // namespace detail

/// Relative pose error over pairs `delta_s` apart, as defined by evaluate_rpe.py of the TUM RGB-D benchmark
/// with --fixed_delta (Sturm et al., IROS 2012, sec. VI-A).
/// Each estimate starts a pair with the estimate closest to delta_s later, unless that is the last estimate.
/// A pair counts if both ends have ground truth within twice its median interval.
/// All pairs are used. The tool samples 10,000 of them if there are more (5 minutes at 30 Hz).
/// Trajectories must be sorted by time. Throws Error if fewer than two pairs remain.
RpeResult relative_pose_error(const io::Trajectory& truth, const io::Trajectory& estimate,
                              double delta_s = 1.0);

}  // namespace dynfilter::eval
