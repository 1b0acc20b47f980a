// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "map_summary.hpp"

namespace dynfilter::command {

/// Readable text about the map.
inline std::string map_text(const MapSummary& m) {
  const auto percent = [](double share) {
    return std::isfinite(share) ? fmt::format("{:.2f} %", 100 * share) : std::string("-");
  };
  std::string text = fmt::format(
      "  map           {}\n                {} points, voxels of {:g} m, {:.0f} MB in memory\n",
      m.file.empty() ? "not written" : m.file, m.points, m.leaf_m, static_cast<double>(m.bytes) / 1e6);
  text += fmt::format("                {} keyframes ({}), {:.1f} ms each\n", m.keyframes, m.keyframes_by,
                      m.ms_per_keyframe);
  text += fmt::format("                {} points before thinning, {} cut out\n", m.full_points, m.cut_points);
  if (m.skipped + m.dropped > 0)
    text += fmt::format("                {} keyframes could not be used{}{}\n", m.skipped + m.dropped,
                        m.last_note.empty() ? "" : ": ", m.last_note);
  if (m.full)
    text += fmt::format("  full cloud    {} points, {:.0f} MB, {:.1f} ms a keyframe: {}\n", m.full->points,
                        static_cast<double>(m.full->bytes) / 1e6, m.full->ms_per_keyframe, m.full->file);
  if (!m.truth) return text;
  const MapTruthSummary& t = *m.truth;
  text += fmt::format("  against truth ghosts {}, astray {}, error {:.4f} m (95 %: {:.4f} m)\n",
                      percent(t.ghosts), percent(t.astray), t.error_median_m, t.error_p95_m);
  text += fmt::format("  against truth covers {} of what was seen, {} of what the oracle's map covers\n",
                      percent(t.coverage), percent(t.of_oracle()));
  return text;
}

}  // namespace dynfilter::command
