// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <dynfilter/core/camera.hpp>

namespace dynfilter::odometry {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

/// A pinhole camera without distortion, and the factor that converts inverse depth to disparity.
struct Pinhole {
  double fx_px, fy_px, cx_px, cy_px, baseline_fx_px_m;

  Pinhole(const Camera& camera, double baseline_fx)
      : fx_px(camera.fx_px),
        fy_px(camera.fy_px),
        cx_px(camera.cx_px),
        cy_px(camera.cy_px),
        baseline_fx_px_m(baseline_fx) {}

  /// u, v and disparity [px] of a point in front of the camera.
  Eigen::Vector3d project(const Eigen::Vector3d& p_camera_m) const {
    const double inverse = 1.0 / p_camera_m.z();
    return {fx_px * p_camera_m.x() * inverse + cx_px, fy_px * p_camera_m.y() * inverse + cy_px,
            baseline_fx_px_m * inverse};
  }
  Eigen::Vector3d back_project(double u_px, double v_px, double depth_m) const {
    return {(u_px - cx_px) / fx_px * depth_m, (v_px - cy_px) / fy_px * depth_m, depth_m};
  }
  /// d project / d p_camera
  Eigen::Matrix3d jacobian(const Eigen::Vector3d& p_camera_m) const {
    const double inverse = 1.0 / p_camera_m.z(), squared = inverse * inverse;
    Eigen::Matrix3d J;
    J << fx_px * inverse, 0, -fx_px * p_camera_m.x() * squared,  //
        0, fy_px * inverse, -fy_px * p_camera_m.y() * squared,   //
        0, 0, -baseline_fx_px_m * squared;
    return J;
  }
};

/// One observation of a point: pixel, disparity and their weights (1/sigma).
/// Weight 0 means no depth.
struct Sighting {
  Eigen::Vector3d measured_px;
  double pixel_weight = 1, disparity_weight = 0;
  /// What it may slide along an edge: one standard deviation of (u, v, disparity) [px].
  Eigen::Vector3d slide_px = Eigen::Vector3d::Zero();

  /// W with W^T W the inverse of the covariance diag(1 / weights^2) + slide slide^T.
  Eigen::Matrix3d whitening() const {
    const Eigen::Vector3d w(pixel_weight, pixel_weight, disparity_weight), s = w.cwiseProduct(slide_px);
    Eigen::Matrix3d W = w.asDiagonal();
    const double s2 = s.squaredNorm();
    if (s2 > 0) W -= ((1 - 1 / std::sqrt(1 + s2)) / s2) * s * s.cwiseProduct(w).transpose();
    return W;
  }
  /// 95 % quantile of chi-square for two or three residuals.
  double chi2_limit() const { return disparity_weight > 0 ? 7.815 : 5.991; }
};

inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

/// exp(xi) T: a small motion of the camera frame; xi = (translation [m], rotation vector [rad]).
inline Eigen::Isometry3d moved(const Eigen::Isometry3d& T_camera_world, const Vector6d& xi) {
  const double angle = xi.tail<3>().norm();
  const Eigen::Vector3d axis =
      angle > 0 ? Eigen::Vector3d(xi.tail<3>() / angle) : Eigen::Vector3d(Eigen::Vector3d::UnitX());
  const Eigen::Quaterniond q =
      Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)) * Eigen::Quaterniond(T_camera_world.linear());
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = Eigen::AngleAxisd(angle, axis) * T_camera_world.translation() + xi.head<3>();
  return T;
}

/// d (R p + t) / d xi for the motion above.
inline Matrix36d point_jacobian(const Eigen::Vector3d& p_camera_m) {
  Matrix36d J;
  J << Eigen::Matrix3d::Identity(), -skew(p_camera_m);
  return J;
}

}  // namespace dynfilter::odometry
