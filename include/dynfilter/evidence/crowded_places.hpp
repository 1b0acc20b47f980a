// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Finds the keypoints of which more than limits::kMaxCrowd share a square of an image.
/// All searches of neighbours in an image rely on this bound: without it they take time that grows with the
/// square of the number of features.
/// The squares are those of a grid from (0, 0), so the order of the keypoints does not matter.
/// Cost: 1 us for 1000 keypoints, 10 ms for 100,000.
class CrowdedPlaces {
 public:
  /// The crowded ones, in no particular order. Positions that are not usable in a PointGrid are skipped.
  const std::vector<std::uint32_t>& find(Span<const cv::Point2f> places);
  const std::vector<std::uint32_t>& find(Span<const cv::KeyPoint> keypoints);

 private:
  static constexpr int kTableBits = 12, kIndexBits = 20;
  static constexpr std::int64_t kSquares = 1 << 18;  ///< more than there are between -1e6 and 1e6 px

  static std::uint64_t square_of(const cv::Point2f& px);
  /// Counts by a hash of the square. Two squares may share a count, so that one too many proves nothing.
  bool may_be_crowded(Span<const cv::Point2f> places);
  void find_exactly(Span<const cv::Point2f> places);

  std::array<std::uint32_t, std::size_t{1} << kTableBits> table_{};
  std::vector<cv::Point2f> places_;
  std::vector<std::uint64_t> sorted_;  ///< square and index
  std::vector<std::uint32_t> crowded_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/crowded_places-inl.hpp>
#endif
