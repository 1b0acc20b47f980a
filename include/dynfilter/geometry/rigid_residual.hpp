// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/epipolar.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {

/// What is assumed about the measurements when a point pair is judged against a rigid motion.
struct RigidResidualNoise {
  double pixel_sigma_px = 1.0;  ///< of the match between the frames, per axis
  DepthNoise depth_noise{};     ///< of both depths
};

/// Judgement of one point pair. Without depth in either frame, or with the point behind the camera: `valid`
/// is false and the numbers are NaN.
struct RigidResidual {
  bool valid = false;
  cv::Point2f predicted_px;  ///< where a static point would be seen, undistorted pixels of the current frame
  float predicted_depth_m = std::numeric_limits<float>::quiet_NaN();
  float image_px = std::numeric_limits<float>::quiet_NaN();  ///< distance from there to the measured pixel
  float depth_m = std::numeric_limits<float>::quiet_NaN();   ///< measured minus predicted depth
  float chi2 =
      std::numeric_limits<float>::quiet_NaN();  ///< normalised squared residual, 3 degrees of freedom
};

/// Predicts the static appearance (u, v, depth) of reference points under q = R p + t and normalises the miss
/// r,
///   chi2 = r^T S^-1 r,  S = diag(su^2, su^2, sz(c)^2) + G Sp G^T + L C L^T,
/// with Sp the noise of the reference point (depth noise along its ray), G = d(u, v, z)/dp, and C the
/// motion's covariance (translation, rotation; as in RigidMotion), L = d(u, v, z)/d(motion). First-order
/// propagation (Hartley and Zisserman, sec. 5.2). The pixel noise is that of the match, so the reference
/// pixel carries none of its own. A static point exceeds 7.81 with 5 % and 11.34 with 1 % probability. About
/// 0.1 us a point.
class RigidResidualModel {
 public:
  /// `motion_covariance`: 36 numbers, row-major; null: the motion is taken as exact.
  RigidResidualModel(const Camera& camera, const Pose& T_current_reference,
                     const RigidResidualNoise& noise = {}, const double* motion_covariance = nullptr)
      : camera_(camera), noise_(noise), R_(T_current_reference.R()), t_(T_current_reference.t()) {
    if (motion_covariance == nullptr) return;
    has_covariance_ = true;
    C_ = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(motion_covariance);
  }

  RigidResidual operator()(const cv::Point3f& reference, const cv::Point3f& current) const {
    RigidResidual out;
    if (!has_depth(reference.z) || !has_depth(current.z)) return out;
    const Eigen::Vector3d p(reference.x, reference.y, reference.z), q = R_ * p + t_;
    if (!(q.z() > 1e-3)) return out;
    const double inv_z = 1 / q.z(), x = q.x() * inv_z, y = q.y() * inv_z;
    const Eigen::Vector3d r(camera_.fx_px * (current.x / current.z - x),
                            camera_.fy_px * (current.y / current.z - y), current.z - q.z());
    out.predicted_px = {static_cast<float>(x * camera_.fx_px + camera_.cx_px),
                        static_cast<float>(y * camera_.fy_px + camera_.cy_px)};
    out.predicted_depth_m = static_cast<float>(q.z());
    out.image_px = static_cast<float>(std::sqrt(r.x() * r.x() + r.y() * r.y()));
    out.depth_m = static_cast<float>(r.z());
    out.chi2 = static_cast<float>(has_covariance_ ? r.dot(covariance(p, q, current.z).inverse() * r)
                                                  : chi2_of_exact_motion(r, p, q, current.z));
    out.valid = std::isfinite(out.chi2);
    return out;
  }

 private:
  /// S = D + w w^T with D diagonal: its inverse is that of Sherman and Morrison.
  double chi2_of_exact_motion(const Eigen::Vector3d& r, const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                              double current_z) const {
    const double inv_z = 1 / q.z(), fx = camera_.fx_px * inv_z, fy = camera_.fy_px * inv_z;
    const double sz = noise_.depth_noise.sigma_m(current_z),
                 along = noise_.depth_noise.sigma_m(p.z()) / p.z();
    const Eigen::Vector3d ray = q - t_;  // R p
    const Eigen::Vector3d w(along * fx * (ray.x() - q.x() * inv_z * ray.z()),
                            along * fy * (ray.y() - q.y() * inv_z * ray.z()), along * ray.z());
    const double du = 1 / (noise_.pixel_sigma_px * noise_.pixel_sigma_px), dz = 1 / (sz * sz);
    const double rr = du * (r.x() * r.x() + r.y() * r.y()) + dz * r.z() * r.z();
    const double rw = du * (r.x() * w.x() + r.y() * w.y()) + dz * r.z() * w.z();
    const double ww = du * (w.x() * w.x() + w.y() * w.y()) + dz * w.z() * w.z();
    return rr - rw * rw / (1 + ww);
  }

  Eigen::Matrix3d covariance(const Eigen::Vector3d& p, const Eigen::Vector3d& q, double current_z) const {
    const double inv_z = 1 / q.z(), fx = camera_.fx_px * inv_z, fy = camera_.fy_px * inv_z;
    Eigen::Matrix3d G;  // d(u, v, z) / dq
    G << fx, 0, -fx * q.x() * inv_z, 0, fy, -fy * q.y() * inv_z, 0, 0, 1;
    const double su = noise_.pixel_sigma_px, sz = noise_.depth_noise.sigma_m(current_z);
    // The reference point moves along its ray by its depth noise.
    const Eigen::Vector3d ray = G * (R_ * p) * (noise_.depth_noise.sigma_m(p.z()) / p.z());
    Eigen::Matrix3d S = ray * ray.transpose();
    S.diagonal() += Eigen::Vector3d(su * su, su * su, sz * sz);
    if (has_covariance_) {
      Eigen::Matrix<double, 3, 6> L;
      L << G, -G * detail::cross_matrix(q);
      S.noalias() += L * C_ * L.transpose();
    }
    return S;
  }

  Camera camera_;
  RigidResidualNoise noise_;
  Eigen::Matrix3d R_;
  Eigen::Vector3d t_;
  Eigen::Matrix<double, 6, 6> C_;
  bool has_covariance_ = false;
};

/// One point pair against one motion; for many pairs make a RigidResidualModel.
inline RigidResidual rigid_residual(const Camera& camera, const Pose& T_current_reference,
                                    const cv::Point3f& reference, const cv::Point3f& current,
                                    const RigidResidualNoise& noise = {},
                                    const double* motion_covariance = nullptr) {
  return RigidResidualModel(camera, T_current_reference, noise, motion_covariance)(reference, current);
}

}  // namespace dynfilter
