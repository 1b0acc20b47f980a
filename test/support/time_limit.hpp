// SPDX-License-Identifier: MIT
#pragma once

#include <ctime>

namespace dynfilter_test {

/// Longest time for an input that is built to take long. Without optimisation it takes ten times as long.
#ifdef __OPTIMIZE__
inline constexpr double kMost_s = 2;
#else
inline constexpr double kMost_s = 20;
#endif

/// How long the processor works on f(). Other programs do not count.
template <class F>
double seconds(const F& f) {
  const std::clock_t begin = std::clock();
  f();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

}  // namespace dynfilter_test
