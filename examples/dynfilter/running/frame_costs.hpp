// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "odometry/track_result.hpp"
#include "text/json.hpp"

namespace dynfilter::command {

/// Where the CPU time of a run on a video went. Sums over all frames [ms].
/// Decoders have threads of their own, so that decoding is what remains of the process's time.
struct FrameCosts {
  double process_ms = 0, grey_ms = 0, features_ms = 0, verdict_ms = 0, poses_ms = 0, boxes_ms = 0;
  double drawing_ms = 0;
  std::size_t frames = 0;
  double source_rate_hz = 0;  ///< of the video; 0: not known
  bool encodes = false;       ///< a video is written, in threads of its own as well

  /// The odometry's own clocks count elapsed time, or all threads. They tell the shares of its CPU time.
  void add(const odometry::StageTimes& elapsed, double cpu_ms) {
    const double per_ms = elapsed.total() > 0 ? cpu_ms / elapsed.total() : 0;
    features_ms += per_ms * elapsed.extraction, verdict_ms += per_ms * elapsed.judge;
    poses_ms += per_ms * (elapsed.tracking + elapsed.mapping);
  }

  double without_decoding_ms() const {
    return grey_ms + features_ms + verdict_ms + poses_ms + boxes_ms + drawing_ms;
  }
  double decoding_ms() const { return std::max(0.0, process_ms - without_decoding_ms()); }
  /// Frames per second on one core besides decoding.
  double rate_hz() const { return 1000 * static_cast<double>(frames) / without_decoding_ms(); }
};

/// Frames that a camera dropped itself: its stamps have a gap.
class MissedFrames {
 public:
  void add(double timestamp_s, double rate_hz) {
    const double gap = (timestamp_s - last_s_) * rate_hz;
    if (seen_++ > 0 && gap > kGap) missed_ += static_cast<std::size_t>(std::lround(gap)) - 1;
    last_s_ = timestamp_s;
  }
  std::size_t count() const { return missed_; }

 private:
  static constexpr double kGap = 1.5;  // in frames: stamps of arrival are not even
  std::size_t seen_ = 0, missed_ = 0;
  double last_s_ = 0;
};

inline std::string costs_text(const FrameCosts& c) {
  if (c.frames == 0 || !(c.process_ms > 0)) return "";
  const auto share = [&](double ms) { return 100 * ms / c.process_ms; };
  std::string text = fmt::format(
      "  CPU time      {} {:.0f} %, grey and scale {:.0f} %, features {:.0f} %,\n"
      "                flow and verdict {:.0f} %",
      c.encodes ? "decoding and encoding" : "decoding", share(c.decoding_ms()), share(c.grey_ms),
      share(c.features_ms), share(c.verdict_ms));
  if (share(c.poses_ms) >= 1) text += fmt::format(", poses {:.0f} %", share(c.poses_ms));
  if (share(c.boxes_ms) >= 1) text += fmt::format(", detector {:.0f} %", share(c.boxes_ms));
  text += fmt::format(", drawing {:.0f} % of {:.1f} ms a frame\n", share(c.drawing_ms),
                      c.process_ms / static_cast<double>(c.frames));
  text += fmt::format("  speed         {:.1f} frames a second on one core besides decoding", c.rate_hz());
  if (c.source_rate_hz > 0) text += fmt::format("; the video has {:.4g}", c.source_rate_hz);
  return text + "\n";
}

inline Json to_json(const FrameCosts& c) {
  const auto n = static_cast<double>(c.frames);
  return {{"decoding_ms", c.decoding_ms() / n}, {"grey_ms", c.grey_ms / n},
          {"features_ms", c.features_ms / n},   {"verdict_ms", c.verdict_ms / n},
          {"poses_ms", c.poses_ms / n},         {"detector_ms", c.boxes_ms / n},
          {"drawing_ms", c.drawing_ms / n},     {"rate_hz", number_or_null(c.rate_hz())},
          {"source_rate_hz", c.source_rate_hz}};
}

}  // namespace dynfilter::command
