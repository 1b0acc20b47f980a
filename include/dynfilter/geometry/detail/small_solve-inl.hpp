// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/small_solve.hpp>

#include <algorithm>
#include <dynfilter/core/inline.hpp>

namespace dynfilter::detail {

DYNFILTER_INLINE bool solve_positive_definite(double* A, double* b, int n, double min_pivot_share) {
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

DYNFILTER_INLINE bool invert_positive_definite(const double* A, double* inverse, int n) {
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
