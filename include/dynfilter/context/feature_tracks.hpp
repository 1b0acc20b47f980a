// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <dynfilter/context/match.hpp>
#include <dynfilter/geometry/image_neighbours.hpp>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace dynfilter {

/// Follows features over frames by chaining each frame's matches to the one before. Where the match names its
/// feature in the last frame (the host's tracks), that feature's past is taken over; where it names a place
/// only (flow, with features detected anew in every frame), the nearest feature of the last frame within
/// `max_jump_px` lends its past, shifted onto the place. Cost: O(n).
class FeatureTracks {
 public:
  /// So many earlier places are kept per feature.
  explicit FeatureTracks(int max_length, double max_jump_px = 2.0)
      : max_length_(static_cast<std::size_t>(max_length)), max_jump_px_(max_jump_px) {}

  /// The next frame: its features in distorted and undistorted pixels, and their match to an earlier frame.
  /// Without a match to the frame that was followed last, tracks begin anew.
  void follow(std::int64_t frame_id, const Match& match, const std::vector<cv::Point2f>& px,
              const std::vector<cv::Point2f>& undistorted_px) {
    const std::size_t n = px.size();
    const bool goes_on = match.reference != nullptr && has_last_ && match.reference->id == last_id_;
    std::swap(past_, last_past_);
    std::swap(length_, last_length_);
    past_.assign(n * (max_length_ + 1), cv::Point2f());
    length_.assign(n, 0);
    previous_.assign(n, -1);
    if (goes_on) index_last(match);
    for (std::size_t i = 0; i < n; ++i) {
      place(i, 0) = undistorted_px[i];
      if (match.reference == nullptr || !match.found(i)) continue;
      place(i, 1) = match.reference_undistorted_px[i];
      length_[i] = 1;
      if (goes_on) take_over(i, previous_of(match, i));
    }
    last_px_ = px;
    last_id_ = frame_id;
    has_last_ = true;
  }

  void reset() { has_last_ = false; }

  std::size_t size() const { return length_.size(); }
  /// How many earlier places of feature i are known.
  int length(std::size_t i) const { return length_[i]; }
  /// Undistorted pixels, k frames ago; k = 0 is now.
  const cv::Point2f& at(std::size_t i, int k) const {
    return past_[i * (max_length_ + 1) + static_cast<std::size_t>(k)];
  }
  /// The feature of the last frame whose past this one took over; -1: none.
  int previous(std::size_t i) const { return previous_[i]; }

 private:
  cv::Point2f& place(std::size_t i, int k) {
    return past_[i * (max_length_ + 1) + static_cast<std::size_t>(k)];
  }

  // The grid is needed for matches without an index only, and holds finite points only.
  void index_last(const Match& match) {
    const auto& c = match.correspondences;
    bool by_place = false;
    for (std::size_t i = 0; i < c.size(); ++i) by_place |= c.found[i] != 0 && c.reference_index[i] < 0;
    grid_points_.clear();
    grid_index_.clear();
    if (!by_place) return;
    for (std::size_t j = 0; j < last_px_.size(); ++j) {
      if (!detail::finite(last_px_[j])) continue;
      grid_points_.push_back({static_cast<double>(last_px_[j].x), static_cast<double>(last_px_[j].y)});
      grid_index_.push_back(static_cast<int>(j));
    }
    grid_.build(grid_points_, max_jump_px_);
  }

  int previous_of(const Match& match, std::size_t i) {
    const int index = match.correspondences.reference_index[i];
    if (index >= 0) return static_cast<std::size_t>(index) < last_px_.size() ? index : -1;
    const cv::Point2f& px = match.correspondences.reference_px[i];
    if (grid_points_.empty() || !detail::finite(px)) return -1;
    grid_.nearest(static_cast<double>(px.x), static_cast<double>(px.y), -1, 1, nearest_);
    return nearest_.empty() ? -1 : grid_index_[static_cast<std::size_t>(nearest_[0])];
  }

  void take_over(std::size_t i, int previous) {
    if (previous < 0) return;
    const auto j = static_cast<std::size_t>(previous);
    previous_[i] = previous;
    const cv::Point2f* past = &last_past_[j * (max_length_ + 1)];
    const cv::Point2f shift = place(i, 1) - past[0];
    length_[i] = std::min(last_length_[j] + 1, static_cast<int>(max_length_));
    for (int k = 2; k <= length_[i]; ++k) place(i, k) = past[k - 1] + shift;
  }

  std::size_t max_length_;
  double max_jump_px_;
  bool has_last_ = false;
  std::int64_t last_id_ = 0;
  std::vector<cv::Point2f> past_, last_past_, last_px_;  // past_: max_length_ + 1 places per feature
  std::vector<int> length_, last_length_, previous_;
  ImageNeighbours grid_;
  std::vector<ImageNeighbours::Point> grid_points_;
  std::vector<int> grid_index_, nearest_;
};

}  // namespace dynfilter
