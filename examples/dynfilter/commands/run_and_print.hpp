// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <dynfilter/core/printable_text.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "run_options.hpp"
#include "running/run_summary.hpp"
#include "running/sequence_run.hpp"
#include "text/progress.hpp"
#include "text/terminal.hpp"

namespace dynfilter::command {

inline void print_notes(const std::vector<std::string>& notes, bool wide = false) {
  for (const std::string& note : notes) {
    std::string block = wrapped("note: " + note, wide ? 1000 : text_columns(), 4);
    fmt::print("{}", block.erase(0, 2));
  }
}

/// Says on stderr which runs failed and why, a line each, and returns the exit code.
inline int print_failures(const std::vector<Summary>& summaries) {
  ExitCode code = kDone;
  for (const Summary& s : summaries) {
    std::string why = s.tracked_frames == 0 && !s.verdicts_only ? "no frame could be tracked" : "";
    if (!s.failure.empty()) why += (why.empty() ? "" : "; ") + s.failure;
    if (why.empty()) continue;
    fmt::print(stderr, "dynfilter: {} on {}: {}\n", s.pipeline, s.sequence, without_controls(why));
    code = kFailed;
  }
  return code;
}

/// Runs a sequence with a progress bar, then prints the summary as JSON or with `print_text`.
template <class PrintText>
Summary run_and_print(const RunOptions& options, bool json, const PrintText& print_text) {
  Summary summary;
  {
    Progress bar(options.pipeline);
    summary = run_sequence(options, [&](std::size_t done, std::size_t total) { bar.at(done, total); });
  }
  if (json)
    fmt::print("{}", json_text(named_json(summary)));
  else
    print_text(summary);
  return summary;
}

}  // namespace dynfilter::command
