// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <string>

#include "text/json.hpp"

namespace dynfilter::command {

/// Time of a part of the work on one frame [ms].
class CostWatch {
 public:
  double ms() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Where the time of a run on a video went. Sums over all frames [ms].
struct FrameCosts {
  double decode_ms = 0, grey_ms = 0, features_ms = 0, verdict_ms = 0, poses_ms = 0, drawing_ms = 0;
  std::size_t frames = 0;
  double source_rate_hz = 0;  ///< of the video; 0: not known

  double total_ms() const { return decode_ms + without_decoding_ms(); }
  double without_decoding_ms() const { return grey_ms + features_ms + verdict_ms + poses_ms + drawing_ms; }
  /// Frames per second besides decoding.
  double rate_hz() const { return 1000 * static_cast<double>(frames) / without_decoding_ms(); }
};

inline std::string costs_text(const FrameCosts& c) {
  if (c.frames == 0 || !(c.total_ms() > 0)) return "";
  const auto share = [&](double ms) { return 100 * ms / c.total_ms(); };
  const double n = static_cast<double>(c.frames);
  std::string text = fmt::format(
      "  time          decoding {:.0f} %, grey and scale {:.0f} %, features {:.0f} %,\n"
      "                flow and verdict {:.0f} %",
      share(c.decode_ms), share(c.grey_ms), share(c.features_ms), share(c.verdict_ms));
  if (c.poses_ms > 0) text += fmt::format(", poses {:.0f} %", share(c.poses_ms));
  text += fmt::format(", drawing {:.0f} % of {:.1f} ms\n", share(c.drawing_ms), c.total_ms() / n);
  text += fmt::format("  speed         {:.1f} frames a second besides decoding", c.rate_hz());
  if (c.source_rate_hz > 0) text += fmt::format("; the video has {:.4g}", c.source_rate_hz);
  return text + "\n";
}

inline Json to_json(const FrameCosts& c) {
  const double n = static_cast<double>(c.frames);
  return {{"decode_ms", c.decode_ms / n},       {"grey_ms", c.grey_ms / n},
          {"features_ms", c.features_ms / n},   {"verdict_ms", c.verdict_ms / n},
          {"poses_ms", c.poses_ms / n},         {"drawing_ms", c.drawing_ms / n},
          {"rate_hz", number_or_null(c.rate_hz())}, {"source_rate_hz", c.source_rate_hz}};
}

}  // namespace dynfilter::command
