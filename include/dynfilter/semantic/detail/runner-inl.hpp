// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/semantic/runner.hpp>

#include <cstddef>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <exception>
#include <optional>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE void check_runner(const RunnerParams& params) {
  const auto check = [](const char* name, double value, double least, double most) {
    if (!(value >= least && value <= most))
      throw ConfigError(std::string("runner.") + name,
                        "expected " + range_text(least, most) + ", got " + number_text(value));
  };
  check("late_frames", params.late_frames, 0, 1000);
  check("rate_hz", params.rate_hz, 0.001, 1000);
  check("timeout_s", params.timeout_s, 0.001, 3600);
  check("shutdown_s", params.shutdown_s, 0, 1);
}

DYNFILTER_INLINE RunnerParams parse_runner_mode(const std::string& text) {
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
    throw ConfigError("", "expected sync, async, late:FRAMES or rate:HZ, got " + in_backticks(text));
  }
  return params;
}

DYNFILTER_INLINE SemanticRunner::Result SemanticRunner::take() {
  Result newest = latest();
  if (newest == taken_) return nullptr;
  taken_ = newest;
  return newest;
}

namespace detail {

/// A provider may write to its images again when it sees the next one.
inline void own_pixels(SemanticResult& result) {
  if (result.labels) dynfilter::own_pixels(*result.labels);
  if (result.detections)
    for (Detection& detection : *result.detections) dynfilter::own_pixels(detection.mask);
}

DYNFILTER_INLINE SemanticRunner::Result look(SemanticProvider& provider, const SemanticImage& image,
                                             RunnerStatus& status, std::string& error) {
  try {
    std::optional<SemanticResult> found = provider.infer(image);
    if (!found) {
      ++status.silent;
      return nullptr;
    }
    found->frame_id = image.frame_id;
    found->timestamp_s = image.timestamp_s;
    own_pixels(*found);
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
