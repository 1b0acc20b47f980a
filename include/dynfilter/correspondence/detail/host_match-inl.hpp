// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/correspondence/host_match.hpp>

#include <cstdint>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE std::size_t correspondences_from_host(const HostMatches& matches,
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
