// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/matched_features.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE void MatchedFeatures::assign(const FrameView& frame, const Match& match,
                                              double max_offset_px) {
  find(match, max_offset_px);
  distance_bits_.assign(frame.size(), -1);
  has_descriptors_ = false;
  if (match.reference != nullptr) measure(frame.descriptors, *match.reference);
}

DYNFILTER_INLINE void MatchedFeatures::find(const Match& match, double max_offset_px) {
  match_ = &match;
  max_offset_px_ = max_offset_px;
  index_.assign(match.correspondences.found.size(), -1);
  if (match.reference != nullptr) find_indices(match);
}

inline void MatchedFeatures::find_indices(const Match& match) {
  const std::vector<cv::KeyPoint>& features = match.reference->keypoints;
  bool grid_built = false;
  for (std::size_t i = 0; i < index_.size(); ++i) {
    if (!match.found(i)) continue;
    const std::int32_t known = match.correspondences.reference_index[i];
    if (known >= 0) {
      index_[i] = static_cast<std::size_t>(known) < features.size() ? known : -1;
      continue;
    }
    if (!grid_built) grid_.build(Span<const cv::KeyPoint>(features), kCellPx);
    grid_built = true;
    index_[i] = nearest(features, match.correspondences.reference_px[i]);
  }
}

inline std::int32_t MatchedFeatures::nearest(const std::vector<cv::KeyPoint>& features,
                                             const cv::Point2f& px) const {
  if (grid_.empty() || !PointGrid::usable(px)) return -1;
  const auto radius = static_cast<float>(max_offset_px_);
  std::int32_t best = -1;
  float best2 = radius * radius;
  grid_.around(px, radius, [&](std::int32_t j) {
    const cv::Point2f step = features[static_cast<std::size_t>(j)].pt - px;
    const float d2 = step.dot(step);
    if (d2 > best2 || (d2 == best2 && best >= 0)) return;
    best2 = d2;
    best = j;
  });
  return best;
}

inline void MatchedFeatures::measure(const cv::Mat& descriptors, const PastFrame& then) {
  has_descriptors_ = descriptors.cols == then.descriptors.cols && now_.assign(descriptors, index_.size()) &&
                     then_.assign(then.descriptors, then.keypoints.size());
  if (!has_descriptors_) return;
  for (std::size_t i = 0; i < index_.size(); ++i)
    if (index_[i] >= 0)
      distance_bits_[i] =
          detail::hamming(now_.row(i), then_.row(static_cast<std::size_t>(index_[i])), now_.stride());
}

}  // namespace dynfilter
