// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/runner.hpp>
#include <memory>
#include <optional>
#include <utility>

namespace dynfilter {

/// The modes Sync, Late and Rate. The provider runs inside submit(), and its results are held back according
/// to the mode. Time is that of the images' timestamps and their number. The same images therefore give the
/// same results at the same frames. An image that arrives while the simulated provider is busy is skipped.
class SimulatedRunner final : public SemanticRunner {
 public:
  /// Throws ConfigError for mode Async and if a parameter is out of range.
  SimulatedRunner(std::unique_ptr<SemanticProvider> provider, const RunnerParams& params)
      : provider_(std::move(provider)), params_(params) {
    check_runner(params_);
    if (params_.mode == RunnerMode::Async) throw ConfigError("runner", "mode async is not simulated");
  }

  void submit(const SemanticImage& image) override;

  Result latest() override { return latest_; }
  RunnerStatus status() override { return status_; }

  void reset() override {
    waiting_.clear();
    latest_.reset();
    busy_until_s_.reset();
  }

 private:
  // A frame exactly at the end of an interval is in time.
  static constexpr double kSameTime_s = 1e-6;
  struct Waiting {
    std::int64_t submitted;
    Result result;
  };

  void look(const SemanticImage& image, std::int64_t now) {
    ++status_.looked_at;
    if (Result result = detail::look(*provider_, image, status_, status_.last_error))
      waiting_.push_back({now, std::move(result)});
  }
  void publish() {
    latest_ = std::move(waiting_.front().result);
    waiting_.pop_front();
  }
  void publish_all() {
    while (!waiting_.empty()) publish();
  }

  std::unique_ptr<SemanticProvider> provider_;
  RunnerParams params_;
  RunnerStatus status_;
  std::deque<Waiting> waiting_;
  Result latest_;
  std::optional<double> busy_until_s_;
};

inline void SimulatedRunner::submit(const SemanticImage& image) {
  const std::int64_t now = status_.submitted++;
  if (params_.mode == RunnerMode::Rate) {
    if (busy_until_s_ && image.timestamp_s < *busy_until_s_) {
      ++status_.skipped;
      return;
    }
    publish_all();
    busy_until_s_ = image.timestamp_s + 1 / params_.rate_hz - kSameTime_s;
  }
  look(image, now);
  const int late = params_.mode == RunnerMode::Late ? params_.late_frames : 0;
  while (params_.mode != RunnerMode::Rate && !waiting_.empty() && waiting_.front().submitted + late <= now)
    publish();
}

}  // namespace dynfilter
