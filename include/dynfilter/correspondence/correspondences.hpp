// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// Positions of the current frame's features in a reference frame. There is exactly one entry per current
/// feature, because verdicts are about current features. An entry that is not found holds NaN and -1.
struct Correspondences {
  std::vector<cv::Point2f> reference_px;  ///< distorted pixels of the reference frame
  std::vector<std::uint8_t> found;        ///< 0 or 1
  /// Feature of the reference frame; -1: none (always for flow).
  std::vector<std::int32_t> reference_index;
  std::vector<MatchSpread> spread;  ///< of the match's error

  /// Resizes to n entries, none found. Reuses memory.
  void reset(std::size_t n);
  /// Feature i was at `px`; `index`: its feature there, -1 if unknown.
  void set(std::size_t i, const cv::Point2f& px, std::int32_t index = -1) {
    reference_px[i] = px;
    found[i] = 1;
    reference_index[i] = index;
  }
  /// Feature i has no match.
  void drop(std::size_t i) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    reference_px[i] = {kNan, kNan};
    found[i] = 0;
    reference_index[i] = -1;
  }

  std::size_t size() const { return found.size(); }
  /// Number of features with a match.
  std::size_t count() const {
    return static_cast<std::size_t>(std::count(found.begin(), found.end(), std::uint8_t{1}));
  }
};

namespace detail {

inline bool finite(const cv::Point2f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y);
}

/// True if p is inside the image and at least `border_px` from its outermost pixel centres. False for NaN.
inline bool inside(const cv::Point2f& p, const cv::Size& size, float border_px) {
  return p.x >= border_px && p.y >= border_px && p.x <= static_cast<float>(size.width - 1) - border_px &&
         p.y <= static_cast<float>(size.height - 1) - border_px;
}

}  // namespace detail

inline void Correspondences::reset(std::size_t n) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  reference_px.assign(n, {kNan, kNan});
  found.assign(n, 0);
  reference_index.assign(n, -1);
  spread.assign(n, {});
}

/// Converts the host's matches. `current_count` is the number of features of the current frame.
/// `reference_keypoints` are the distorted keypoints of frame `matches.reference_frame_id`. Indices out of
/// range and NaN keypoints are not found. Nothing is found if the number of matches differs from the number
/// of features. Several features may share a reference feature. Returns how many indices are out of range;
/// -1, no match, does not count.
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
    if (!detail::finite(px)) continue;
    out.set(i, px, index);
    if (matches.spread.size() == current_count && matches.spread[i].valid())
      out.spread[i] = matches.spread[i];
  }
  return out_of_range;
}

}  // namespace dynfilter
