// SPDX-License-Identifier: MIT
#include "eval/ate.hpp"

#include <dynfilter/core/error.hpp>
#include <string>

#include "io/association.hpp"

namespace dynfilter::eval {

Similarity align(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b, bool with_scale) {
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

AteResult absolute_trajectory_error(const io::Trajectory& truth, const io::Trajectory& estimate,
                                    const AteOptions& options) {
  std::vector<double> truth_s, estimate_s;
  for (const auto& pose : truth) truth_s.push_back(pose.timestamp_s);
  for (const auto& pose : estimate) estimate_s.push_back(pose.timestamp_s);
  const auto pairs = io::associate(truth_s, estimate_s, options.max_gap_s);
  if (pairs.size() < 3) {
    throw Error("the trajectories share " + std::to_string(pairs.size()) +
                " timestamps within tolerance, and three are needed" +
                (pairs.empty() ? ": are they of the same recording?" : ""));
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
