// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "running/interruption.hpp"

namespace dynfilter::command {

/// Several runs after one another, for their progress bars.
class Batch {
 public:
  explicit Batch(std::size_t runs) : runs_(runs) {}

  /// Run `k` of these is next. Runs between that were skipped do not count for the time left.
  void at(std::size_t k) { at_ = k; }
  void begin_run() {
    if (!begin_) begin_ = Clock::now();
  }
  void end_run() { ++done_; }

  /// "run 2 of 5, about 40 s left", where `share` of the present run is done.
  std::string text(double share) const {
    constexpr double kLeastS = 2;  // before that the estimate jumps
    const std::string place = runs_ > 1 ? fmt::format("run {} of {}", at_ + 1, runs_) : "";
    const double elapsed_s = begin_ ? std::chrono::duration<double>(Clock::now() - *begin_).count() : 0;
    const double done = static_cast<double>(done_) + share;
    if (!(done > 0) || elapsed_s < kLeastS) return place;
    const double left = static_cast<double>(runs_ - at_) - share;
    return place + (place.empty() ? "" : ", ") + "about " + time_text(elapsed_s * left / done) + " left";
  }

 private:
  using Clock = std::chrono::steady_clock;

  static std::string time_text(double seconds) {
    if (seconds < 100) return fmt::format("{:.0f} s", seconds);
    if (seconds < 100 * 60) return fmt::format("{:.0f} min", seconds / 60);
    return fmt::format("{:.0f} h", seconds / 3600);
  }

  std::size_t runs_, at_ = 0, done_ = 0;
  std::optional<Clock::time_point> begin_;
};

/// A progress bar on stderr, or nothing if stderr is not a terminal.
/// It is removed at the end, so that it does not mix with errors and results.
/// Each step is also a point where the command can be interrupted.
class Progress {
 public:
  explicit Progress(std::string label, Batch* batch = nullptr)
      : label_(std::move(label)),
        batch_(batch != nullptr ? batch : &own_batch_),
        shown_(isatty(STDERR_FILENO) != 0) {
    batch_->begin_run();
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() {
    batch_->end_run();
    if (shown_) std::fprintf(stderr, "\r\033[K");
  }

  void at(std::size_t done, std::size_t total) {
    Interruption::check();
    if (!shown_ || total == 0) return;
    const std::size_t percent = 100 * done / total;
    if (percent == last_percent_) return;
    last_percent_ = percent;
    constexpr std::size_t kWidth = 30;
    const std::string bar(kWidth * done / total, '#');
    const std::string rest = batch_->text(static_cast<double>(done) / static_cast<double>(total));
    fmt::print(stderr, "\r\033[K{} [{:{}}] {:3} % ({}/{}){}{}", label_, bar, kWidth, percent, done, total,
               rest.empty() ? "" : ", ", rest);
    std::fflush(stderr);
  }

 private:
  std::string label_;
  Batch own_batch_{1};
  Batch* batch_;
  bool shown_;
  std::size_t last_percent_ = ~std::size_t{0};
};

}  // namespace dynfilter::command
