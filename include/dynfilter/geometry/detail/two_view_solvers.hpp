// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/geometry/epipolar_distance.hpp>
#include <dynfilter/geometry/small_matrix.hpp>
#include <utility>

namespace dynfilter::detail {

/// Real roots of a x^3 + b x^2 + c x + d, refined by one Newton step. The leading coefficient may be zero.
inline int real_cubic_roots(double a, double b, double c, double d, double (&roots)[3]) {
  const double size = std::max({std::abs(a), std::abs(b), std::abs(c), std::abs(d)});
  if (!(size > 0)) return 0;
  int n = 0;
  if (std::abs(a) > 1e-12 * size) {
    b /= a, c /= a, d /= a;
    const double q = (b * b - 3 * c) / 9, r = (b * (2 * b * b - 9 * c) + 27 * d) / 54;
    if (r * r < q * q * q) {
      const double theta = portable::acos(r / (q * std::sqrt(q))) / 3, k = -2 * std::sqrt(q);
      for (int i = -1; i <= 1; ++i) roots[n++] = k * portable::cos(theta + i * 2.0943951023931953) - b / 3;
    } else {
      const double s = -std::copysign(portable::cbrt(std::abs(r) + std::sqrt(r * r - q * q * q)), r);
      roots[n++] = s + (s != 0 ? q / s : 0) - b / 3;
    }
    a = 1;
  } else if (std::abs(b) > 1e-12 * size) {
    const double disc = c * c - 4 * b * d;
    if (disc < 0) return 0;
    const double t = -0.5 * (c + std::copysign(std::sqrt(disc), c));
    roots[n++] = t / b;
    if (t != 0) roots[n++] = d / t;
  } else if (std::abs(c) > 1e-12 * size) {
    roots[n++] = -d / c;
  }
  for (int i = 0; i < n; ++i) {
    const double x = roots[i], slope = (3 * a * x + 2 * b) * x + c;
    if (slope != 0) roots[i] = x - (((a * x + b) * x + c) * x + d) / slope;
  }
  return n;
}

/// Two vectors that span the null space of a 7x9 matrix, by elimination with full pivoting. Pure translations
/// make any fixed choice of pivots vanish. False if the rank is below 7. Destroys A. Takes 0.64 (-O2) and
/// 0.79 (-O3) of the time of Eigen's FullPivLU.
inline bool null_space_7x9(double (&A)[7][9], Eigen::Matrix3d& N1, Eigen::Matrix3d& N2) {
  int column[9] = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  for (int k = 0; k < 7; ++k) {
    int row = k, col = k;
    double best = -1;
    for (int r = k; r < 7; ++r) {
      for (int c = k; c < 9; ++c) {
        const double v = std::abs(A[r][c]);
        if (v > best) best = v, row = r, col = c;
      }
    }
    if (!(best > 1e-9)) return false;
    if (row != k) std::swap(A[row], A[k]);
    if (col != k) {
      for (auto& r : A) std::swap(r[col], r[k]);
      std::swap(column[col], column[k]);
    }
    const double inv = 1 / A[k][k];
    for (int r = k + 1; r < 7; ++r) {
      const double factor = A[r][k] * inv;
      for (int c = k + 1; c < 9; ++c) A[r][c] -= factor * A[k][c];
    }
  }
  double n[2][9];
  for (int s = 0; s < 2; ++s) {
    double v[9] = {};
    v[7 + s] = 1;
    for (int k = 6; k >= 0; --k) {
      double sum = A[k][7 + s];
      for (int c = k + 1; c < 7; ++c) sum += A[k][c] * v[c];
      v[k] = -sum / A[k][k];
    }
    for (int c = 0; c < 9; ++c) n[s][column[c]] = v[c];
  }
  for (int c = 0; c < 9; ++c) N1(c / 3, c % 3) = n[0][c], N2(c / 3, c % 3) = n[1][c];
  N1.normalize();
  N2.normalize();
  return true;
}

/// The one to three fundamental matrices through seven matches (Hartley and Zisserman, section 11.1.2).
/// Solves det(N1 + x N2) = 0 on the null space, and includes N2 if it is singular. Returns their number.
inline int solve_seven(const Eigen::Vector2d (&p1)[7], const Eigen::Vector2d (&p2)[7],
                       Eigen::Matrix3d (&F)[4]) {
  double A[7][9];
  for (int i = 0; i < 7; ++i) {
    const double x = p1[i].x(), y = p1[i].y(), u = p2[i].x(), v = p2[i].y();
    const double row[9] = {u * x, u * y, u, v * x, v * y, v, x, y, 1};
    std::copy(row, row + 9, A[i]);
  }
  Eigen::Matrix3d a, b;
  if (!null_space_7x9(A, a, b)) return 0;
  // det(a + x b) = det a + x tr(adj(a) b) + x^2 tr(adj(b) a) + x^3 det b
  auto mixed = [](const Eigen::Matrix3d& m, const Eigen::Matrix3d& n) {
    const Eigen::Vector3d x = column(m, 0), y = column(m, 1), z = column(m, 2);
    return y.cross(z).dot(column(n, 0)) + z.cross(x).dot(column(n, 1)) + x.cross(y).dot(column(n, 2));
  };
  const auto determinant = [](const Eigen::Matrix3d& m) {
    return column(m, 0).dot(column(m, 1).cross(column(m, 2)));
  };
  const double d3 = determinant(b), d0 = determinant(a);
  double roots[3];
  const int n = real_cubic_roots(d3, mixed(b, a), mixed(a, b), d0, roots);
  int count = 0;
  for (int i = 0; i < n; ++i, ++count) {
    for (int k = 0; k < 9; ++k) F[count](k) = a(k) + roots[i] * b(k);
    F[count].normalize();
  }
  if (std::abs(d3) < 1e-12) F[count++] = b;
  return count;
}

/// Oriented epipolar constraint (Chum, Werner and Matas, ICPR 2004).
/// The points of a sample must be in front of both cameras, so (e' x x'_i) . (F x_i) has one sign.
inline bool oriented(const Eigen::Matrix3d& F, const Eigen::Vector2d (&p1)[7],
                     const Eigen::Vector2d (&p2)[7]) {
  const Eigen::Vector3d a = column(F, 0), b = column(F, 1), c = column(F, 2);
  Eigen::Vector3d e = a.cross(b), e2 = b.cross(c), e3 = c.cross(a);
  if (e2.squaredNorm() > e.squaredNorm()) e = e2;
  if (e3.squaredNorm() > e.squaredNorm()) e = e3;
  double first = 0;
  for (int i = 0; i < 7; ++i) {
    const Eigen::Vector3d l = F * lifted(p1[i]), m = e.cross(lifted(p2[i]));
    const double sign = l.dot(m);
    if (i == 0) first = sign;
    if (sign * first < 0) return false;
  }
  return true;
}

/// The homography through four matches by way of the projective basis (Heckbert 1989).
/// False if three of them are nearly collinear or a triangle changes orientation.
/// Takes 0.23 (-O2) and 0.14 (-O3) of the time of eight equations by Eigen's PartialPivLU.
inline bool solve_four(const Eigen::Vector2d (&p1)[4], const Eigen::Vector2d (&p2)[4], Eigen::Matrix3d& H) {
  auto basis = [](const Eigen::Vector2d(&p)[4], Eigen::Matrix3d& B) {
    B = columns(lifted(p[0]), lifted(p[1]), lifted(p[2]));
    const double det = B.determinant();
    if (!(std::abs(det) > 1e-4)) return false;
    const Eigen::Matrix3d B_inv = B.inverse();
    const Eigen::Vector3d weight = B_inv * lifted(p[3]);
    for (int k = 0; k < 3; ++k) {
      if (!(std::abs(weight(k)) > 1e-3)) return false;
      for (int r = 0; r < 3; ++r) B(r, k) *= weight(k);
    }
    return true;
  };
  Eigen::Matrix3d A, B;
  if (!basis(p1, A) || !basis(p2, B)) return false;
  H = times(B, A.inverse());
  if (!(H.determinant() * H(2, 2) > 0)) return false;
  H /= H(2, 2);
  return all_finite(H.data(), 9);
}

}  // namespace dynfilter::detail
