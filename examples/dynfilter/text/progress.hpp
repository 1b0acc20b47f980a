// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>

#include "running/interruption.hpp"

namespace dynfilter::command {

/// A progress bar on stderr, or nothing if stderr is not a terminal.
/// It is removed at the end, so that it does not mix with errors and results.
/// Each step is also a point where the command can be interrupted.
class Progress {
 public:
  explicit Progress(std::string label) : label_(std::move(label)), shown_(isatty(STDERR_FILENO) != 0) {}
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() {
    if (shown_) std::fprintf(stderr, "\r\033[K");
  }

  void at(std::size_t done, std::size_t total) {
    constexpr std::size_t kWidth = 30;
    Interruption::check();
    if (!shown_ || total == 0) return;
    const std::size_t percent = 100 * done / total;
    if (percent == last_percent_) return;
    last_percent_ = percent;
    const std::string bar(kWidth * done / total, '#');
    std::fprintf(stderr, "\r\033[K%s [%-*s] %3zu %% (%zu/%zu)", label_.c_str(), static_cast<int>(kWidth),
                 bar.c_str(), percent, done, total);
    std::fflush(stderr);
  }

 private:
  std::string label_;
  bool shown_;
  std::size_t last_percent_ = ~std::size_t{0};
};

}  // namespace dynfilter::command
