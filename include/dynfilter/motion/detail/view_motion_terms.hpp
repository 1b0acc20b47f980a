// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/motion/view_motion.hpp>

namespace dynfilter::detail {

/// Residuals of ViewFlowModel and their derivatives. The variables are a rotation of the rays about x, y and
/// z, and a step of the direction along its two tangents. The rotation is applied after the current one.
/// `T` is a number or a Pack of them.
template <class T>
class ViewMotionTerms {
 public:
  explicit ViewMotionTerms(const ViewMotion& motion) : f_(number(motion.focal_px)) {
    const ViewFlowModel model(motion);
    const std::array<double, 9>& R = model.matrix();
    for (std::size_t k = 0; k < R.size(); ++k) R_[k] = number(R[k]);
    const auto directions = tangents(motion.direction);
    for (std::size_t k = 0; k < 3; ++k) {
      c_[k] = number(motion.direction[k]);
      for (std::size_t t = 0; t < 2; ++t) tangents_[t][k] = number(directions[t][k]);
    }
  }

  /// The distance from the epipolar line is cross / sqrt(squared). Its derivatives are by / sqrt(squared).
  /// So the normal equations need no square root.
  struct Across {
    T cross, squared, by[5];
  };
  /// `ahead` is positive if the point is in view.
  Across across(const T& reference_x, const T& reference_y, const T& x, const T& y, T& ahead) const {
    const Ray q = turned(x, y, ahead);
    const LineTerms<T> line(q, reference_x, reference_y, c_, f_);
    Across out;
    out.squared = line.squared;
    out.cross = line.cross;
    const T share = out.cross / out.squared;
    const T by_dx = -(line.ey + share * line.dx), by_dy = line.ex - share * line.dy;
    by_turn(q, line.dy + c_[2] * by_dx, c_[2] * by_dy - line.dx, out.by);
    for (std::size_t t = 0; t < 2; ++t)
      out.by[3 + t] = by_dx * (q.x * tangents_[t][2] - f_ * tangents_[t][0]) +
                      by_dy * (q.y * tangents_[t][2] - f_ * tangents_[t][1]);
    return out;
  }

  /// Without a baseline: the flow to the right and downwards.
  struct Rest {
    T px[2], by[2][3];
  };
  Rest rest(const T& reference_x, const T& reference_y, const T& x, const T& y, T& ahead) const {
    const Ray q = turned(x, y, ahead);
    Rest out;
    out.px[0] = q.x - reference_x;
    out.px[1] = q.y - reference_y;
    by_turn(q, T(1), T(0), out.by[0]);
    by_turn(q, T(0), T(1), out.by[1]);
    return out;
  }

 private:
  using Ray = TurnedPoint<T>;
  static T number(double value);

  Ray turned(const T& x, const T& y, T& ahead) const {
    const Ray q(R_, f_, number(Ray::kNearest), x, y);
    ahead = q.ahead;
    return q;
  }

  /// From derivatives with respect to q. A rotation by v moves the ray r = (q_x, q_y, f) by v x r.
  void by_turn(const Ray& q, const T& by_qx, const T& by_qy, T* turn) const {
    const T radial = (by_qx * q.x + by_qy * q.y) / f_;
    turn[0] = -(q.y * radial + f_ * by_qy);
    turn[1] = f_ * by_qx + q.x * radial;
    turn[2] = q.x * by_qy - q.y * by_qx;
  }

  T R_[9], c_[3], tangents_[2][3], f_;
};

template <>
inline double ViewMotionTerms<double>::number(double value) {
  return value;
}
template <>
inline Pack ViewMotionTerms<Pack>::number(double value) {
  return {static_cast<float>(value)};
}

/// Normal equations of a motion's five degrees of freedom; three without a baseline.
/// Rows are filled eight points at a time.
class ViewMotionEquations {
 public:
  explicit ViewMotionEquations(const ViewMotion& motion);

  /// Adds residuals with derivatives `by`. `weight` is of the squares.
  template <int N>
  void add(const Pack& residual, const Pack& weight, const Pack* by) {
    std::size_t at = 0;
    for (int p = 0; p < N; ++p) {
      const Pack weighted = weight * by[p];
      rhs_[p] += -(weighted * residual);
      for (int q = 0; q <= p; ++q, ++at) products_[at] += weighted * by[q];
    }
  }

  /// Solves with slight damping. False if the equations are singular.
  bool solve(double (&step)[5]);

  /// By how much the step changed the sum of weighted squares, to first order.
  double change() const { return change_; }

 private:
  /// Converts derivatives by rotation to derivatives by the rotation vector: T^t A T, T^t b.
  void by_rotation_vector();
  void turn(double* first, int stride) const;

  int n_;
  std::array<std::array<double, 3>, 3> turns_;
  Pack products_[15], rhs_[5];
  double A_[25] = {}, b_[5] = {}, change_ = 0;
};

}  // namespace dynfilter::detail
