// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cstddef>
#include <vector>

#include "eval/statistics.hpp"
#include "io/trajectory.hpp"

namespace dynfilter::eval {

/// p_a = scale R p_b + t
struct Similarity {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  double scale = 1;
};

/// The similarity that maps `b` to `a` with the smallest sum of squares.
/// Without `with_scale`, the rigid motion. Horn 1987; Umeyama 1991, eq. 34-43.
/// Columns are points. Both need the same number, at least one.
Similarity align(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b, bool with_scale);

/// Options of absolute_trajectory_error().
struct AteOptions {
  double max_gap_s = 0.02;  ///< largest time difference of a pair
  bool with_scale = false;  ///< Sim(3) instead of SE(3), for monocular systems
};

/// Absolute trajectory error [m] and the alignment behind it.
struct AteResult {
  std::size_t pairs = 0;
  ErrorStatistics error_m;
  Similarity T_truth_estimate;  ///< the alignment
  /// Per pair: timestamp of the ground truth, distance after alignment.
  std::vector<double> timestamps_s, errors_m;
};

/// Absolute trajectory error of the camera position after alignment, as defined by evaluate_ate.py of the TUM
/// RGB-D benchmark (Sturm et al., IROS 2012, sec. VI-B).
/// Trajectories must be sorted by time. Throws Error if fewer than three timestamps match.
AteResult absolute_trajectory_error(const io::Trajectory& truth, const io::Trajectory& estimate,
                                    const AteOptions& options = {});

}  // namespace dynfilter::eval
