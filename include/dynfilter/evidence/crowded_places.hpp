// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/fast_math.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Finds the keypoints of which more than limits::kMaxCrowd share a square of an image. All searches of
/// neighbours in an image rely on this bound. Without it their time grows with the square of the number of
/// features. The squares are those of a grid from (0, 0), so the order of the keypoints does not matter.
/// Cost: 1 us for 1000 keypoints, 10 ms for 100,000.
class CrowdedPlaces {
 public:
  /// The crowded ones, in no particular order. Positions that are not usable in a PointGrid are skipped.
  const std::vector<std::uint32_t>& find(Span<const cv::Point2f> places);
  /// The same for keypoints. Both results are valid until the next call.
  const std::vector<std::uint32_t>& find(Span<const cv::KeyPoint> keypoints);

 private:
  static constexpr int kTableBits = 12;
  static constexpr std::int64_t kSquares = 1 << 18;  ///< more than there are between -1e6 and 1e6 px

  static std::uint64_t square_of(const cv::Point2f& px);
  /// Counts by a hash of the square. Two squares may share a count, so that one too many proves nothing.
  bool may_be_crowded(Span<const cv::Point2f> places);
  void find_exactly(Span<const cv::Point2f> places);

  std::array<std::uint32_t, std::size_t{1} << kTableBits> table_{};
  std::vector<cv::Point2f> places_;
  CellLists squares_;
  std::vector<std::uint32_t> crowded_;
};

inline const std::vector<std::uint32_t>& CrowdedPlaces::find(Span<const cv::KeyPoint> keypoints) {
  places_.clear();
  for (const cv::KeyPoint& keypoint : keypoints) places_.push_back(keypoint.pt);
  return find(places_);
}

inline const std::vector<std::uint32_t>& CrowdedPlaces::find(Span<const cv::Point2f> places) {
  crowded_.clear();
  if (places.size() > limits::kMaxCrowd && may_be_crowded(places)) find_exactly(places);
  return crowded_;
}

inline std::uint64_t CrowdedPlaces::square_of(const cv::Point2f& px) {
  const auto along = [](float at_px) {
    return cvFloor(at_px / static_cast<float>(limits::kCrowd_px)) + kSquares / 2;
  };
  return static_cast<std::uint64_t>(along(px.y) * kSquares + along(px.x));
}

inline bool CrowdedPlaces::may_be_crowded(Span<const cv::Point2f> places) {
  constexpr std::uint64_t kGoldenRatio = 0x9E3779B97F4A7C15U;
  table_.fill(0);
  std::uint32_t most = 0;
  for (const cv::Point2f& place : places) {
    if (!PointGrid::usable(place)) continue;
    std::uint32_t& count = table_[square_of(place) * kGoldenRatio >> (64 - kTableBits)];
    most = std::max(most, ++count);
  }
  return most > limits::kMaxCrowd;
}

inline void CrowdedPlaces::find_exactly(Span<const cv::Point2f> places) {
  squares_.build_occupied(places.size(), [&](std::size_t i) {
    return PointGrid::usable(places[i]) ? square_of(places[i]) : CellLists::kNoCell;
  });
  for (std::size_t square = 0; square < squares_.size(); ++square)
    if (squares_[square].size() > limits::kMaxCrowd)
      crowded_.insert(crowded_.end(), squares_[square].begin(), squares_[square].end());
}

}  // namespace dynfilter
