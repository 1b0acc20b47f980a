// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/cpu.hpp>

namespace dynfilter::detail {

/// Vectors of GCC and Clang for code that compilers do not vectorise: conversions that may trap.
/// Four lanes work on every processor, eight need AVX2.
/// Wide vectors are passed by reference, because by value they change the calling convention.
template <int kLanes>
struct Lanes;
template <>
struct Lanes<4> {
  using Float = float __attribute__((vector_size(16)));
  using Int = std::int32_t __attribute__((vector_size(16)));
  static constexpr int kCount = 4;
};
template <>
struct Lanes<8> {
  using Float = float __attribute__((vector_size(32)));
  using Int = std::int32_t __attribute__((vector_size(32)));
  static constexpr int kCount = 8;
};

template <class Lane, class T>
DYNFILTER_AS_CALLER inline void load_lane(const T* from, Lane& lane) {
  std::memcpy(&lane, from, sizeof lane);
}
template <class Lane, class T>
DYNFILTER_AS_CALLER inline void store_lane(T* to, const Lane& lane) {
  std::memcpy(to, &lane, sizeof lane);
}

/// Truncates towards zero where `inside` has all bits set, else returns 0.
template <class L>
DYNFILTER_AS_CALLER inline void truncate_inside(const typename L::Float& value, const typename L::Int& inside,
                                                typename L::Int& whole) {
  typename L::Float kept;
  load_lane(&value, whole);
  whole &= inside;
  load_lane(&whole, kept);
  whole = __builtin_convertvector(kept, typename L::Int);
}

/// Eight floats with lane-by-lane operations: two vectors of GCC and Clang, on any processor.
/// As fast as Eigen::Array within 4 % (test/benchmark/small_solve_benchmark.cpp), which takes four times as
/// long to compile, because each expression has its own type. The order of sums is the same with every compiler.
struct Pack {
  using Four = Lanes<4>::Float;
  static constexpr int kWidth = 8;

  Four low, high;

  Pack() = default;
  Pack(float value) : low(Four{} + value), high(low) {}  // NOLINT: converts a number to eight copies
  Pack(const Four& l, const Four& h) : low(l), high(h) {}
  static Pack load(const float* from) {
    Pack p;
    std::memcpy(&p.low, from, sizeof p.low);
    std::memcpy(&p.high, from + 4, sizeof p.high);
    return p;
  }

  void store(float* to) const {
    std::memcpy(to, &low, sizeof low);
    std::memcpy(to + 4, &high, sizeof high);
  }

  float operator[](int k) const { return k < 4 ? low[k] : high[k - 4]; }
  void set(int k, float value) {
    if (k < 4)
      low[k] = value;
    else
      high[k - 4] = value;
  }
  float sum() const {
    const Four both = low + high;
    return (both[0] + both[2]) + (both[1] + both[3]);
  }

  Pack& operator+=(const Pack& o) { return low += o.low, high += o.high, *this; }
  Pack& operator*=(const Pack& o) { return low *= o.low, high *= o.high, *this; }
};

inline Pack operator-(const Pack& a) {
  return {-a.low, -a.high};
}
inline Pack operator+(const Pack& a, const Pack& b) {
  return {a.low + b.low, a.high + b.high};
}
inline Pack operator-(const Pack& a, const Pack& b) {
  return {a.low - b.low, a.high - b.high};
}
inline Pack operator*(const Pack& a, const Pack& b) {
  return {a.low * b.low, a.high * b.high};
}
inline Pack operator/(const Pack& a, const Pack& b) {
  return {a.low / b.low, a.high / b.high};
}
/// Returns the second operand where the first is NaN.
inline Pack max(const Pack& a, const Pack& b) {
  return {a.low > b.low ? a.low : b.low, a.high > b.high ? a.high : b.high};
}
inline Pack min(const Pack& a, const Pack& b) {
  return {a.low < b.low ? a.low : b.low, a.high < b.high ? a.high : b.high};
}
/// 1 where a > b, else 0.
inline Pack greater(const Pack& a, const Pack& b) {
  const Pack::Four one = Pack::Four{} + 1.0F, none{};
  return {a.low > b.low ? one : none, a.high > b.high ? one : none};
}
/// 1 where a <= b, else 0; 0 for NaN.
inline Pack not_above(const Pack& a, const Pack& b) {
  const Pack::Four one = Pack::Four{} + 1.0F, none{};
  return {a.low <= b.low ? one : none, a.high <= b.high ? one : none};
}
/// `a` where x > 0, else `b`.
inline Pack where_positive(const Pack& x, const Pack& a, const Pack& b) {
  const Pack::Four none{};
  return {x.low > none ? a.low : b.low, x.high > none ? a.high : b.high};
}
inline Pack sqrt(Pack a) {
  for (int k = 0; k < 4; ++k) a.low[k] = std::sqrt(a.low[k]), a.high[k] = std::sqrt(a.high[k]);
  return a;
}

}  // namespace dynfilter::detail
