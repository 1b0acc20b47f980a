// SPDX-License-Identifier: MIT
#pragma once

#include <type_traits>

/// Code for processors newer than the compiler was told of: functions marked DYNFILTER_AVX2 may use AVX2, and
/// are called where cpu_has_avx2().
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
#define DYNFILTER_X86 1
#define DYNFILTER_AVX2 __attribute__((target("avx2")))
#endif

/// Inlined, and so compiled for what the caller is compiled for: one source, a plain form and a wide one.
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

/// Calls f(std::integral_constant<int, lanes>()): compiled for AVX2 with 8 lanes of 32 bits where the
/// processor has it, else with 4. `f` is a lambda that is DYNFILTER_AS_CALLER, and so is what it calls.
template <class F>
void call_widest(const F& f) {
#if defined(DYNFILTER_X86)
  if (cpu_has_avx2()) return call_for_avx2(f);
#endif
  f(std::integral_constant<int, 4>());
}

}  // namespace dynfilter::detail
