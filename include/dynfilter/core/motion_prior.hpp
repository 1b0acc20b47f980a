// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/pose.hpp>

namespace dynfilter {

/// What is known of the camera's motion without the images: from a gyroscope, from wheels, or from a filter's
/// prediction. It is weighed against the images, and ignored while it contradicts them.
struct MotionPrior {
  std::int64_t reference_frame_id = -1;  ///< frame that the motion begins at; -1: the one before this
  Pose T_current_reference;
  /// Row-major covariance of a left perturbation (translation [m], rotation [rad]), as of RigidMotion.
  std::array<double, 36> covariance{};
  bool has_translation = false;  ///< without it, only the rotation counts

  /// A gyroscope's. The covariance is that of a rotation of the current camera [rad^2].
  static MotionPrior turn(const Eigen::Matrix3d& R_current_reference, const Eigen::Matrix3d& covariance_rad2) {
    MotionPrior prior;
    prior.T_current_reference = Pose::from(R_current_reference, Eigen::Vector3d::Zero());
    Eigen::Map<Matrix6>(prior.covariance.data()).bottomRightCorner<3, 3>() = covariance_rad2;
    return prior;
  }

  using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
  Matrix6 covariance_matrix() const { return Eigen::Map<const Matrix6>(covariance.data()); }
  /// Whether the motion is rigid, and every variance that counts positive and finite.
  bool valid() const {
    bool all = is_rigid(T_current_reference);
    for (int k = has_translation ? 0 : 3; k < 6; ++k) {
      const double variance = covariance[static_cast<std::size_t>(7 * k)];
      all = all && variance > 0 && std::isfinite(variance);
    }
    return all;
  }
};

}  // namespace dynfilter
