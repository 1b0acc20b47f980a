// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <condition_variable>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/runner.hpp>
#include <dynfilter/semantic/simulated_runner.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace dynfilter {

/// Runs a provider in its own thread. submit() costs one copy of the image and never waits for the provider.
/// The queue holds one image, and a newer image replaces a waiting one.
/// submit(), latest() and status() hold a mutex only for the duration of a swap.
///
/// A provider that throws is reported in the status and called again with the next image. A provider that
/// takes longer than `timeout_s` for an image is abandoned. Its thread is detached and then owns the provider
/// and the image alone. If the provider returns later, the thread deletes them and ends. A thread cannot be
/// killed. To be able to kill a provider, run it in a process (detectors/process_provider.hpp). The
/// destructor waits up to `shutdown_s` and then abandons the provider. A provider abandoned at the end of
/// main() must not use static objects.
/// The provider's thread uses and deletes it. cv::setNumThreads is not changed, because it applies to the
/// whole process. A network's own threads compete with the tracker unless it runs in another process.
class AsyncRunner final : public SemanticRunner {
 public:
  using Clock = std::function<double()>;  ///< seconds, monotonic

  /// `clock` measures the timeout. Throws ConfigError if a parameter is out of range.
  AsyncRunner(std::unique_ptr<SemanticProvider> provider, const RunnerParams& params, Clock clock = steady_s);

  ~AsyncRunner() override;

  void submit(const SemanticImage& image) override;
  Result latest() override;
  RunnerStatus status() override;
  void reset() override;
  /// The steady clock of the system [s].
  static double steady_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }

 private:
  /// Shared by the runner and the worker. Protected by the mutex, except the worker's own members.
  struct State {
    std::mutex mutex;
    std::condition_variable wake, ended_or_not;
    bool stop = false, ended = false;
    bool waiting = false, busy = false;
    double busy_since_s = 0;
    int epoch = 0;
    SemanticImage pending;
    Result latest;
    RunnerStatus status;
    // Used by the worker only.
    std::unique_ptr<SemanticProvider> provider;
    SemanticImage image;
    Clock clock;
  };

  static void work(State& state);

  /// Returns with the lock held.
  static void look(State& state, int epoch, std::unique_lock<std::mutex>& lock);

  void abandon_if_hung();

  RunnerParams params_;
  Clock clock_;
  std::shared_ptr<State> state_;  ///< null: abandoned
  std::thread worker_;
  SemanticImage spare_;
  RunnerStatus final_;  ///< set when abandoned
  Result final_result_;
};

inline AsyncRunner::AsyncRunner(std::unique_ptr<SemanticProvider> provider, const RunnerParams& params,
                                Clock clock)
    : params_(params), clock_(std::move(clock)), state_(std::make_shared<State>()) {
  check_runner(params_);
  state_->provider = std::move(provider);
  state_->clock = clock_;
  worker_ = std::thread([state = state_] { work(*state); });
}

inline AsyncRunner::~AsyncRunner() {
  if (!state_) return;
  std::unique_lock<std::mutex> lock(state_->mutex);
  state_->stop = true;
  state_->wake.notify_all();
  const bool ended = state_->ended_or_not.wait_for(lock, std::chrono::duration<double>(params_.shutdown_s),
                                                   [&] { return state_->ended; });
  lock.unlock();
  ended ? worker_.join() : worker_.detach();
}

inline void AsyncRunner::submit(const SemanticImage& image) {
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

inline AsyncRunner::Result AsyncRunner::latest() {
  abandon_if_hung();
  if (!state_) return final_result_;
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->latest;
}

inline RunnerStatus AsyncRunner::status() {
  abandon_if_hung();
  if (!state_) return final_;
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->status;
}

inline void AsyncRunner::reset() {
  final_result_.reset();
  if (!state_) return;
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->status.skipped += state_->waiting ? 1 : 0;
  state_->waiting = false;
  state_->latest.reset();
  ++state_->epoch;
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
  final_.last_error = "took longer than " + number_text(params_.timeout_s) + " s for one image: abandoned";
  worker_.detach();
  state_.reset();
}

/// Creates the runner for a mode.
inline std::unique_ptr<SemanticRunner> make_runner(std::unique_ptr<SemanticProvider> provider,
                                                   const RunnerParams& params) {
  if (params.mode == RunnerMode::Async) return std::make_unique<AsyncRunner>(std::move(provider), params);
  return std::make_unique<SimulatedRunner>(std::move(provider), params);
}

}  // namespace dynfilter
