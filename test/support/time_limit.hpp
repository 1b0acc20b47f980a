// SPDX-License-Identifier: MIT
#pragma once

#include <ctime>

#ifdef __has_feature  // Clang's way to say so
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define DYNFILTER_SANITIZED
#endif
#endif
#if !defined(DYNFILTER_SANITIZED) && (defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__))
#define DYNFILTER_SANITIZED
#endif

namespace dynfilter_test {

/// Longest time for an input that is built to take long. It takes up to four times as long under the
/// sanitizers, and ten times without optimisation.
#if !defined(__OPTIMIZE__)
inline constexpr double kMost_s = 20;
#elif defined(DYNFILTER_SANITIZED)
inline constexpr double kMost_s = 8;
#else
inline constexpr double kMost_s = 2;
#endif

/// How long the processor works on f(). Other programs do not count.
template <class F>
double seconds(const F& f) {
  const std::clock_t begin = std::clock();
  f();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

}  // namespace dynfilter_test
