// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/semantic/runner.hpp>

#include <cstddef>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <exception>
#include <optional>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<RunnerParams>& RunnerParams::fields() {
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
