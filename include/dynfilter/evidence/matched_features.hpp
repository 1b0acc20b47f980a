// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/correspondence/descriptor_match.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// The reference frame's feature of each match, and the distance of their descriptors. Matches of a host and
/// of descriptors name that feature. Optical flow does not: there it is the feature nearest to the flow's
/// end, at most `max_offset_px` away.
class MatchedFeatures {
 public:
  static constexpr double kMaxOffsetPx = 2.0;

  /// Finds index() and distance_bits() of all matches.
  void assign(const FrameView& frame, const Match& match, double max_offset_px);
  /// The indices only, without descriptors.
  void find(const Match& match, double max_offset_px);
  /// Whether it was assigned from this match and limit.
  bool is_of(const Match& match, double max_offset_px) const {
    return match_ == &match && max_offset_px_ == max_offset_px;
  }

  /// Into `match.reference->keypoints`; -1: no match, or the reference frame has no feature there.
  std::int32_t index(std::size_t i) const { return index_[i]; }
  /// Hamming distance of the two descriptors; -1: not known.
  std::int32_t distance_bits(std::size_t i) const { return distance_bits_[i]; }
  /// Both frames have binary descriptors of one length.
  bool has_descriptors() const { return has_descriptors_; }

  bool valid = false;  ///< belongs to the current frame (bookkeeping of FrameEvidence)

 private:
  static constexpr float kCellPx = 10;

  void find_indices(const Match& match);

  /// Of two that are as near, the first by its place: the order of the features does not matter.
  std::int32_t nearest(const std::vector<cv::KeyPoint>& features, const cv::Point2f& px) const;

  void measure(const cv::Mat& descriptors, const PastFrame& then);

  const Match* match_ = nullptr;
  double max_offset_px_ = 0;
  bool has_descriptors_ = false;
  std::vector<std::int32_t> index_, distance_bits_;
  detail::DescriptorWords now_, then_;
  PointGrid grid_;
};

inline void MatchedFeatures::assign(const FrameView& frame, const Match& match, double max_offset_px) {
  find(match, max_offset_px);
  distance_bits_.assign(frame.size(), -1);
  has_descriptors_ = false;
  if (match.reference != nullptr) measure(frame.descriptors, *match.reference);
}

inline void MatchedFeatures::find(const Match& match, double max_offset_px) {
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
