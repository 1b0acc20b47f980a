// SPDX-License-Identifier: MIT
#pragma once

/// Code for processors newer than the compiler was told of: functions marked DYNFILTER_AVX2 may use AVX2, and
/// are called where cpu_has_avx2().
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
#define DYNFILTER_X86 1
#define DYNFILTER_AVX2 __attribute__((target("avx2")))
#endif

namespace dynfilter::detail {

#if defined(DYNFILTER_X86)
inline bool cpu_has_avx2() {
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
}
#endif

}  // namespace dynfilter::detail
