// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {

/// Assumed measurement noise when a point pair is judged against a rigid motion.
struct RigidResidualNoise {
  double pixel_sigma_px = 1.0;  ///< noise of the match between the frames, per axis
  DepthNoise depth_noise{};     ///< noise of both depths
};

/// Residual of one point pair.
/// Without depth in either frame, or behind the camera, `valid` is false and the numbers are NaN.
struct RigidResidual {
  bool valid = false;
  /// Predicted position of a static point, undistorted pixels of the current frame.
  cv::Point2f predicted_px;
  float predicted_depth_m = std::numeric_limits<float>::quiet_NaN();
  /// Distance of the measured pixel from predicted_px.
  float image_px = std::numeric_limits<float>::quiet_NaN();
  float depth_m = std::numeric_limits<float>::quiet_NaN();  ///< measured minus predicted depth
  float chi2 =
      std::numeric_limits<float>::quiet_NaN();  ///< normalised squared residual, 3 degrees of freedom
};

/// Predicts image position and depth (u, v, depth) of static reference points under q = R p + t.
/// Normalises the residual r:
///   chi2 = r^T S^-1 r,  S = diag(su^2, su^2, sz(c)^2) + G Sp G^T + E + L C L^T.
/// E is what the match can slide along an edge (core/frame_view.hpp).
/// Sp is the noise of the reference point (depth noise along its ray), G = d(u, v, z)/dp.
/// C is the motion's covariance (translation, rotation; as in RigidMotion), L = d(u, v, z)/d(motion).
/// This is first-order propagation (Hartley and Zisserman, section 5.2).
/// The pixel noise is that of the match, so the reference pixel adds none.
/// A static point exceeds 7.81 with probability 5 % and 11.34 with 1 %.
/// Cost: about 0.1 us per point.
class RigidResidualModel {
 public:
  /// `motion_covariance` has 36 numbers, row-major. Null means an exact motion.
  RigidResidualModel(const Camera& camera, const Pose& T_current_reference,
                     const RigidResidualNoise& noise = {}, const double* motion_covariance = nullptr);

  RigidResidual operator()(const cv::Point3f& reference, const cv::Point3f& current,
                           const MatchSpread& spread = {}) const;
  /// The same without chi2, at half the cost.
  RigidResidual miss(const cv::Point3f& reference, const cv::Point3f& current) const;

 private:
  bool predict(const cv::Point3f& reference, const cv::Point3f& current, Eigen::Vector3d& p,
               Eigen::Vector3d& q, Eigen::Vector3d& r, RigidResidual& out) const;
  /// S = D + w w^T + v v^T with D diagonal. The Woodbury formula inverts it.
  double chi2_of_exact_motion(const Eigen::Vector3d& r, const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                              double current_z, const MatchSpread& spread) const;
  /// v of E = v v^T.
  Eigen::Vector3d slide(const MatchSpread& spread) const;

  /// r^T S^-1 r for the full S. With M = (I, -[q]x) and the blocks T, X, W of C, M C M^T = T + X[q]x +
  /// (X[q]x)^T - [q]x W [q]x. d(u, v, z)/dq is sparse.
  /// Scalar code takes half the time of the matrix form.
  double chi2_of_estimated_motion(const Eigen::Vector3d& r, const Eigen::Vector3d& p,
                                  const Eigen::Vector3d& q, double current_z,
                                  const MatchSpread& spread) const;

  static constexpr double kNearest_m = 1e-3;  ///< in front of the camera

  Camera camera_;
  RigidResidualNoise noise_;
  Eigen::Matrix3d R_;
  Eigen::Vector3d t_;
  Eigen::Matrix3d T_;            ///< covariance of the translation
  Eigen::Vector3d X_[3], W_[3];  ///< rows: of translation with rotation, of the rotation
  bool has_covariance_ = false;
};

/// Residual of one point pair. Create a RigidResidualModel for many pairs.
RigidResidual rigid_residual(const Camera& camera, const Pose& T_current_reference,
                             const cv::Point3f& reference, const cv::Point3f& current,
                             const RigidResidualNoise& noise = {}, const double* motion_covariance = nullptr);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/geometry/detail/rigid_residual-inl.hpp>
#endif
