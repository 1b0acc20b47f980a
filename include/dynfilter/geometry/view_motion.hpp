// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <dynfilter/geometry/small_solve.hpp>
#include <vector>

namespace dynfilter {

/// How the camera moved between two views, up to the length of its step: five degrees of freedom. A focal
/// length that is only roughly known does little harm while the camera turns by a few degrees.
struct ViewMotion {
  std::array<double, 3> rotation_rad{};      ///< axis times angle; turns current rays into the reference's
  std::array<double, 3> direction{0, 0, 1};  ///< of the current camera's centre, unit length; 0: no baseline
  double focal_px = 1;

  bool has_baseline() const { return direction != std::array<double, 3>{}; }
};

/// A point in two views: undistorted pixels against the principal point.
struct ViewPair {
  double reference_x = 0, reference_y = 0, x = 0, y = 0;
};

/// What is left of a point's flow when the camera's turn is taken out, in the reference view.
struct ViewFlow {
  double across_px = 0;  ///< off its epipolar line; without a baseline: to the right
  double along_px = 0;   ///< along it, positive as static points flow; without a baseline: downwards
  /// Length of the camera's step over the depth; 0 without a baseline.
  double inverse_depth = 0;

  double length_px() const { return std::hypot(across_px, along_px); }
};

/// Splits flows by a motion. With q the current point turned back, a the reference point, f the focal length
/// and c the direction, a static point obeys q - a = mu (q c_z - f c_xy) with mu = step / depth >= 0
/// (Longuet-Higgins and Prazdny 1980, in its finite form).
class ViewFlowModel {
 public:
  explicit ViewFlowModel(const ViewMotion& motion)
      : c_(motion.direction), f_(motion.focal_px), baseline_(motion.has_baseline()) {
    rotation_matrix(motion.rotation_rad);
  }

  ViewFlow operator()(const ViewPair& p) const {
    const double z = R_[6] * p.x + R_[7] * p.y + R_[8] * f_;
    if (!(z > 0.05 * f_)) return {1e3, 0, 0};  // turned out of view
    const double qx = f_ * (R_[0] * p.x + R_[1] * p.y + R_[2] * f_) / z,
                 qy = f_ * (R_[3] * p.x + R_[4] * p.y + R_[5] * f_) / z;
    const double ex = qx - p.reference_x, ey = qy - p.reference_y;
    if (!baseline_) return {ex, ey, 0};
    const double dx = qx * c_[2] - f_ * c_[0], dy = qy * c_[2] - f_ * c_[1];
    const double squared = dx * dx + dy * dy + 1;  // + 1 px: near the focus of expansion lines mean nothing
    const double mu = (ex * dx + ey * dy) / squared, length = std::sqrt(squared);
    return {(ex * dy - ey * dx) / length, mu * length, mu};
  }

 private:
  void rotation_matrix(const std::array<double, 3>& w) {
    const double angle2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2], angle = std::sqrt(angle2);
    const double a = angle > 1e-9 ? std::sin(angle) / angle : 1,
                 b = angle > 1e-9 ? (1 - std::cos(angle)) / angle2 : 0.5;
    const double x = w[0], y = w[1], z = w[2];
    R_ = {1 - b * (y * y + z * z), -a * z + b * x * y,      a * y + b * x * z,
          a * z + b * x * y,       1 - b * (x * x + z * z), -a * x + b * y * z,
          -a * y + b * x * z,      a * x + b * y * z,       1 - b * (x * x + y * y)};
  }

  std::array<double, 9> R_{};
  std::array<double, 3> c_;
  double f_;
  bool baseline_;
};

namespace detail {

inline void normalise(std::array<double, 3>& v) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (length > 0)
    for (double& x : v) x /= length;
}

inline std::array<double, 3> cross(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The motion after a small step: three for the rotation, two that turn the direction.
inline ViewMotion stepped(const ViewMotion& motion, const double (&step)[5]) {
  ViewMotion out = motion;
  for (std::size_t k = 0; k < 3; ++k) out.rotation_rad[k] += step[k];
  if (!motion.has_baseline()) return out;
  const auto& c = motion.direction;
  std::array<double, 3> axis{};
  std::size_t smallest = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (std::abs(c[k]) < std::abs(c[smallest])) smallest = k;
  axis[smallest] = 1;
  std::array<double, 3> u = cross(c, axis);
  normalise(u);
  const std::array<double, 3> v = cross(c, u);
  for (std::size_t k = 0; k < 3; ++k) out.direction[k] += step[3] * u[k] + step[4] * v[k];
  normalise(out.direction);
  return out;
}

}  // namespace detail

/// Gauss-Newton on the distances of `pairs[i]`, i in `which`, to their epipolar lines; without a baseline on
/// the flow that the rotation leaves. Cauchy weights of scale `sigma_px` (0: plain squares) times
/// `weights[i]` (may be empty). Numbers are differentiated, which five parameters allow. Cost: 6 residuals a
/// point and iteration.
inline ViewMotion refine_view_motion(ViewMotion motion, const std::vector<ViewPair>& pairs,
                                     const std::vector<int>& which, const std::vector<double>& weights,
                                     double sigma_px, int iterations) {
  constexpr double kDelta[5] = {1e-5, 1e-5, 1e-5, 1e-4, 1e-4};
  const bool baseline = motion.has_baseline();
  const int n = baseline ? 5 : 3;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const ViewFlowModel model(motion);
    const auto moved = [&](int k) {
      double step[5] = {};
      if (k < n) step[k] = kDelta[k];
      return ViewFlowModel(detail::stepped(motion, step));
    };
    const ViewFlowModel nearby[5] = {moved(0), moved(1), moved(2), moved(3), moved(4)};
    double A[25] = {}, b[5] = {};
    for (const int index : which) {
      const auto i = static_cast<std::size_t>(index);
      const ViewFlow r = model(pairs[i]);
      const double squared = r.across_px * r.across_px + (baseline ? 0 : r.along_px * r.along_px);
      double weight = weights.empty() ? 1 : weights[i];
      if (sigma_px > 0) weight /= 1 + squared / (sigma_px * sigma_px);
      double J[2][5];
      for (int k = 0; k < n; ++k) {
        const ViewFlow d = nearby[k](pairs[i]);
        J[0][k] = (d.across_px - r.across_px) / kDelta[k];
        J[1][k] = baseline ? 0 : (d.along_px - r.along_px) / kDelta[k];
      }
      for (int p = 0; p < n; ++p) {
        b[p] -= weight * (J[0][p] * r.across_px + J[1][p] * r.along_px);
        for (int q = 0; q <= p; ++q) A[p * n + q] += weight * (J[0][p] * J[0][q] + J[1][p] * J[1][q]);
      }
    }
    for (int p = 0; p < n; ++p) {
      A[p * n + p] = A[p * n + p] * 1.001 + 1e-6;
      for (int q = p + 1; q < n; ++q) A[p * n + q] = A[q * n + p];
    }
    if (!detail::solve_positive_definite(A, b, n)) break;
    double largest = 0;
    for (int k = 0; k < n; ++k) largest = std::max(largest, std::abs(b[k]));
    if (!(largest < 1e6)) break;
    const double shorten = largest > 0.5 ? 0.5 / largest : 1;  // half a radian at most
    double step[5] = {};
    for (int k = 0; k < n; ++k) step[k] = b[k] * shorten;
    motion = detail::stepped(motion, step);
    if (largest < 1e-6) break;
  }
  return motion;
}

}  // namespace dynfilter
