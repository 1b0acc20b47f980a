// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>

namespace dynfilter::mapping::detail {

// Vectors of GCC and Clang, for what compilers do not vectorise by themselves: conversions that may trap.
using FloatLane = float __attribute__((vector_size(16)));
using IntLane = std::int32_t __attribute__((vector_size(16)));

template <class Lane, class T>
Lane load_lane(const T* from) {
  Lane lane;
  std::memcpy(&lane, from, sizeof lane);
  return lane;
}

/// Towards zero where `inside` (all bits set), else 0.
inline IntLane truncate_inside(const FloatLane& value, const IntLane& inside) {
  IntLane bits;
  std::memcpy(&bits, &value, sizeof bits);
  bits &= inside;
  return __builtin_convertvector(load_lane<FloatLane>(&bits), IntLane);
}

}  // namespace dynfilter::mapping::detail
