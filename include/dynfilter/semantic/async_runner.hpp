// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <dynfilter/core/error.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/runner.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace dynfilter {

/// Runs a provider in its own thread.
/// submit() costs one copy of the image and never waits for the provider.
/// The queue holds one image, and a newer image replaces a waiting one.
/// submit(), latest() and status() hold a mutex only for the duration of a swap.
///
/// A provider that throws is reported in the status and called again with the next image.
/// A provider that takes longer than `timeout_s` for an image is abandoned.
/// Its thread is detached and then owns the provider and the image alone.
/// If the provider returns later, the thread deletes them and ends.
/// A thread cannot be killed. To be able to kill a provider, run it in a process
/// (detectors/process_provider.hpp).
/// The destructor waits up to `shutdown_s` and then abandons the provider.
/// A provider abandoned at the end of main() must not use static objects.
///
/// The provider's thread uses and deletes it.
/// cv::setNumThreads is not changed, because it applies to the whole process.
/// A network's own threads therefore compete with the tracker unless it runs in another process.
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

  static double steady_s();

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

/// Creates the runner for a mode.
std::unique_ptr<SemanticRunner> make_runner(std::unique_ptr<SemanticProvider> provider,
                                            const RunnerParams& params);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/semantic/detail/async_runner-inl.hpp>
#endif
