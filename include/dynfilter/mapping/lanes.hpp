// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <dynfilter/core/cpu.hpp>

namespace dynfilter::mapping::detail {

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

}  // namespace dynfilter::mapping::detail
