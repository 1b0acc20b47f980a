// SPDX-License-Identifier: MIT
// Errors against long double, and the bits themselves: every compiler, C library and processor must produce
// them.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/random.hpp>
#include <limits>
#include <string>

#include "doctest/doctest.h"
#include "support/digest.hpp"

namespace portable_math_test {

using namespace dynfilter;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kArguments = 20000;

/// Of the spacing of doubles at `exact`.
double ulps(double value, long double exact) {
  const double nearest = std::abs(static_cast<double>(exact));
  const double spacing = std::nextafter(nearest, kInf) - nearest;
  return static_cast<double>(std::abs(static_cast<long double>(value) - exact)) / spacing;
}

enum class Spread { Even, PowersOfTen };

template <class Function, class Exact>
double worst_ulps(double low, double high, Spread spread, Function function, Exact exact) {
  Random random(3);
  double worst = 0;
  for (int k = 0; k < kArguments; ++k) {
    double x = random.uniform(low, high);
    if (spread == Spread::PowersOfTen) x = std::pow(10.0, x);
    worst = std::max(worst, ulps(function(x), exact(static_cast<long double>(x))));
  }
  return worst;
}

template <class Function>
std::string bits_of(double low, double high, Function function) {
  Random random(4);
  digest::Digest digest;
  for (int k = 0; k < kArguments; ++k) {
    const double value = function(random.uniform(low, high));
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    digest.add(bits);
  }
  return digest.text();
}

}  // namespace

TEST_CASE("errors are as stated") {
  using L = long double;
  constexpr Spread even = Spread::Even, tens = Spread::PowersOfTen;
  const auto exp = [](double x) { return portable::exp(x); };
  const auto log = [](double x) { return portable::log(x); };
  const auto sin = [](double x) { return portable::sin(x); };
  const auto cos = [](double x) { return portable::cos(x); };
  CHECK(worst_ulps(-700, 700, even, exp, [](L x) { return std::exp(x); }) < 1);
  CHECK(worst_ulps(-2, 2, even, exp, [](L x) { return std::exp(x); }) < 1);
  CHECK(worst_ulps(-300, 300, tens, log, [](L x) { return std::log(x); }) < 1);
  CHECK(worst_ulps(0.5, 2, even, log, [](L x) { return std::log(x); }) < 1);
  CHECK(worst_ulps(-7, 7, even, sin, [](L x) { return std::sin(x); }) < 1);
  CHECK(worst_ulps(-1e5, 1e5, even, sin, [](L x) { return std::sin(x); }) < 1);
  CHECK(worst_ulps(-20, 0, tens, sin, [](L x) { return std::sin(x); }) < 1);
  CHECK(worst_ulps(-7, 7, even, cos, [](L x) { return std::cos(x); }) < 1);
  CHECK(worst_ulps(-300, 300, tens, portable::cbrt, [](L x) { return std::cbrt(x); }) < 1);
  CHECK(worst_ulps(-15, 3, tens, portable::log1p, [](L x) { return std::log1p(x); }) < 3);
  CHECK(worst_ulps(0.1, 3, even, portable::log2, [](L x) { return std::log2(x); }) < 3);
  CHECK(worst_ulps(-1, 1, even, portable::acos, [](L x) { return std::acos(x); }) < 3);
  for (const double x : {1.0, -1.0, 1e-9, 1e9})
    CHECK(worst_ulps(
              -10, 10, even, [=](double y) { return portable::atan2(y, x); },
              [=](L y) { return std::atan2(y, static_cast<L>(x)); }) < 3);
  const double at_most = 2 + 2 * 3.5 * std::log(10.0);
  CHECK(worst_ulps(
            -1, 1, tens, [](double x) { return portable::power(x, -3.5); },
            [](L x) { return std::pow(x, -3.5L); }) < at_most);
}

TEST_CASE("special arguments are those of the standard functions") {
  CHECK(portable::exp(0.0) == 1);
  CHECK(portable::exp(-kInf) == 0);
  CHECK(portable::exp(kInf) == kInf);
  for (const double x :
       {709.0, 709.7, -707.9, -708.5, -720.0, -745.0})  // the largest and smallest powers of 2
    CHECK(std::abs(portable::exp(x) - std::exp(x)) <=
          std::max(std::numeric_limits<double>::denorm_min(), 4e-16 * std::exp(x)));
  CHECK(portable::exp(1e300) == kInf);
  CHECK(portable::exp(-1e300) == 0);
  CHECK(portable::log(1.0) == 0);
  CHECK(portable::log(0.0) == -kInf);
  CHECK(portable::log(kInf) == kInf);
  CHECK(portable::log1p(0) == 0);
  CHECK(portable::log1p(-1) == -kInf);
  CHECK(portable::log1p(kInf) == kInf);
  for (int e = -1000; e <= 1000; e += 50) CHECK(portable::log2(std::ldexp(1.0, e)) == e);
  CHECK(portable::cos(0) == 1);
  CHECK(portable::acos(1) == 0);
  CHECK(portable::acos(-1) == std::acos(-1.0));
  for (const double y : {0.0, 1.0, -1.0, 3.0, -0.0})
    for (const double x : {0.0, 1.0, -1.0, 3.0, -0.0})
      CHECK(portable::atan2(y, x) == doctest::Approx(std::atan2(y, x)).epsilon(1e-15));
  CHECK(portable::cbrt(0) == 0);
  CHECK(portable::cbrt(-27) == -3);
  CHECK(portable::power(0.0, 2.5) == 0);
  CHECK(portable::power(0.0, 0.0) == 1);
  CHECK(portable::power(3.0, 4) == 81);
  CHECK(portable::power(0.0, 0) == 1);
  CHECK(portable::hypot(3.0, -4.0) == 5);
  for (const double value :
       {portable::exp(kNan), portable::log(kNan), portable::log(-1.0), portable::sin(kInf),
        portable::cos(kNan), portable::acos(1.1), portable::atan2(kNan, 1), portable::log1p(-2),
        portable::cbrt(kNan), portable::power(-1.0, 0.5), portable::hypot(kNan, 1.0)})
    CHECK(std::isnan(value));
}

TEST_CASE("the bits on record: the same with every compiler, C library and processor") {
  CHECK(bits_of(-700, 700, [](double x) { return portable::exp(x); }) == "523fa6b78060f30d");
  CHECK(bits_of(0, 100, [](double x) { return portable::log(x); }) == "8dc808247bc9e47d");
  CHECK(bits_of(-10, 10, [](double x) { return portable::sin(x) + portable::cos(2 * x); }) ==
        "ccd8dd4f9ed286ba");
  CHECK(bits_of(-1, 1, [](double x) { return portable::acos(x) + portable::cbrt(x); }) == "1dd7cc10161c8ae7");
}

TEST_CASE("a rotation about an axis, and back") {
  Random random(9);
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d axis =
        Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian()).normalized();
    const double angle_rad = k < 100 ? random.uniform(0, 3.14) : std::pow(10.0, random.uniform(-9, 0));
    const Eigen::Matrix3d R = rotation_about(axis, angle_rad);
    CHECK((R - Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix()).norm() < 1e-15);
    CHECK((rotation_vector(R) - angle_rad * axis).norm() < 1e-12);
  }
  CHECK(rotation_vector(Eigen::Matrix3d::Identity()) == Eigen::Vector3d::Zero());
}

}  // namespace portable_math_test
