// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <string_view>
#include <type_traits>

/// A function marked DYNFILTER_AVX2 may use AVX2 even if the compiler targets older processors.
/// Call it only where uses_avx2() is true.
/// With DYNFILTER_WITHOUT_AVX2, which all files of a program must share, there are no such functions.
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__)) && !defined(DYNFILTER_WITHOUT_AVX2)
#define DYNFILTER_X86 1
#define DYNFILTER_AVX2 __attribute__((target("avx2")))
#else
#define DYNFILTER_AVX2
#endif

/// Forces inlining, so the function is compiled for the instruction set of its caller.
/// One source then serves the plain and the AVX2 version.
#if defined(__GNUC__) || defined(__clang__)
#define DYNFILTER_AS_CALLER __attribute__((always_inline))
#else
#define DYNFILTER_AS_CALLER
#endif

namespace dynfilter {

/// What the environment variable DYNFILTER_SIMD asks for.
enum class SimdChoice {
  Auto,      ///< "auto" or not set: AVX2 if the processor has it
  Baseline,  ///< "baseline": only what the compiler targets
  Unknown    ///< anything else: treated as Baseline, and a pipeline refuses it
};

/// Null is Auto. Never throws.
inline SimdChoice simd_choice_of(const char* text) {
  if (text == nullptr || std::string_view(text) == "auto") return SimdChoice::Auto;
  return std::string_view(text) == "baseline" ? SimdChoice::Baseline : SimdChoice::Unknown;
}

/// Read once, at the first use.
inline SimdChoice simd_choice() {
  static const SimdChoice choice = simd_choice_of(std::getenv("DYNFILTER_SIMD"));
  return choice;
}

/// Whether dynfilter's own code uses AVX2 in this process. The one place of dispatch.
/// Results are the same bit for bit.
inline bool uses_avx2() {
#if defined(DYNFILTER_X86)
  static const bool uses = simd_choice() == SimdChoice::Auto && __builtin_cpu_supports("avx2") != 0;
  return uses;
#else
  return false;
#endif
}

namespace detail {

#if defined(DYNFILTER_X86)
template <class F, class... Arguments>
DYNFILTER_AVX2 auto call_for_avx2(const F& f, Arguments... arguments) {
  return f(arguments...);
}
#endif

/// Returns f(), compiled for AVX2 if `wide`, which requires uses_avx2().
/// Mark the lambda `f` and all that it calls with DYNFILTER_AS_CALLER.
template <bool wide, class F>
auto compiled_for(const F& f) {
#if defined(DYNFILTER_X86)
  if constexpr (wide) return call_for_avx2(f);
#endif
  return f();
}

/// Returns f(std::integral_constant<int, lanes>()) with the number of 32-bit lanes:
/// 8, compiled for AVX2, if uses_avx2() and `wide`, else 4. Mark `f` in the same way.
template <class F>
auto call_widest(const F& f, [[maybe_unused]] bool wide = true) {
#if defined(DYNFILTER_X86)
  if (wide && uses_avx2()) return call_for_avx2(f, std::integral_constant<int, 8>());
#endif
  return f(std::integral_constant<int, 4>());
}

}  // namespace detail
}  // namespace dynfilter
