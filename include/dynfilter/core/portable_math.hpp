// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

/// Elementary functions with the same bits on every processor and with every C library.
/// glibc selects versions of exp, log, pow, sin, cos, atan2 and acos by the processor, and versions of glibc
/// differ in hypot. Their last bits differ, and a seeded search turns these into other verdicts.
/// These functions use only operations that IEEE 754 defines: + - * /, sqrt, and scaling by powers of two.
/// Condition: the compiler fuses no products and sums, which it does under -mfma and -march=native.
/// Cost: 2 to 25 ns. Errors: below 1 ulp. log1p, log2, acos, atan2: below 3. power(): 2 + 2 |y log x|.
namespace dynfilter::portable {

double exp(double x);    ///< e to the power of x
double log(double x);    ///< natural logarithm
double log1p(double x);  ///< log(1 + x), exact for small x
double log2(double x);   ///< exact for powers of two

/// Finite arguments. Beyond 1e5 the absolute error grows with the argument.
double sin(double x);
double cos(double x);  ///< of an angle [rad], as sin()

double acos(double x);             ///< angle in [0, pi] [rad]
double atan2(double y, double x);  ///< angle in [-pi, pi] [rad]

double cbrt(double x);  ///< cube root
/// For x >= 0.
double power(double x, double y);
/// By multiplication, for n >= 0.
double power(double x, int n);

/// Of a probability [nats].
inline double log_odds(double p) {
  return log(p / (1 - p));
}

// floats are computed in double and rounded once.
/// Rounded once.
inline float exp(float x) {
  return static_cast<float>(exp(static_cast<double>(x)));
}
/// Rounded once.
inline float log(float x) {
  return static_cast<float>(log(static_cast<double>(x)));
}

/// Overflows above 1e154, which no length in pixels or metres reaches.
inline double hypot(double x, double y) {
  return std::sqrt(x * x + y * y);
}
/// Rounded once.
inline float hypot(float x, float y) {
  return static_cast<float>(hypot(static_cast<double>(x), static_cast<double>(y)));
}

}  // namespace dynfilter::portable

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/core/detail/portable_math-inl.hpp>
#endif
