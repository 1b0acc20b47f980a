// SPDX-License-Identifier: MIT
#pragma once

namespace dynfilter::detail {

/// Solves A x = b by L D L^T for a symmetric positive definite A (n x n).
/// Works in place: b becomes x, and A is overwritten. The storage order does not matter.
/// False if a pivot is not positive relative to the largest diagonal entry.
/// Takes 0.27 (n = 5), 0.33 (6) and 0.42 (8) of the time of Eigen's fixed-size LDLT at -O2, and 0.35 to 0.43
/// at -O3 (test/benchmark/small_solve_benchmark.cpp; GCC 12, x86-64). Eigen's takes seconds to compile per size and file.
bool solve_positive_definite(double* A, double* b, int n, double min_pivot_share = 1e-14);

/// Inverse of a symmetric positive definite A (n x n, n <= 9).
/// False under the condition of solve_positive_definite().
bool invert_positive_definite(const double* A, double* inverse, int n);

}  // namespace dynfilter::detail

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/geometry/detail/small_solve-inl.hpp>
#endif
