// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/eval/statistics.hpp>
#include <dynfilter/io/association.hpp>
#include <dynfilter/io/trajectory.hpp>
#include <vector>

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
inline Similarity align(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b, bool with_scale) {
  const Eigen::Vector3d mean_a = a.rowwise().mean(), mean_b = b.rowwise().mean();
  const Eigen::Matrix3Xd centred_a = a.colwise() - mean_a, centred_b = b.colwise() - mean_b;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(centred_a * centred_b.transpose(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs.z() = -1;
  Similarity s;
  s.R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  const double variance_b = centred_b.squaredNorm();
  if (with_scale && variance_b > 0) s.scale = svd.singularValues().dot(signs) / variance_b;
  s.t = mean_a - s.scale * s.R * mean_b;
  return s;
}

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

/// Absolute trajectory error of the camera position after alignment,
/// as defined by evaluate_ate.py of the TUM RGB-D benchmark (Sturm et al., IROS 2012, sec. VI-B).
/// Trajectories must be sorted by time. Throws Error if fewer than three timestamps match.
inline AteResult absolute_trajectory_error(const io::Trajectory& truth, const io::Trajectory& estimate,
                                           const AteOptions& options = {}) {
  std::vector<double> truth_s, estimate_s;
  for (const auto& pose : truth) truth_s.push_back(pose.timestamp_s);
  for (const auto& pose : estimate) estimate_s.push_back(pose.timestamp_s);
  const auto pairs = io::associate(truth_s, estimate_s, options.max_gap_s);
  if (pairs.size() < 3) {
    throw Error("the trajectories share " + std::to_string(pairs.size()) +
                " timestamps within tolerance, three are needed: are they of the same recording?");
  }
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  AteResult result;
  result.pairs = pairs.size();
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto& [i, j] = pairs[static_cast<std::size_t>(k)];
    a.col(k) = truth[i].T_world_camera.t();
    b.col(k) = estimate[j].T_world_camera.t();
    result.timestamps_s.push_back(truth_s[i]);
  }
  const Similarity s = align(a, b, options.with_scale);
  for (Eigen::Index k = 0; k < n; ++k) {
    result.errors_m.push_back((s.scale * s.R * b.col(k) + s.t - a.col(k)).norm());
  }
  result.T_truth_estimate = s;
  result.error_m = statistics(result.errors_m);
  return result;
}

}  // namespace dynfilter::eval
