// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

namespace dynfilter::detail {

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

}  // namespace dynfilter::detail
