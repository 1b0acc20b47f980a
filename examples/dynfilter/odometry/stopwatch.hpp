// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <ctime>

#include "track_result.hpp"

namespace dynfilter::odometry {

/// CPU time of all threads of this process [ms].
inline double process_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

class Stopwatch {
 public:
  /// Adds the time since the last call, or since construction, to a step of the frame.
  void lap(TrackResult& result, double StageTimes::*step) {
    const auto now = std::chrono::steady_clock::now();
    const double cpu_ms = process_cpu_ms();
    result.ms.*step += std::chrono::duration<double, std::milli>(now - last_).count();
    result.cpu_ms.*step += cpu_ms - last_cpu_ms_;
    last_ = now, last_cpu_ms_ = cpu_ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  double last_cpu_ms_ = process_cpu_ms();
};

}  // namespace dynfilter::odometry
