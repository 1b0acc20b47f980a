// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

namespace dynfilter_test {

/// Longest time for an input that is built to take long. Without optimisation it takes ten times as long.
#ifdef __OPTIMIZE__
inline constexpr double kMost_s = 2;
#else
inline constexpr double kMost_s = 20;
#endif

/// How long f() takes.
template <class F>
double seconds(const F& f) {
  const auto begin = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace dynfilter_test
