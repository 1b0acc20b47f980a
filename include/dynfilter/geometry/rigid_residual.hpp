// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <dynfilter/core/frame_view.hpp>
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
/// E is what the match can slide along an edge (core/frame_view.hpp). Sp is the noise of the reference point
/// (depth noise along its ray), G = d(u, v, z)/dp. C is the motion's covariance (translation, rotation; as in
/// RigidMotion), L = d(u, v, z)/d(motion). This is first-order propagation (Hartley and Zisserman, section
/// 5.2). The pixel noise is that of the match, so the reference pixel adds none. A static point exceeds 7.81
/// with probability 5 % and 11.34 with 1 %. Cost: about 0.1 us per point.
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
  Eigen::Vector3d slide(const MatchSpread& spread) const {
    const double sigma_px =
        noise_.pixel_sigma_px * std::sqrt(static_cast<double>(spread.along - spread.across));
    return sigma_px * Eigen::Vector3d(spread.edge.x, spread.edge.y, spread.depth_per_px);
  }

  /// r^T S^-1 r for the full S. With M = (I, -[q]x) and the blocks T, X, W of C, M C M^T = T + X[q]x +
  /// (X[q]x)^T - [q]x W [q]x. d(u, v, z)/dq is sparse. Scalar code takes half the time of the matrix form.
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

inline RigidResidualModel::RigidResidualModel(const Camera& camera, const Pose& T_current_reference,
                                              const RigidResidualNoise& noise,
                                              const double* motion_covariance)
    : camera_(camera), noise_(noise), R_(T_current_reference.R()), t_(T_current_reference.t()) {
  if (motion_covariance == nullptr) return;
  has_covariance_ = true;
  for (int k = 0; k < 3; ++k) {
    const double* row = motion_covariance + 6 * k;
    for (int c = 0; c < 3; ++c) T_(k, c) = row[c];
    X_[k] = {row[3], row[4], row[5]};
    W_[k] = {row[18 + 3], row[18 + 4], row[18 + 5]};
  }
}

// noinline keeps verdicts identical between header-only files.
// If GCC 12 inlines this at -O3, vectorisation changes the last bits from file to file.
[[gnu::noinline]] inline RigidResidual RigidResidualModel::operator()(const cv::Point3f& reference,
                                                                      const cv::Point3f& current,
                                                                      const MatchSpread& spread) const {
  RigidResidual out;
  Eigen::Vector3d p, q, r;
  if (!predict(reference, current, p, q, r, out)) return out;
  out.chi2 = static_cast<float>(has_covariance_ ? chi2_of_estimated_motion(r, p, q, current.z, spread)
                                                : chi2_of_exact_motion(r, p, q, current.z, spread));
  out.valid = std::isfinite(out.chi2);
  return out;
}

[[gnu::noinline]] inline RigidResidual RigidResidualModel::miss(const cv::Point3f& reference,
                                                                const cv::Point3f& current) const {
  RigidResidual out;
  Eigen::Vector3d p, q, r;
  out.valid = predict(reference, current, p, q, r, out) && std::isfinite(out.image_px);
  return out;
}

inline bool RigidResidualModel::predict(const cv::Point3f& reference, const cv::Point3f& current,
                                        Eigen::Vector3d& p, Eigen::Vector3d& q, Eigen::Vector3d& r,
                                        RigidResidual& out) const {
  if (!valid_depth(reference.z) || !valid_depth(current.z)) return false;
  p = {reference.x, reference.y, reference.z};
  q = R_ * p + t_;
  if (!(q.z() > kNearest_m)) return false;
  const double inv_z = 1 / q.z(), x = q.x() * inv_z, y = q.y() * inv_z;
  r = {camera_.fx_px * (current.x / current.z - x), camera_.fy_px * (current.y / current.z - y),
       current.z - q.z()};
  out.predicted_px = {static_cast<float>(x * camera_.fx_px + camera_.cx_px),
                      static_cast<float>(y * camera_.fy_px + camera_.cy_px)};
  out.predicted_depth_m = static_cast<float>(q.z());
  out.image_px = static_cast<float>(std::sqrt(r.x() * r.x() + r.y() * r.y()));
  out.depth_m = static_cast<float>(r.z());
  return true;
}

