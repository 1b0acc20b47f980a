// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "stage_totals.hpp"

// What the user must know of a run beside its figures. For the command and for Python alike.
namespace dynfilter::command {

/// "1 frame", "7 frames"
inline std::string counted(std::size_t n, const char* one) {
  return fmt::format("{} {}{}", n, one, n == 1 ? "" : "s");
}

/// Why every feature of every frame was unknown. The figures are then those of no pipeline at all.
inline std::string unknown_note(const StageTotals& stages) {
  std::string note = "every feature of every frame is unknown: no stage judged any, all are kept";
  const std::vector<std::string> reasons = stages.reasons();
  return reasons.empty() ? note : note + fmt::format(" ({})", fmt::join(reasons, "; "));
}

/// A rejector that failed in every frame that reached it; "" if there is none.
inline std::string failure_of(const StageTotals& stages) {
  for (const StageTotal& stage : stages.stages()) {
    if (!stage.filter || stage.frames == 0 || stage.failed < stage.frames) continue;
    std::string text = fmt::format("{} failed on all of {}", stage.name, counted(stage.frames, "frame"));
    const std::string head = "failed: ";
    for (const auto& [note, frames] : stage.notes)
      if (note.rfind(head, 0) == 0) return text + ": " + note.substr(head.size());
    return text;
  }
  return "";
}

}  // namespace dynfilter::command
