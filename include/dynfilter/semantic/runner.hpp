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

/// When the results of a provider arrive. All but Async are reproducible bit for bit.
enum class RunnerMode {
  Async,  ///< when they are done, in a thread of its own
  Sync,   ///< before submit() returns
  Late,   ///< those of frame k with frame k + late_frames
  Rate    ///< as of a provider that takes 1 / rate_hz by the images' timestamps, always busy
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
               "when results arrive; sync, late and rate are for experiments, bit for bit reproducible"),
        integer("late_frames", &P::late_frames, "frames", {0, 1000}, "mode late: so many frames later"),
        real("rate_hz", &P::rate_hz, "Hz", {0.001, 1000}, "mode rate: results a second"),
        real("timeout_s", &P::timeout_s, "s", {0.001, 3600},
             "mode async: a provider that takes longer for one image is abandoned"),
        real("shutdown_s", &P::shutdown_s, "s", {0, 1}, "mode async: how long the destructor waits at most"),
    };
    return table;
  }
};

/// "async", "sync", "late:3" or "rate:2" (Hz). Throws ConfigError.
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

/// How a runner fares. submitted = looked_at + skipped + what is waiting.
struct RunnerStatus {
  std::int64_t submitted = 0;
  std::int64_t skipped = 0;    ///< never looked at: a newer image came first
  std::int64_t looked_at = 0;  ///< handed to the provider, the one that it is busy with included
  std::int64_t results = 0;
  std::int64_t silent = 0;  ///< the provider had nothing to say
  std::int64_t failed = 0;  ///< it threw
  bool abandoned = false;   ///< it hung; no more results will come
  std::string last_error;   ///< of the last that failed, or why it was abandoned
};

/// Hands images to a provider and results to the tracker. One object per camera stream, used by one thread
/// (the tracker's).
class SemanticRunner {
 public:
  using Result = std::shared_ptr<const SemanticResult>;

  SemanticRunner() = default;
  SemanticRunner(const SemanticRunner&) = delete;
  SemanticRunner& operator=(const SemanticRunner&) = delete;
  virtual ~SemanticRunner() = default;

  /// The next frame, with an id that grows. The pixels are copied where they are needed later.
  virtual void submit(const SemanticImage& image) = 0;

  /// The newest result there is, with the id of the frame it saw; null: none came yet. It stays the same
  /// until a newer one is there.
  virtual Result latest() = 0;

  virtual RunnerStatus status() = 0;

  /// Another scene: results of the images submitted so far are not handed out any more.
  virtual void reset() = 0;

  /// The newest result, once; null when there is none since the last call.
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

/// One look of a provider, with all that can go wrong written to the status. Null without a result.
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
