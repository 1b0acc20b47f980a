// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/semantic/simulated_runner.hpp>

#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/parameters.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE SimulatedRunner::SimulatedRunner(std::unique_ptr<SemanticProvider> provider,
                                                  const RunnerParams& params)
    : provider_(std::move(provider)), params_(params) {
  check_parameters(params_, "runner");
  if (params_.mode == RunnerMode::Async) throw ConfigError("runner", "mode async is not simulated");
}

DYNFILTER_INLINE void SimulatedRunner::submit(const SemanticImage& image) {
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

DYNFILTER_INLINE void SimulatedRunner::reset() {
  waiting_.clear();
  latest_.reset();
  busy_until_s_.reset();
}

inline void SimulatedRunner::look(const SemanticImage& image, std::int64_t now) {
  ++status_.looked_at;
  if (Result result = detail::look(*provider_, image, status_, status_.last_error))
    waiting_.push_back({now, std::move(result)});
}

inline void SimulatedRunner::publish() {
  latest_ = std::move(waiting_.front().result);
  waiting_.pop_front();
}

inline void SimulatedRunner::publish_all() {
  while (!waiting_.empty()) publish();
}

}  // namespace dynfilter
