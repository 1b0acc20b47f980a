// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace dynfilter::detail {

// Every kind of Eigen expression compiles 50 to 250 functions in each file that has it. So products, columns
// and solvers are functions, and sums are made of few kinds.

inline Eigen::Matrix3d times(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return a * b;
}
inline Eigen::Matrix3d rows(const std::array<double, 9>& row_major) {
  Eigen::Matrix3d m;
  for (int k = 0; k < 9; ++k) m(k / 3, k % 3) = row_major[static_cast<std::size_t>(k)];
  return m;
}
inline Eigen::Vector3d column(const Eigen::Matrix3d& m, int c) {
  return {m(0, c), m(1, c), m(2, c)};
}
inline Eigen::Matrix3d columns(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  Eigen::Matrix3d m;
  for (int r = 0; r < 3; ++r) m(r, 0) = a(r), m(r, 1) = b(r), m(r, 2) = c(r);
  return m;
}
/// [v]x
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  return rows({0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0});
}

/// Solves A x = b by L D L^T for a symmetric positive definite A (n x n). Works in place: b becomes x, and A
/// is overwritten. The storage order does not matter. False if a pivot is not positive relative to the
/// largest diagonal entry. At -O2 it takes 0.27 (n = 5), 0.33 (6) and 0.42 (8) of the time of Eigen's
/// fixed-size LDLT, at -O3 0.35 to 0.43. The figures are of test/benchmark/small_solve_benchmark.cpp, GCC 12,
/// x86-64. Eigen's takes seconds to compile per size and file.
inline bool solve_positive_definite(double* A, double* b, int n, double min_pivot_share = 1e-14) {
  double largest = 0;
  for (int i = 0; i < n; ++i) largest = std::fmax(largest, A[i * n + i]);
  for (int j = 0; j < n; ++j) {
    double pivot = A[j * n + j];
    for (int k = 0; k < j; ++k) pivot -= A[j * n + k] * A[j * n + k] * A[k * n + k];
    if (!(pivot > min_pivot_share * largest)) return false;
    A[j * n + j] = pivot;
    for (int i = j + 1; i < n; ++i) {
      double sum = A[i * n + j];
      for (int k = 0; k < j; ++k) sum -= A[i * n + k] * A[j * n + k] * A[k * n + k];
      A[i * n + j] = sum / pivot;
    }
  }
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < i; ++k) b[i] -= A[i * n + k] * b[k];
  for (int i = 0; i < n; ++i) b[i] /= A[i * n + i];
  for (int i = n - 1; i >= 0; --i)
    for (int k = i + 1; k < n; ++k) b[i] -= A[k * n + i] * b[k];
  return true;
}

/// Inverse of a symmetric positive definite A (n x n, n <= 9).
/// False under the condition of solve_positive_definite().
inline bool invert_positive_definite(const double* A, double* inverse, int n) {
  for (int c = 0; c < n; ++c) {
    double work[81];
    std::copy(A, A + n * n, work);
    double* column = inverse + c * n;
    std::fill(column, column + n, 0.0);
    column[c] = 1;
    if (!solve_positive_definite(work, column, n)) return false;
  }
  return true;
}

/// Eigen's allFinite() compiles about 150 functions per size.
inline bool all_finite(const double* values, int n) {
  for (int i = 0; i < n; ++i)
    if (!std::isfinite(values[i])) return false;
  return true;
}

}  // namespace dynfilter::detail
