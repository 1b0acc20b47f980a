// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "run_summary.hpp"

namespace dynfilter::command {

struct ReplayOptions {
  std::string recording;
  std::string pipeline;  ///< "": the recorded one
  std::string out;
  std::string cut, cut_file;  ///< "A:B" and the file for these frames; "": none
  std::vector<std::string> plugins;
  std::size_t overlay_every = 0;
  int threads = 1;
  bool force = false;
};

/// A call of the pipeline whose verdict is not the recorded one.
struct DifferentCall {
  std::size_t frame = 0;
  std::int64_t id = 0;
  std::string point;
};

/// Verdicts beside the recorded ones.
struct ReplayComparison {
  std::size_t calls = 0, compared = 0;  ///< compared: those with a recorded verdict
  std::size_t differ = 0, decisions = 0;
  std::optional<DifferentCall> first, last;
};

struct ReplaySummary {
  Summary run;
  ReplayComparison comparison;
  bool recorded_pipeline = true;
  std::size_t images_left_out = 0;  ///< calls that lack images: their verdicts need not be the same
  std::optional<std::pair<std::size_t, std::size_t>> cut;  ///< first and last frame that were written
};

Json to_json(const ReplaySummary& replay);

/// Runs a pipeline on a recording, and compares. Throws Error for unusable input, and then leaves no files.
ReplaySummary replay_recording(const ReplayOptions& options,
                               const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace dynfilter::command
