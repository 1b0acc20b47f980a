// SPDX-License-Identifier: MIT
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <ctime>
#include <vector>

namespace dynfilter::bench {

/// CPU time of this thread, independent of other programs.
inline double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

/// Runs ours and the reference alternately on rotating input sets.
/// The reported time is ours, the counters contain the ratio of the medians.
template <class Ours, class Anchor>
void compare(benchmark::State& state, std::size_t sets, const Ours& ours, const Anchor& anchor) {
  const auto timed = [](const auto& f, std::size_t set) {
    const double start = cpu_ms();
    f(set);
    return cpu_ms() - start;
  };
  std::vector<double> ours_ms, anchor_ms;
  std::size_t round = 0;
  for (auto _ : state) {
    const std::size_t set = round++ % sets;
    ours_ms.push_back(timed(ours, set));
    anchor_ms.push_back(timed(anchor, set));
    state.SetIterationTime(ours_ms.back() / 1e3);
  }
  state.counters["anchor_ms"] = median(anchor_ms);
  state.counters["ratio"] = median(ours_ms) / median(anchor_ms);
}

}  // namespace dynfilter::bench
