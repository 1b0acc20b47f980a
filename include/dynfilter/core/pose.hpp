// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>

namespace dynfilter {

/// A rigid transform. `T_a_b` maps points of frame b to frame a: p_a = R p_b + t, t in metres. It holds plain
/// numbers because it crosses plugin boundaries. Eigen members would force one alignment on both sides.
struct Pose {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major
  std::array<double, 3> translation_m{};

  /// From the rotation and the translation [m].
  static Pose from(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
    Pose pose;
    for (Eigen::Index k = 0; k < 9; ++k) pose.rotation[static_cast<std::size_t>(k)] = R(k / 3, k % 3);
    pose.translation_m = {t.x(), t.y(), t.z()};
    return pose;
  }
  static Pose from(const Eigen::Isometry3d& T) { return from(T.linear(), T.translation()); }  ///< in metres
  /// Rotation matrix.
  Eigen::Matrix3d R() const {
    Eigen::Matrix3d R;
    for (Eigen::Index k = 0; k < 9; ++k) R(k / 3, k % 3) = rotation[static_cast<std::size_t>(k)];
    return R;
  }
  Eigen::Vector3d t() const { return {translation_m[0], translation_m[1], translation_m[2]}; }  ///< [m]
  /// As Eigen's transform, in metres.
  Eigen::Isometry3d isometry() const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = R();
    T.translation() = t();
    return T;
  }
};

/// T_b_a.
inline Pose inverse(const Pose& T_a_b) {
  const Eigen::Matrix3d Rt = T_a_b.R().transpose();
  const Eigen::Vector3d t = Rt * T_a_b.t();
  return Pose::from(Rt, {-t.x(), -t.y(), -t.z()});
}

/// T_a_c = T_a_b * T_b_c
inline Pose operator*(const Pose& T_a_b, const Pose& T_b_c) {
  return Pose::from(T_a_b.R() * T_b_c.R(), T_a_b.R() * T_b_c.t() + T_a_b.t());
}

/// The rotation by an angle about an axis of length 1 (Rodrigues). The same on every processor.
Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, double angle_rad);
/// The shortest rotation vector of R: its axis times the angle [rad].
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);
/// The rotation of a rotation vector.
Eigen::Matrix3d exp_so3(const Eigen::Vector3d& omega);

/// True if all entries are finite and the rotation is orthonormal and right-handed within `tolerance`.
bool is_rigid(const Pose& T_a_b, double tolerance = 1e-3);

/// What is known of the camera's motion without the images: from a gyroscope, from wheels, or from a filter's
/// prediction. It is weighed against the images, and ignored while it contradicts them.
struct MotionPrior {
  std::int64_t reference_frame_id = -1;  ///< frame that the motion begins at; -1: the one before this
  Pose T_current_reference;
  /// Row-major, of a left perturbation (translation [m], rotation [rad]), as of RigidMotion.
  std::array<double, 36> covariance{};
  bool has_translation = false;  ///< without it, only the rotation counts

  /// A gyroscope's. The covariance is that of a rotation of the current camera [rad^2].
  static MotionPrior turn(const Eigen::Matrix3d& R_current_reference, const Eigen::Matrix3d& covariance_rad2);
  Eigen::Matrix<double, 6, 6> covariance_matrix() const;  ///< the same numbers
  bool valid() const;  ///< the motion is rigid, variances that count are positive, all at most 1e6
};

/// Source of a pose. A filter must trust a prediction less than an estimate.
enum class PoseProvenance { None, Predicted, Estimated, Refined };

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/core/detail/pose-inl.hpp>
#endif
