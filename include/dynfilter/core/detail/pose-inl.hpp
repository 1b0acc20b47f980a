// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/pose.hpp>

#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>

namespace dynfilter {

DYNFILTER_INLINE Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, double angle_rad) {
  const double c = portable::cos(angle_rad);
  const Eigen::Vector3d& a = axis;
  const Eigen::Vector3d versine = (1 - c) * a, s = portable::sin(angle_rad) * a;
  Pose pose;
  pose.rotation = {versine.x() * a.x() + c,     versine.x() * a.y() - s.z(), versine.x() * a.z() + s.y(),
                   versine.x() * a.y() + s.z(), versine.y() * a.y() + c,     versine.y() * a.z() - s.x(),
                   versine.x() * a.z() - s.y(), versine.y() * a.z() + s.x(), versine.z() * a.z() + c};
  return pose.R();
}

DYNFILTER_INLINE Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  const Eigen::Vector3d axis(q.x(), q.y(), q.z());
  const double half_sine = axis.norm();
  if (!(half_sine > 0)) return Eigen::Vector3d::Zero();
  const double angle_rad = 2 * portable::atan2(half_sine, std::abs(q.w()));
  return (std::copysign(angle_rad, q.w()) / half_sine) * axis;
}

DYNFILTER_INLINE bool is_rigid(const Pose& T_a_b, double tolerance) {
  for (const double value : T_a_b.rotation)
    if (!std::isfinite(value)) return false;
  for (const double value : T_a_b.translation_m)
    if (!std::isfinite(value)) return false;
  const Eigen::Matrix3d R = T_a_b.R(), RRt = R * R.transpose();
  for (Eigen::Index k = 0; k < 9; ++k)
    if (!(std::abs(RRt(k / 3, k % 3) - (k % 4 == 0 ? 1 : 0)) <= tolerance)) return false;
  return R.determinant() > 0;
}

DYNFILTER_INLINE MotionPrior MotionPrior::turn(const Eigen::Matrix3d& R_current_reference,
                                               const Eigen::Matrix3d& covariance_rad2) {
  MotionPrior prior;
  prior.T_current_reference = Pose::from(R_current_reference, Eigen::Vector3d::Zero());
  for (std::size_t k = 0; k < 9; ++k)
    prior.covariance[6 * (3 + k / 3) + 3 + k % 3] =
        covariance_rad2(static_cast<Eigen::Index>(k / 3), static_cast<Eigen::Index>(k % 3));
  return prior;
}

DYNFILTER_INLINE Eigen::Matrix<double, 6, 6> MotionPrior::covariance_matrix() const {
  Eigen::Matrix<double, 6, 6> C;
  for (Eigen::Index k = 0; k < 36; ++k) C(k / 6, k % 6) = covariance[static_cast<std::size_t>(k)];
  return C;
}

DYNFILTER_INLINE bool MotionPrior::valid() const {
  constexpr double kMost = 1e6;  // a kilometre: more says nothing, and products stay finite
  bool all = is_rigid(T_current_reference);
  const std::size_t first = has_translation ? 0 : 3;
  for (std::size_t row = first; row < 6; ++row) {
    all = all && covariance[7 * row] > 0;
    for (std::size_t column = first; column < 6; ++column)
      all = all && std::abs(covariance[6 * row + column]) <= kMost;
  }
  return all;
}

DYNFILTER_INLINE Eigen::Matrix3d exp_so3(const Eigen::Vector3d& omega) {
  const double angle = omega.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return rotation_about(omega / angle, angle);
}

}  // namespace dynfilter
