// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/correspondence/descriptor_match.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// The reference frame's feature of each match, and the distance of their descriptors. Matches of a host and
/// of descriptors name that feature. Optical flow does not: there it is the feature nearest to the flow's
/// end, at most `max_offset_px` away.
class MatchedFeatures {
 public:
  static constexpr double kMaxOffsetPx = 2.0;

  void assign(const FrameView& frame, const Match& match, double max_offset_px);
  /// The indices only, without descriptors.
  void find(const Match& match, double max_offset_px);
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/matched_features-inl.hpp>
#endif