inline double RigidResidualModel::chi2_of_exact_motion(const Eigen::Vector3d& r, const Eigen::Vector3d& p,
                                                       const Eigen::Vector3d& q, double current_z,
                                                       const MatchSpread& spread) const {
  const double inv_z = 1 / q.z(), fx = camera_.fx_px * inv_z, fy = camera_.fy_px * inv_z;
  const double sz = noise_.depth_noise.sigma_m(current_z), along = noise_.depth_noise.sigma_m(p.z()) / p.z();
  const Eigen::Vector3d ray = q - t_;  // R p
  const Eigen::Vector3d w(along * fx * (ray.x() - q.x() * inv_z * ray.z()),
                          along * fy * (ray.y() - q.y() * inv_z * ray.z()), along * ray.z());
  const double du = 1 / (noise_.pixel_sigma_px * noise_.pixel_sigma_px * spread.across), dz = 1 / (sz * sz);
  const auto dot = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return du * (a.x() * b.x() + a.y() * b.y()) + dz * a.z() * b.z();
  };
  const double rw = dot(r, w), ww = 1 + dot(w, w);
  const double chi2 = dot(r, r) - rw * rw / ww;
  if (!spread.slides()) return chi2;
  const Eigen::Vector3d v = slide(spread);
  const double vw = dot(v, w), rv = dot(r, v) - rw * vw / ww, vv = 1 + dot(v, v) - vw * vw / ww;
  return chi2 - rv * rv / vv;
}

inline double RigidResidualModel::chi2_of_estimated_motion(const Eigen::Vector3d& r, const Eigen::Vector3d& p,
                                                           const Eigen::Vector3d& q, double current_z,
                                                           const MatchSpread& spread) const {
  const double inv_z = 1 / q.z(), x = q.x() * inv_z, y = q.y() * inv_z;
  const double fx = camera_.fx_px * inv_z, fy = camera_.fy_px * inv_z;
  const double along = noise_.depth_noise.sigma_m(p.z()) / p.z();
  Eigen::Vector3d ray = q - t_;  // R p
  ray *= along;
  const Eigen::Vector3d v = slide(spread);
  Eigen::Vector3d xq[3], wq[3];  // rows of X[q]x and W[q]x
  for (int k = 0; k < 3; ++k) xq[k] = X_[k].cross(q), wq[k] = W_[k].cross(q);
  const auto qwq = [&](int row, int column) {  // of [q]x W [q]x
    const int a = (row + 1) % 3, b = (row + 2) % 3;
    return q(a) * wq[b](column) - q(b) * wq[a](column);
  };
  const auto B = [&](int row, int column) {
    return T_(row, column) + xq[row](column) + xq[column](row) - qwq(row, column) + ray(row) * ray(column);
  };
  const double b00 = B(0, 0), b01 = B(0, 1), b02 = B(0, 2), b11 = B(1, 1), b12 = B(1, 2), b22 = B(2, 2);
  const double su2 = noise_.pixel_sigma_px * noise_.pixel_sigma_px * spread.across;
  const double sz = noise_.depth_noise.sigma_m(current_z);
  const double s00 = su2 + v.x() * v.x() + fx * fx * (b00 - 2 * x * b02 + x * x * b22);
  const double s11 = su2 + v.y() * v.y() + fy * fy * (b11 - 2 * y * b12 + y * y * b22);
  const double s01 = v.x() * v.y() + fx * fy * (b01 - y * b02 - x * b12 + x * y * b22);
  const double s02 = v.x() * v.z() + fx * (b02 - x * b22), s12 = v.y() * v.z() + fy * (b12 - y * b22);
  const double s22 = sz * sz + v.z() * v.z() + b22;
  const double a00 = s11 * s22 - s12 * s12, a01 = s02 * s12 - s01 * s22, a02 = s01 * s12 - s02 * s11;
  const double a11 = s00 * s22 - s02 * s02, a12 = s01 * s02 - s00 * s12, a22 = s00 * s11 - s01 * s01;
  const double determinant = s00 * a00 + s01 * a01 + s02 * a02;
  return (a00 * r.x() * r.x() + a11 * r.y() * r.y() + a22 * r.z() * r.z() +
          2 * (a01 * r.x() * r.y() + a02 * r.x() * r.z() + a12 * r.y() * r.z())) /
         determinant;
}

/// Residual of a pair of points in the frames of their cameras [m]. Of many pairs: RigidResidualModel.
inline RigidResidual rigid_residual(const Camera& camera, const Pose& T_current_reference,
                                    const cv::Point3f& reference, const cv::Point3f& current,
                                    const RigidResidualNoise& noise = {},
                                    const double* motion_covariance = nullptr) {
  return RigidResidualModel(camera, T_current_reference, noise, motion_covariance)(reference, current);
}

}  // namespace dynfilter
