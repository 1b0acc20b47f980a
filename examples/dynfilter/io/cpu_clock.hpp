// SPDX-License-Identifier: MIT
#pragma once

#include <ctime>

namespace dynfilter::io {

/// CPU time since it was made. Unlike elapsed time, it does not count other programs.
class CpuClock {
 public:
  static CpuClock of_thread() { return CpuClock(CLOCK_THREAD_CPUTIME_ID); }
  static CpuClock of_process() { return CpuClock(CLOCK_PROCESS_CPUTIME_ID); }

  double ms() const { return now_ms(clock_) - begin_ms_; }

 private:
  explicit CpuClock(clockid_t clock) : clock_(clock), begin_ms_(now_ms(clock)) {}
  static double now_ms(clockid_t clock) {
    std::timespec now{};
    ::clock_gettime(clock, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
  }

  clockid_t clock_;
  double begin_ms_;
};

}  // namespace dynfilter::io
