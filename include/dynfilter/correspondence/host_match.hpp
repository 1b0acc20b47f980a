// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/correspondence/detail/host_match-inl.hpp>
#endif
