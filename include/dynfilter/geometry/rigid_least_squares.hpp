// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <dynfilter/geometry/rigid_points.hpp>
#include <dynfilter/geometry/small_solve.hpp>

namespace dynfilter {

/// Robust losses of a point's squared normalised residual s, with scale c (Huber 1964; Black and Anandan
/// 1996; Beaton and Tukey 1974), as ceres::HuberLoss(c) and so on define them.
enum class RobustLoss { None, Huber, Cauchy, Tukey };

namespace detail {

/// rho'(s): the weight of iteratively reweighted least squares.
inline double robust_weight(RobustLoss loss, double s, double c2) {
  switch (loss) {
    case RobustLoss::None:
      return 1;
    case RobustLoss::Huber:
      return s <= c2 ? 1 : std::sqrt(c2 / s);
    case RobustLoss::Cauchy:
      return 1 / (1 + s / c2);
    case RobustLoss::Tukey: {
      const double v = 1 - s / c2;
      return v > 0 ? v * v : 0;
    }
  }
  return 1;
}

/// Normal equations of the perturbation (translation, rotation) from the left.
struct RigidNormal {
  Eigen::Matrix3d tt, tr, rr;  ///< blocks of J^T W J
  Eigen::Vector3d gt, gr;      ///< J^T W r
  double cost = 0;             ///< sum w chi2
  double weight_sum = 0;

  void clear() {
    tt.setZero(), tr.setZero(), rr.setZero();
    gt.setZero(), gr.setZero();
    cost = weight_sum = 0;
  }

  Eigen::Matrix<double, 6, 6> matrix() const {
    Eigen::Matrix<double, 6, 6> m;
    m << tt, tr, tr.transpose(), rr;
    return m;
  }
  Eigen::Matrix<double, 6, 1> gradient() const {
    Eigen::Matrix<double, 6, 1> g;
    g << gt, gr;
    return g;
  }

  /// Adds a point: J = A [I | -[q]x] with A = d residual / d q, so everything follows from M = A^T A (the
  /// rows of A are (A0 0 A1), (0 A2 A3), (0 0 A4)) and from f = A^T r.
  void add(const Eigen::Vector3d& q, const double (&A)[5], const double (&r)[3], double w) {
    const double a = A[0], ax = A[1], b = A[2], by = A[3], c = A[4];
    const double m00 = w * a * a, m02 = w * a * ax, m11 = w * b * b, m12 = w * b * by;
    const double m22 = w * (ax * ax + by * by + c * c);
    const double fx = w * a * r[0], fy = w * b * r[1], fz = w * (ax * r[0] + by * r[1] + c * r[2]);
    const double x = q.x(), y = q.y(), z = q.z();
    tt(0, 0) += m00, tt(0, 2) += m02, tt(1, 1) += m11, tt(1, 2) += m12, tt(2, 2) += m22;
    // -M [q]x, [q]x = (0 -z y; z 0 -x; -y x 0)
    const double n00 = m02 * y, n01 = m00 * z - m02 * x, n02 = -m00 * y;
    const double n10 = m12 * y - m11 * z, n11 = -m12 * x, n12 = m11 * x;
    const double n20 = m22 * y - m12 * z, n21 = m02 * z - m22 * x, n22 = m12 * x - m02 * y;
    tr(0, 0) += n00, tr(0, 1) += n01, tr(0, 2) += n02;
    tr(1, 0) += n10, tr(1, 1) += n11, tr(1, 2) += n12;
    tr(2, 0) += n20, tr(2, 1) += n21, tr(2, 2) += n22;
    // [q]x (-M [q]x)
    rr(0, 0) += y * n20 - z * n10, rr(0, 1) += y * n21 - z * n11, rr(0, 2) += y * n22 - z * n12;
    rr(1, 1) += z * n01 - x * n21, rr(1, 2) += z * n02 - x * n22, rr(2, 2) += x * n12 - y * n02;
    gt.x() += fx, gt.y() += fy, gt.z() += fz;
    gr.x() += y * fz - z * fy, gr.y() += z * fx - x * fz, gr.z() += x * fy - y * fx;
    cost += w * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    weight_sum += w;
  }

  void mirror() {
    tt(1, 0) = tt(0, 1), tt(2, 0) = tt(0, 2), tt(2, 1) = tt(1, 2);
    rr(1, 0) = rr(0, 1), rr(2, 0) = rr(0, 2), rr(2, 1) = rr(1, 2);
  }
};

inline void accumulate_rigid(const RigidPoints& points, RobustLoss loss, double scale2, std::size_t step,
                             const RigidTransform& T, RigidNormal& normal) {
  normal.clear();
  for (std::size_t k = 0; k < points.count; k += step) {
    const Eigen::Vector3d p = points.reference(k), q = T.R * p + T.t;
    const double cz = points.row(RigidPoints::kBz)[k], wz = points.row(RigidPoints::kWz)[k];
    double wx = points.row(RigidPoints::kWx)[k], wy = points.row(RigidPoints::kWy)[k];
    double u = 0, v = 0, r[3];
    if (points.image_depth) {
      if (q.z() < 1e-3) continue;  // behind the camera: no residual there
      const double inv_z = 1 / q.z();
      u = q.x() * inv_z, v = q.y() * inv_z;
      wx *= cz, wy *= cz;  // to f / sigma
      r[0] = wx * (u - points.row(RigidPoints::kAx)[k]), r[1] = wy * (v - points.row(RigidPoints::kAy)[k]);
      wx *= inv_z, wy *= inv_z;
    } else {
      r[0] = wx * (q.x() - points.row(RigidPoints::kBx)[k]);
      r[1] = wy * (q.y() - points.row(RigidPoints::kBy)[k]);
    }
    r[2] = wz * (q.z() - cz);
    const double s = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
    const double w = robust_weight(loss, s, scale2);
    if (w > 0) normal.add(q, {wx, -wx * u, wy, -wy * v, wz}, r, w);
  }
  normal.mirror();
}

inline Eigen::Matrix3d exp_so3(const Eigen::Vector3d& omega) {
  const double angle = omega.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, omega / angle).toRotationMatrix();
}

/// Iteratively reweighted Gauss-Newton on SE(3) over every `step`-th point, 6x6 normal equations. Leaves the
/// equations of the last linearisation in `normal`.
inline void refine_rigid(const RigidPoints& points, RobustLoss loss, double scale, int iterations,
                         std::size_t step, RigidTransform& T, RigidNormal& normal) {
  normal.clear();
  for (int i = 0; i < iterations; ++i) {
    accumulate_rigid(points, loss, scale * scale, step, T, normal);
    Eigen::Matrix<double, 6, 6> matrix = normal.matrix();
    Eigen::Matrix<double, 6, 1> delta = -normal.gradient();
    if (!(normal.weight_sum >= 2.5) || !solve_positive_definite(matrix.data(), delta.data(), 6)) return;
    if (!delta.allFinite()) return;
    const Eigen::Matrix3d turn = exp_so3(delta.tail<3>());
    T.R = turn * T.R;
    T.t = turn * T.t + delta.head<3>();
    if (delta.squaredNorm() < 1e-18) return;
  }
}

}  // namespace detail
}  // namespace dynfilter
