// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/portable_math.hpp>

namespace dynfilter {

/// Camera motion between two views up to scale: five degrees of freedom.
/// An approximate focal length is sufficient while the camera rotates by a few degrees.
struct ViewMotion {
  /// Axis times angle; rotates current rays to the reference view.
  std::array<double, 3> rotation_rad{};
  /// Of the current camera's centre, unit length; 0: no baseline.
  std::array<double, 3> direction{0, 0, 1};
  double focal_px = 1;

  /// False: only the camera turned.
  bool has_baseline() const { return direction != std::array<double, 3>{}; }
};

/// A point in two views, in undistorted pixels relative to the principal point.
struct ViewPair {
  double reference_x = 0, reference_y = 0, x = 0, y = 0;
};

/// Flow of a point in the reference view after the camera's rotation is removed.
struct ViewFlow {
  double across_px = 0;  ///< distance from its epipolar line; without a baseline: flow to the right
  /// Flow along it, positive for static points; without a baseline: flow downwards.
  double along_px = 0;
  /// Length of the camera's step divided by the depth. 0 without a baseline.
  double inverse_depth = 0;
  double line_x = 0, line_y = 1;  ///< direction of the line, of unit length

  /// Length of the flow [px].
  double length_px() const { return std::sqrt(across_px * across_px + along_px * along_px); }
};

namespace detail {

/// Current point after the inverse rotation. T is a number or a pack of them.
template <class T>
struct TurnedPoint {
  static constexpr double kNearest = 0.05;  ///< [focal lengths] rays turned farther are out of view

  T x, y;
  T ahead;  ///< positive if the point is in view

  /// R is the rotation, row by row, and `nearest` is kNearest.
  TurnedPoint(const T* R, const T& f, const T& nearest, const T& from_x, const T& from_y) {
    using std::max;
    const T closest = nearest * f, z = R[6] * from_x + R[7] * from_y + R[8] * f;
    ahead = z - closest;
    const T scale = f / max(z, closest);
    x = scale * (R[0] * from_x + R[1] * from_y + R[2] * f);
    y = scale * (R[3] * from_x + R[4] * from_y + R[5] * f);
  }
};

/// A turned point's flow e and the direction d of its epipolar line for the camera's direction c.
/// Its distance from the line is cross / sqrt(squared).
template <class T>
struct LineTerms {
  T ex, ey, dx, dy, squared, cross;

  LineTerms(const TurnedPoint<T>& q, const T& reference_x, const T& reference_y, const T* c, const T& f)
      : ex(q.x - reference_x),
        ey(q.y - reference_y),
        dx(q.x * c[2] - f * c[0]),
        dy(q.y * c[2] - f * c[1]),
        squared(dx * dx + dy * dy + T(1)),  // + 1 px: lines are undefined near the focus of expansion
        cross(ex * dy - ey * dx) {}
};

}  // namespace detail

/// Splits flow into parts along and across the epipolar line of a motion. q is the current point after the
/// inverse rotation and a the reference point. f is the focal length and c the direction. A static point
/// obeys q - a = mu (q c_z - f c_xy) with mu = step / depth >= 0. This is the finite form of Longuet-Higgins
/// and Prazdny (1980).
class ViewFlowModel {
 public:
  /// Of points that follow this motion.
  explicit ViewFlowModel(const ViewMotion& motion)
      : c_(motion.direction), f_(motion.focal_px), baseline_(motion.has_baseline()) {
    rotation_matrix(motion.rotation_rad);
  }

  ViewFlow operator()(const ViewPair& p) const {
    using Turned = detail::TurnedPoint<double>;
    const Turned q(R_.data(), f_, Turned::kNearest, p.x, p.y);
    if (!(q.ahead > 0)) return {1e3, 0, 0};  // rotated out of view
    const detail::LineTerms<double> line(q, p.reference_x, p.reference_y, c_.data(), f_);
    if (!baseline_) return {line.ex, line.ey, 0};
    const double inverse = 1 / std::sqrt(line.squared);
    const double along = (line.ex * line.dx + line.ey * line.dy) * inverse;
    return {line.cross * inverse, along, along * inverse, line.dx * inverse, line.dy * inverse};
  }

  /// Of the rotation, row by row.
  const std::array<double, 9>& matrix() const { return R_; }

 private:
  void rotation_matrix(const std::array<double, 3>& w);

  std::array<double, 9> R_{};
  std::array<double, 3> c_;
  double f_;
  bool baseline_;
};

inline void ViewFlowModel::rotation_matrix(const std::array<double, 3>& w) {
  const double angle2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2], angle = std::sqrt(angle2);
  const double a = angle > 1e-9 ? portable::sin(angle) / angle : 1,
               b = angle > 1e-9 ? (1 - portable::cos(angle)) / angle2 : 0.5;
  const double x = w[0], y = w[1], z = w[2];
  R_ = {1 - b * (y * y + z * z), -a * z + b * x * y,      a * y + b * x * z,
        a * z + b * x * y,       1 - b * (x * x + z * z), -a * x + b * y * z,
        -a * y + b * x * z,      a * x + b * y * z,       1 - b * (x * x + y * y)};
}

namespace detail {

inline void normalise(std::array<double, 3>& v) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (length > 0)
    for (double& x : v) x /= length;
}

inline std::array<double, 3> cross(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Two directions perpendicular to `c` and to each other.
inline std::array<std::array<double, 3>, 2> tangents(const std::array<double, 3>& c) {
  std::array<double, 3> axis{};
  std::size_t smallest = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (std::abs(c[k]) < std::abs(c[smallest])) smallest = k;
  axis[smallest] = 1;
  std::array<double, 3> u = cross(c, axis);
  normalise(u);
  return {u, cross(c, u)};
}

/// The motion after a small step: three components for the rotation, two for the direction.
inline ViewMotion stepped(const ViewMotion& motion, const double (&step)[5]) {
  ViewMotion out = motion;
  for (std::size_t k = 0; k < 3; ++k) out.rotation_rad[k] += step[k];
  if (!motion.has_baseline()) return out;
  const auto [u, v] = tangents(motion.direction);
  for (std::size_t k = 0; k < 3; ++k) out.direction[k] += step[3] * u[k] + step[4] * v[k];
  normalise(out.direction);
  return out;
}

/// Left Jacobian of SO(3). Column k is the rotation after w caused by a step of component k.
inline std::array<std::array<double, 3>, 3> turns_by_step(const std::array<double, 3>& w) {
  const double angle2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2], angle = std::sqrt(angle2);
  const double a = angle > 1e-4 ? (1 - portable::cos(angle)) / angle2 : 0.5,
               b = angle > 1e-4 ? (angle - portable::sin(angle)) / (angle2 * angle) : 1.0 / 6;
  std::array<std::array<double, 3>, 3> columns;
  for (std::size_t k = 0; k < 3; ++k) {
    std::array<double, 3> e{};
    e[k] = 1;
    const std::array<double, 3> once = cross(w, e), twice = cross(w, once);
    for (std::size_t m = 0; m < 3; ++m) columns[k][m] = e[m] + a * once[m] + b * twice[m];
  }
  return columns;
}

}  // namespace detail

}  // namespace dynfilter
