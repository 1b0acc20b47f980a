// SPDX-License-Identifier: MIT
#pragma once

#include <type_traits>

/// A function marked DYNFILTER_AVX2 may use AVX2 even if the compiler targets older processors.
/// Call it only where cpu_has_avx2() is true.
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
#define DYNFILTER_X86 1
#define DYNFILTER_AVX2 __attribute__((target("avx2")))
#endif

/// Forces inlining, so the function is compiled for the instruction set of its caller.
/// One source then serves the plain and the AVX2 version.
#if defined(__GNUC__) || defined(__clang__)
#define DYNFILTER_AS_CALLER __attribute__((always_inline))
#else
#define DYNFILTER_AS_CALLER
#endif

namespace dynfilter::detail {

#if defined(DYNFILTER_X86)
inline bool cpu_has_avx2() {
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
}

template <class F>
DYNFILTER_AVX2 void call_for_avx2(const F& f) {
  f(std::integral_constant<int, 8>());
}
#endif

/// Calls f(std::integral_constant<int, lanes>()) with the number of 32-bit lanes:
/// 8, compiled for AVX2, if the processor supports it, else 4.
/// Mark the lambda `f` and all that it calls with DYNFILTER_AS_CALLER.
template <class F>
void call_widest(const F& f) {
#if defined(DYNFILTER_X86)
  if (cpu_has_avx2()) return call_for_avx2(f);
#endif
  f(std::integral_constant<int, 4>());
}

}  // namespace dynfilter::detail
