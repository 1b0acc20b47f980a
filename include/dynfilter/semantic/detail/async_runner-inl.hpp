// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/semantic/async_runner.hpp>

#include <chrono>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/semantic/simulated_runner.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE AsyncRunner::AsyncRunner(std::unique_ptr<SemanticProvider> provider,
                                          const RunnerParams& params, Clock clock)
    : params_(params), clock_(std::move(clock)), state_(std::make_shared<State>()) {
  check_parameters(params_, "runner");
  state_->provider = std::move(provider);
  state_->clock = clock_;
  worker_ = std::thread([state = state_] { work(*state); });
}

DYNFILTER_INLINE AsyncRunner::~AsyncRunner() {
  if (!state_) return;
  std::unique_lock<std::mutex> lock(state_->mutex);
  state_->stop = true;
  state_->wake.notify_all();
  const bool ended = state_->ended_or_not.wait_for(lock, std::chrono::duration<double>(params_.shutdown_s),
                                                   [&] { return state_->ended; });
  lock.unlock();
  ended ? worker_.join() : worker_.detach();
}

DYNFILTER_INLINE void AsyncRunner::submit(const SemanticImage& image) {
  abandon_if_hung();
  if (!state_) {
    ++final_.submitted;
    ++final_.skipped;
    return;
  }
  // Copied outside the lock: only this thread uses spare_.
  spare_.frame_id = image.frame_id;
  spare_.timestamp_s = image.timestamp_s;
  image.pixels.copyTo(spare_.pixels);
  image.depth.copyTo(spare_.depth);
  spare_.depth_unit_m = image.depth_unit_m;
  const std::lock_guard<std::mutex> lock(state_->mutex);
  ++state_->status.submitted;
  state_->status.skipped += state_->waiting ? 1 : 0;
  std::swap(spare_, state_->pending);
  state_->waiting = true;
  state_->wake.notify_all();
}

DYNFILTER_INLINE AsyncRunner::Result AsyncRunner::latest() {
  abandon_if_hung();
  if (!state_) return final_result_;
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->latest;
}

DYNFILTER_INLINE RunnerStatus AsyncRunner::status() {
  abandon_if_hung();
  if (!state_) return final_;
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->status;
}

DYNFILTER_INLINE void AsyncRunner::reset() {
  final_result_.reset();
  if (!state_) return;
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->status.skipped += state_->waiting ? 1 : 0;
  state_->waiting = false;
  state_->latest.reset();
  ++state_->epoch;
}

DYNFILTER_INLINE double AsyncRunner::steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

inline void AsyncRunner::work(State& state) {
  std::unique_lock<std::mutex> lock(state.mutex);
  for (;;) {
    state.wake.wait(lock, [&] { return state.stop || state.waiting; });
    if (state.stop) break;
    std::swap(state.image, state.pending);
    state.waiting = false;
    state.busy = true;
    state.busy_since_s = state.clock();
    ++state.status.looked_at;
    const int epoch = state.epoch;
    lock.unlock();
    look(state, epoch, lock);
  }
  lock.unlock();
  state.provider.reset();
  lock.lock();
  state.ended = true;
  state.ended_or_not.notify_all();
}

inline void AsyncRunner::look(State& state, int epoch, std::unique_lock<std::mutex>& lock) {
  RunnerStatus counted;
  Result result = detail::look(*state.provider, state.image, counted, counted.last_error);
  lock.lock();
  state.busy = false;
  state.status.results += counted.results;
  state.status.silent += counted.silent;
  state.status.failed += counted.failed;
  if (counted.failed > 0) state.status.last_error = counted.last_error;
  if (result && epoch == state.epoch) state.latest = std::move(result);
}

inline void AsyncRunner::abandon_if_hung() {
  if (!state_) return;
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    if (!state_->busy || clock_() - state_->busy_since_s <= params_.timeout_s) return;
    state_->stop = true;
    final_ = state_->status;
    final_.skipped += state_->waiting ? 1 : 0;
    state_->waiting = false;
    final_result_ = std::move(state_->latest);
  }
  final_.abandoned = true;
  final_.last_error = "took longer than " + detail::shown(params_.timeout_s) + " s for one image: abandoned";
  worker_.detach();
  state_.reset();
}

DYNFILTER_INLINE std::unique_ptr<SemanticRunner> make_runner(std::unique_ptr<SemanticProvider> provider,
                                                             const RunnerParams& params) {
  if (params.mode == RunnerMode::Async) return std::make_unique<AsyncRunner>(std::move(provider), params);
  return std::make_unique<SimulatedRunner>(std::move(provider), params);
}

}  // namespace dynfilter
