// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/portable_math.hpp>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/inline.hpp>
#include <limits>

namespace dynfilter::portable {

namespace detail {

// Constants in parts. A product of kLn2High or a kQuarterTurn with a small whole number is exact.
inline constexpr double kLn2High = 0x1.62e42fef00000p-1, kLn2Low = 0x1.473de6af278edp-34;
inline constexpr double kLog2OfE = 0x1.71547652b82fep+0;
inline constexpr double kQuarterTurn[3] = {0x1.921fb54400000p+0, 0x1.0b4611a600000p-34,
                                           0x1.3198a2e037073p-69};
inline constexpr double kQuarterTurnsPerRad = 0x1.45f306dc9c883p-1;
inline constexpr double kHalfPi = 0x1.921fb54442d18p+0, kHalfPiRest = 0x1.1a62633145c07p-54;
inline constexpr double kRootHalf = 0.70710678118654752;
inline constexpr double kTwoPi = 0x1.921fb54442d18p+2;
/// atan(k / 4), in two parts.
inline constexpr double kAtan[5] = {0, 0x1.f5b75f92c80ddp-3, 0x1.dac670561bb4fp-2, 0x1.4978fa3269ee1p-1,
                                    0x1.921fb54442d18p-1};
inline constexpr double kAtanRest[5] = {0, 0x1.8ab6e3cf7afbdp-57, 0x1.a2b7f222f65e2p-56,
                                        0x1.2419a87f2a458p-56, 0x1.1a62633145c07p-55};

/// c[0] + c[1] z + c[2] z^2 + ...: even and odd powers apart, because each product waits for the last.
template <std::size_t kTerms>
double series(const double (&c)[kTerms], double z) {
  static_assert(kTerms % 2 == 0);
  const double z2 = z * z;
  double even = c[kTerms - 2], odd = c[kTerms - 1];
#if defined(__GNUC__)
#pragma GCC unroll 8
#endif
  for (std::size_t k = kTerms - 2; k > 0; k -= 2) even = c[k - 2] + z2 * even, odd = c[k - 1] + z2 * odd;
  return even + z * odd;
}

// Taylor's series behind their first terms.
/// 2/n! for n >= 2.
inline constexpr double kExp[14] = {1,
                                    1 / 3.0,
                                    1 / 12.0,
                                    1 / 60.0,
                                    1 / 360.0,
                                    1 / 2520.0,
                                    1 / 20160.0,
                                    1 / 181440.0,
                                    1 / 1814400.0,
                                    1 / 19958400.0,
                                    1 / 239500800.0,
                                    1 / 3113510400.0,
                                    1 / 43589145600.0,
                                    1 / 653837184000.0};
/// 2/n for odd n >= 3: of 2 atanh.
inline constexpr double kLog[12] = {2 / 3.0,  2 / 5.0,  2 / 7.0,  2 / 9.0,  2 / 11.0, 2 / 13.0,
                                    2 / 15.0, 2 / 17.0, 2 / 19.0, 2 / 21.0, 2 / 23.0, 2 / 25.0};
/// 1/n! with the signs of sin from x^3, and of cos from x^4.
inline constexpr double kSin[8] = {-1 / 6.0,        1 / 120.0,        -1 / 5040.0,       1 / 362880.0,
                                   -1 / 39916800.0, 1 / 6227020800.0, -1 / 1307674368e3, 1 / 355687428096e3};
inline constexpr double kCos[8] = {1 / 24.0,          -1 / 720.0,          1 / 40320.0,
                                   -1 / 3628800.0,    1 / 479001600.0,     -1 / 87178291200.0,
                                   1 / 20922789888e3, -1 / 6402373705728e3};
/// 1/n for odd n >= 3.
inline constexpr double kAtanSeries[10] = {-1 / 3.0, 1 / 5.0,   -1 / 7.0, 1 / 9.0,   -1 / 11.0,
                                           1 / 13.0, -1 / 15.0, 1 / 17.0, -1 / 19.0, 1 / 21.0};

/// x 2^n. std::ldexp would take a third of the time of exp.
inline double scaled(double x, int n) {
  if (std::abs(n) >= 1023) return std::ldexp(x, n);
  const std::uint64_t power_of_two = static_cast<std::uint64_t>(n + 1023) << 52;
  double power = 0;
  std::memcpy(&power, &power_of_two, sizeof power);
  return x * power;
}

/// An angle within an eighth of a turn as a sum of two numbers, and the quarter turns taken off.
struct Reduced {
  double high, low;
  int quarters;
};
inline Reduced reduced(double x) {
  constexpr double kExactUpTo = 1e5;  // quarter turns of 17 bits, times 33 bits
  if (std::abs(x) > kExactUpTo) x = std::fmod(x, kTwoPi);
  const double n = std::floor(x * kQuarterTurnsPerRad + 0.5);
  const double most = x - n * kQuarterTurn[0], next = n * kQuarterTurn[1], high = most - next;
  const double low = ((most - high) - next) - n * kQuarterTurn[2];
  const double sum = high + low;
  return {sum, (high - sum) + low, static_cast<int>(static_cast<long long>(n) & 3)};
}

inline double sin_of(double x, double rest) {
  const double z = x * x;
  return x + (rest * (1 - z / 2) + x * z * series(kSin, z));
}
inline double cos_of(double x, double rest) {
  const double z = x * x, half = z / 2, most = 1 - half;
  return most + (((1 - most) - half) + (z * z * series(kCos, z) - x * rest));
}
inline double turned(const Reduced& r, int quarters) {
  const int q = (r.quarters + quarters) & 3;
  const double value = q % 2 == 0 ? sin_of(r.high, r.low) : cos_of(r.high, r.low);
  return q < 2 ? value : -value;
}

/// For 0 <= t <= 1: atan(c) + atan((t - c) / (1 + t c)) with c of the table, then Taylor's series.
inline double atan_of(double t) {
  const int k = static_cast<int>(std::floor(4 * t + 0.5));
  const double c = 0.25 * k, x = (t - c) / (1 + t * c), z = x * x;
  return kAtan[k] + (x + (kAtanRest[k] + x * z * series(kAtanSeries, z)));
}

}  // namespace detail

DYNFILTER_INLINE double exp(double x) {
  constexpr double kOverflow = 710, kUnderflow = -746;
  if (!(x < kOverflow)) return x > 0 ? std::numeric_limits<double>::infinity() : x;
  if (x < kUnderflow) return 0;
  const double n = std::floor(x * detail::kLog2OfE + 0.5);
  const double most = x - n * detail::kLn2High, low = n * detail::kLn2Low, r = most - low;
  const double value = 1 + (r + (r * r / 2 * detail::series(detail::kExp, r) + ((most - r) - low)));
  return detail::scaled(value, static_cast<int>(n));
}

DYNFILTER_INLINE double log(double x) {
  if (!(x > 0))
    return x == 0 ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(x)) return x;
  int exponent = 0;
  double m = std::frexp(x, &exponent);
  if (m < detail::kRootHalf) m *= 2, --exponent;
  // log(1 + f) = 2 (s + s^3/3 + s^5/5 + ...) with s = f / (2 + f), and 2 s = f - s f.
  const double f = m - 1, s = f / (2 + f), z = s * s, half = f * f / 2;
  const double rest = s * (half + z * detail::series(detail::kLog, z)) + exponent * detail::kLn2Low;
  return exponent * detail::kLn2High - ((half - rest) - f);
}

