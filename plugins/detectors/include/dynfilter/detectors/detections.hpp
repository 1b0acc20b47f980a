// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <filesystem>
#include <vector>

namespace dynfilter::io {

/// Detections of one image. An empty list means that the detector found nothing.
struct StampedDetections {
  double timestamp_s = 0;
  std::vector<Detection> detections;
};

/// Detector output for a sequence, by image timestamp.
struct DetectionTrack {
  std::vector<StampedDetections> images;  ///< sorted by time
  /// Skipped lines: empty or non-finite box, score out of [0, 1].
  std::size_t unusable = 0;

  /// Detections of the image with this timestamp, within half a millisecond because files round it.
  /// No result gives nullptr, which differs from an empty result.
  const std::vector<Detection>* at(double timestamp_s) const;
};

namespace detail {

inline bool usable(const Detection& d) {
  return d.score >= 0 && d.score <= 1 && d.box.width > 0 && d.box.height > 0 && std::isfinite(d.box.x) &&
         std::isfinite(d.box.y) && std::isfinite(d.box.width) && std::isfinite(d.box.height);
}

}  // namespace detail

/// Reads lines `timestamp class_id class_name score x1 y1 x2 y2` [px] and `timestamp none`.
/// `#` starts a comment. Throws IoError with file and line, also for an image with more than
/// limits::kMaxBoxes boxes.
DetectionTrack read_detections(const std::filesystem::path& path);

}  // namespace dynfilter::io
