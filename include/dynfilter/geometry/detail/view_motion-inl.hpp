// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/view_motion.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/geometry/small_solve.hpp>
#include <vector>

namespace dynfilter {

DYNFILTER_INLINE ViewFlowModel::ViewFlowModel(const ViewMotion& motion)
    : c_(motion.direction), f_(motion.focal_px), baseline_(motion.has_baseline()) {
  rotation_matrix(motion.rotation_rad);
}

inline void ViewFlowModel::by_turn(double qx, double qy, double by_qx, double by_qy,
                                   Gradient& gradient) const {
  const double radial = (by_qx * qx + by_qy * qy) / f_;
  gradient.turn[0] = -qy * radial - f_ * by_qy;
  gradient.turn[1] = f_ * by_qx + qx * radial;
  gradient.turn[2] = qx * by_qy - qy * by_qx;
}

inline void ViewFlowModel::rotation_matrix(const std::array<double, 3>& w) {
  const double angle2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2], angle = std::sqrt(angle2);
  const double a = angle > 1e-9 ? std::sin(angle) / angle : 1,
               b = angle > 1e-9 ? (1 - std::cos(angle)) / angle2 : 0.5;
  const double x = w[0], y = w[1], z = w[2];
  R_ = {1 - b * (y * y + z * z), -a * z + b * x * y,      a * y + b * x * z,
        a * z + b * x * y,       1 - b * (x * x + z * z), -a * x + b * y * z,
        -a * y + b * x * z,      a * x + b * y * z,       1 - b * (x * x + y * y)};
}

DYNFILTER_INLINE bool ViewFlowModel::across(const ViewPair& p, double& across_px, Gradient& gradient) const {
  const double z = R_[6] * p.x + R_[7] * p.y + R_[8] * f_;
  if (!(z > 0.05 * f_)) return false;
  const double scale = f_ / z, qx = scale * (R_[0] * p.x + R_[1] * p.y + R_[2] * f_),
               qy = scale * (R_[3] * p.x + R_[4] * p.y + R_[5] * f_);
  const double ex = qx - p.reference_x, ey = qy - p.reference_y;
  const double dx = qx * c_[2] - f_ * c_[0], dy = qy * c_[2] - f_ * c_[1];
  const double inverse = 1 / std::sqrt(dx * dx + dy * dy + 1), ux = dx * inverse, uy = dy * inverse;
  across_px = ex * uy - ey * ux;
  const double by_dx = -(ey + across_px * ux) * inverse, by_dy = (ex - across_px * uy) * inverse;
  gradient.direction[0] = -f_ * by_dx;
  gradient.direction[1] = -f_ * by_dy;
  gradient.direction[2] = by_dx * qx + by_dy * qy;
  by_turn(qx, qy, uy + c_[2] * by_dx, c_[2] * by_dy - ux, gradient);
  return true;
}

DYNFILTER_INLINE bool ViewFlowModel::rest(const ViewPair& p, double (&rest_px)[2],
                                          Gradient (&gradients)[2]) const {
  const double z = R_[6] * p.x + R_[7] * p.y + R_[8] * f_;
  if (!(z > 0.05 * f_)) return false;
  const double scale = f_ / z, qx = scale * (R_[0] * p.x + R_[1] * p.y + R_[2] * f_),
               qy = scale * (R_[3] * p.x + R_[4] * p.y + R_[5] * f_);
  rest_px[0] = qx - p.reference_x;
  rest_px[1] = qy - p.reference_y;
  by_turn(qx, qy, 1, 0, gradients[0]);
  by_turn(qx, qy, 0, 1, gradients[1]);
  return true;
}

namespace detail {

DYNFILTER_INLINE void normalise(std::array<double, 3>& v) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (length > 0)
    for (double& x : v) x /= length;
}

inline std::array<double, 3> cross(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

DYNFILTER_INLINE std::array<std::array<double, 3>, 2> tangents(const std::array<double, 3>& c) {
  std::array<double, 3> axis{};
  std::size_t smallest = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (std::abs(c[k]) < std::abs(c[smallest])) smallest = k;
  axis[smallest] = 1;
  std::array<double, 3> u = cross(c, axis);
  normalise(u);
  return {u, cross(c, u)};
}

DYNFILTER_INLINE ViewMotion stepped(const ViewMotion& motion, const double (&step)[5]) {
  ViewMotion out = motion;
  for (std::size_t k = 0; k < 3; ++k) out.rotation_rad[k] += step[k];
  if (!motion.has_baseline()) return out;
  const auto [u, v] = tangents(motion.direction);
  for (std::size_t k = 0; k < 3; ++k) out.direction[k] += step[3] * u[k] + step[4] * v[k];
  normalise(out.direction);
  return out;
}

DYNFILTER_INLINE std::array<std::array<double, 3>, 3> turns_by_step(const std::array<double, 3>& w) {
  const double angle2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2], angle = std::sqrt(angle2);
  const double a = angle > 1e-4 ? (1 - std::cos(angle)) / angle2 : 0.5,
               b = angle > 1e-4 ? (angle - std::sin(angle)) / (angle2 * angle) : 1.0 / 6;
  std::array<std::array<double, 3>, 3> columns;
  for (std::size_t k = 0; k < 3; ++k) {
    std::array<double, 3> e{};
    e[k] = 1;
    const std::array<double, 3> once = cross(w, e), twice = cross(w, once);
    for (std::size_t m = 0; m < 3; ++m) columns[k][m] = e[m] + a * once[m] + b * twice[m];
  }
  return columns;
}

