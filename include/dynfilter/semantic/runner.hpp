// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/semantic/provider.hpp>
#include <memory>
#include <string>

namespace dynfilter {

/// When the results of a provider arrive. All modes except Async are bit-for-bit reproducible.
enum class RunnerMode {
  Async,  ///< when they are complete, computed in a separate thread
  Sync,   ///< before submit() returns
  Late,   ///< results of frame k arrive with frame k + late_frames
  Rate    ///< simulates a provider that is always busy and takes 1 / rate_hz, in image time
};

struct RunnerParams {
  RunnerMode mode = RunnerMode::Async;
  int late_frames = 3;    ///< delay of results, for Late, 0 to 1000
  double rate_hz = 10;    ///< results per second, for Rate, 0.001 to 1000
  double timeout_s = 5;   ///< after which a provider is abandoned, for Async, 0.001 to 3600
  double shutdown_s = 1;  ///< longest wait of the destructor, for Async, 0 to 1
};

/// Throws ConfigError naming the first value that is out of range.
void check_runner(const RunnerParams& params);

/// Parses "async", "sync", "late:3" or "rate:2" (Hz). Throws ConfigError.
RunnerParams parse_runner_mode(const std::string& text);

/// Counters of a runner. submitted = looked_at + skipped + images that wait.
struct RunnerStatus {
  std::int64_t submitted = 0;
  std::int64_t skipped = 0;    ///< replaced by a newer image before processing
  std::int64_t looked_at = 0;  ///< passed to the provider, including the current one
  std::int64_t results = 0;
  std::int64_t silent = 0;  ///< the provider had no result
  std::int64_t failed = 0;  ///< the provider threw
  bool abandoned = false;   ///< the provider hung; no more results arrive
  std::string last_error;   ///< of the last failure, or the reason for abandoning
};

/// Passes images to a provider and results to the tracker.
/// One object per camera stream, used by the tracker's thread only.
class SemanticRunner {
 public:
  using Result = std::shared_ptr<const SemanticResult>;

  SemanticRunner() = default;
  SemanticRunner(const SemanticRunner&) = delete;
  SemanticRunner& operator=(const SemanticRunner&) = delete;
  virtual ~SemanticRunner() = default;

  /// Submits the next frame, with increasing ids. Pixels are copied if they are needed later.
  virtual void submit(const SemanticImage& image) = 0;

  /// The newest result, with the id of its frame; null: none yet.
  /// It does not change until a newer one arrives.
  virtual Result latest() = 0;

  virtual RunnerStatus status() = 0;  ///< counters since the start

  /// Call at a scene change. Results of images submitted earlier are then discarded.
  virtual void reset() = 0;

  Result take();  ///< returns each newest result once; null if there is no new one since the last call

 private:
  Result taken_;
};

namespace detail {

/// Runs the provider once and writes errors to the status. Null without a result.
SemanticRunner::Result look(SemanticProvider& provider, const SemanticImage& image, RunnerStatus& status,
                            std::string& error);

}  // namespace detail

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/semantic/detail/runner-inl.hpp>
#endif
