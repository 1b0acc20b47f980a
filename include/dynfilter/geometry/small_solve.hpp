// SPDX-License-Identifier: MIT
#pragma once

namespace dynfilter::detail {

/// Solves A x = b by L D L^T for a symmetric positive definite A (n x n).
/// Works in place: b becomes x, and A is overwritten. The storage order does not matter.
/// False if a pivot is not positive relative to the largest diagonal entry.
/// Plain loops compile fast. Eigen's fixed-size LDLT costs seconds per size and file.
bool solve_positive_definite(double* A, double* b, int n, double min_pivot_share = 1e-14);

/// Inverse of a symmetric positive definite A (n x n, n <= 9).
/// False under the condition of solve_positive_definite().
bool invert_positive_definite(const double* A, double* inverse, int n);

}  // namespace dynfilter::detail

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/geometry/detail/small_solve-inl.hpp>
#endif