/// Normal equations of residuals with derivatives of type ViewFlowModel::Gradient.
class ViewMotionEquations {
 public:
  explicit ViewMotionEquations(const ViewMotion& motion)
      : n_(motion.has_baseline() ? 5 : 3), turns_(turns_by_step(motion.rotation_rad)) {
    if (n_ == 5) tangents_ = tangents(motion.direction);
  }

  void add(double residual, double weight, const ViewFlowModel::Gradient& g) {
    double J[5] = {g.turn[0], g.turn[1], g.turn[2], 0, 0};
    if (n_ == 3) return accumulate<3>(residual, weight, J);
    for (std::size_t k = 0; k < 2; ++k)
      J[3 + k] = tangents_[k][0] * g.direction[0] + tangents_[k][1] * g.direction[1] +
                 tangents_[k][2] * g.direction[2];
    accumulate<5>(residual, weight, J);
  }

  /// Solves with slight damping. False if the equations are singular.
  bool solve(double (&step)[5]) {
    by_rotation_vector();
    for (int p = 0; p < n_; ++p) A_[p * n_ + p] = A_[p * n_ + p] * 1.001 + 1e-6;
    if (!solve_positive_definite(A_, b_, n_)) return false;
    for (int k = 0; k < n_; ++k) step[k] = b_[k];
    return true;
  }

 private:
  template <int N>
  void accumulate(double residual, double weight, const double (&J)[5]) {
    for (int p = 0; p < N; ++p) {
      const double weighted = weight * J[p];
      b_[p] -= weighted * residual;
      for (int q = 0; q <= p; ++q) A_[p * N + q] += weighted * J[q];
    }
  }

  /// Converts derivatives by rotation to derivatives by the rotation vector: T^t A T, T^t b.
  void by_rotation_vector() {
    for (int p = 0; p < n_; ++p)
      for (int q = p + 1; q < n_; ++q) A_[p * n_ + q] = A_[q * n_ + p];
    for (int p = 0; p < n_; ++p) turn(&A_[p * n_], 1);
    for (int q = 0; q < n_; ++q) turn(&A_[q], n_);
    turn(b_, 1);
  }
  void turn(double* first, int stride) const {
    const double v[3] = {first[0], first[stride], first[2 * stride]};
    for (std::size_t k = 0; k < 3; ++k)
      first[static_cast<int>(k) * stride] = turns_[k][0] * v[0] + turns_[k][1] * v[1] + turns_[k][2] * v[2];
  }

  int n_;
  std::array<std::array<double, 3>, 3> turns_;
  std::array<std::array<double, 3>, 2> tangents_{};
  double A_[25] = {}, b_[5] = {};
};

}  // namespace detail

DYNFILTER_INLINE ViewMotion refine_view_motion(ViewMotion motion, const std::vector<ViewPair>& pairs,
                                               const std::vector<int>& which,
                                               const std::vector<double>& weights, double sigma_px,
                                               int iterations) {
  const double inverse2 = sigma_px > 0 ? 1 / (sigma_px * sigma_px) : 0;
  const auto weight_of = [&](std::size_t i, double squared) {
    return (weights.empty() ? 1 : weights[i]) / (1 + squared * inverse2);
  };
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const ViewFlowModel model(motion);
    detail::ViewMotionEquations equations(motion);
    for (const int index : which) {
      const auto i = static_cast<std::size_t>(index);
      if (motion.has_baseline()) {
        double r = 0;
        ViewFlowModel::Gradient g;
        if (model.across(pairs[i], r, g)) equations.add(r, weight_of(i, r * r), g);
      } else {
        double r[2];
        ViewFlowModel::Gradient g[2];
        if (!model.rest(pairs[i], r, g)) continue;
        const double weight = weight_of(i, r[0] * r[0] + r[1] * r[1]);
        for (int k = 0; k < 2; ++k) equations.add(r[k], weight, g[k]);
      }
    }
    double step[5] = {}, largest = 0;
    if (!equations.solve(step)) break;
    for (const double x : step) largest = std::max(largest, std::abs(x));
    if (!(largest < 1e6)) break;
    const double shorten = largest > 0.5 ? 0.5 / largest : 1;  // at most half a radian
    for (double& x : step) x *= shorten;
    motion = detail::stepped(motion, step);
    if (largest < 1e-6) break;
  }
  return motion;
}

}  // namespace dynfilter
