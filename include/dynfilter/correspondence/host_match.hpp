// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/types.hpp>

namespace dynfilter {

/// Converts the host's matches.
/// `current_count` is the number of features of the current frame.
/// `reference_keypoints` are the distorted keypoints of frame `matches.reference_frame_id`.
/// Indices out of range and NaN keypoints are not found.
/// Nothing is found if the number of matches differs from the number of features.
/// Several features may share a reference feature.
/// Returns how many indices are out of range; -1, no match, does not count.
std::size_t correspondences_from_host(const HostMatches& matches,
                                      Span<const cv::KeyPoint> reference_keypoints, std::size_t current_count,
                                      Correspondences& out);

inline std::size_t correspondences_from_host(const HostMatches& matches,
                                             Span<const cv::KeyPoint> reference_keypoints,
                                             std::size_t current_count, Correspondences& out) {
  out.reset(current_count);
  if (matches.reference_index.size() != current_count) return 0;
  std::size_t out_of_range = 0;
  for (std::size_t i = 0; i < current_count; ++i) {
    const std::int32_t index = matches.reference_index[i];
    if (index == -1) continue;
    if (index < 0 || static_cast<std::size_t>(index) >= reference_keypoints.size()) {
      ++out_of_range;
      continue;
    }
    const cv::Point2f& px = reference_keypoints[static_cast<std::size_t>(index)].pt;
    if (detail::finite(px)) out.set(i, px, index);
  }
  return out_of_range;
}

}  // namespace dynfilter
