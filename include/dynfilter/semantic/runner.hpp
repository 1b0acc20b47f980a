// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/numbers.hpp>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <exception>
#include <memory>
#include <string>
#include <utility>

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
  int late_frames = 3;
  double rate_hz = 10;
  double timeout_s = 5;
  double shutdown_s = 1;

  static const FieldTable<RunnerParams>& fields() {
    using P = RunnerParams;
    static const FieldTable<P> table{
        choice("mode", &P::mode,
               {{"async", RunnerMode::Async},
                {"sync", RunnerMode::Sync},
                {"late", RunnerMode::Late},
                {"rate", RunnerMode::Rate}},
               "when results arrive; sync, late and rate are for experiments and bit-for-bit reproducible"),
        integer("late_frames", &P::late_frames, "frames", {0, 1000}, "delay of results, for mode late"),
        real("rate_hz", &P::rate_hz, "Hz", {0.001, 1000}, "results per second, for mode rate"),
        real("timeout_s", &P::timeout_s, "s", {0.001, 3600},
             "longest time for one image, after which the provider is abandoned, for mode async"),
        real("shutdown_s", &P::shutdown_s, "s", {0, 1}, "longest wait of the destructor, for mode async"),
    };
    return table;
  }
};

/// Parses "async", "sync", "late:3" or "rate:2" (Hz). Throws ConfigError.
inline RunnerParams parse_runner_mode(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string word = text.substr(0, colon);
  RunnerParams params;
  const double value = colon == std::string::npos ? -1 : parse_number(text.substr(colon + 1)).value_or(-1);
  if (word == "late" && value >= 0 && value <= 1000 && value == static_cast<int>(value)) {
    params.mode = RunnerMode::Late;
    params.late_frames = static_cast<int>(value);
  } else if (word == "rate" && value >= 0.001 && value <= 1000) {
    params.mode = RunnerMode::Rate;
    params.rate_hz = value;
  } else if (text == "sync" || text == "async") {
    params.mode = text == "sync" ? RunnerMode::Sync : RunnerMode::Async;
  } else {
    throw ConfigError("", "expected sync, async, late:FRAMES or rate:HZ, got `" + text + "`");
  }
  return params;
}

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

  virtual RunnerStatus status() = 0;

  /// Call at a scene change. Results of images submitted earlier are then discarded.
  virtual void reset() = 0;

  /// Returns each newest result once; null if there is no new one since the last call.
  Result take() {
    Result newest = latest();
    if (newest == taken_) return nullptr;
    taken_ = newest;
    return newest;
  }

 private:
  Result taken_;
};

namespace detail {

/// Runs the provider once and writes errors to the status. Null without a result.
inline SemanticRunner::Result look(SemanticProvider& provider, const SemanticImage& image,
                                   RunnerStatus& status, std::string& error) {
  try {
    std::optional<SemanticResult> found = provider.infer(image);
    if (!found) {
      ++status.silent;
      return nullptr;
    }
    found->frame_id = image.frame_id;
    found->timestamp_s = image.timestamp_s;
    ++status.results;
    return std::make_shared<const SemanticResult>(std::move(*found));
  } catch (const std::exception& e) {
    error = e.what();
  } catch (...) {
    error = "an exception that is not a std::exception";
  }
  ++status.failed;
  return nullptr;
}

}  // namespace detail

}  // namespace dynfilter