DYNFILTER_INLINE double log1p(double x) {
  const double y = 1 + x;
  return y == 1 || std::isinf(y) ? x : log(y) * (x / (y - 1));  // Kahan's correction of the rounding of 1 + x
}

DYNFILTER_INLINE double log2(double x) {
  if (!(x > 0) || std::isinf(x)) return log(x);
  int exponent = 0;
  double m = std::frexp(x, &exponent);
  if (m < detail::kRootHalf) m *= 2, --exponent;
  return exponent + log(m) * detail::kLog2OfE;
}

DYNFILTER_INLINE double sin(double x) {
  if (!std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
  return detail::turned(detail::reduced(x), 0);
}

DYNFILTER_INLINE double cos(double x) {
  if (!std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
  return detail::turned(detail::reduced(x), 1);
}

DYNFILTER_INLINE double atan2(double y, double x) {
  const double a = std::abs(y), b = std::abs(x);
  if (std::isnan(a + b)) return a + b;
  double angle = 0;
  if (a > b)
    angle = detail::kHalfPi - (detail::atan_of(b / a) - detail::kHalfPiRest);
  else if (b > 0)
    angle = std::isinf(a) ? detail::kAtan[4] : detail::atan_of(a / b);
  if (std::signbit(x)) angle = 2 * detail::kHalfPi - (angle - 2 * detail::kHalfPiRest);
  return std::copysign(angle, y);
}

DYNFILTER_INLINE double acos(double x) {
  return 2 * atan2(std::sqrt(1 - x), std::sqrt(1 + x));
}

DYNFILTER_INLINE double cbrt(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  int exponent = 0;
  double m = std::frexp(std::abs(x), &exponent);
  while (exponent % 3 != 0) m /= 2, ++exponent;
  double y = 0.4 + 0.6 * m;  // m in [1/8, 1)
  for (int k = 0; k < 5; ++k) y -= (y - m / (y * y)) / 3;
  return std::copysign(std::ldexp(y, exponent / 3), x);
}

DYNFILTER_INLINE double power(double x, double y) {
  if (y == 0) return 1;
  if (x == 0) return y > 0 ? 0 : std::numeric_limits<double>::infinity();
  return exp(y * log(x));
}

DYNFILTER_INLINE double power(double x, int n) {
  double product = 1;
  for (int k = 0; k < n; ++k) product *= x;
  return product;
}

}  // namespace dynfilter::portable
