// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/motion/view_motion.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>

namespace dynfilter {

DYNFILTER_INLINE ViewFlowModel::ViewFlowModel(const ViewMotion& motion)
    : c_(motion.direction), f_(motion.focal_px), baseline_(motion.has_baseline()) {
  rotation_matrix(motion.rotation_rad);
}

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
