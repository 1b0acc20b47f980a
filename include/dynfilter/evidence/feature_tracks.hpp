// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/correspondence/patch_spread.hpp>
#include <limits>
#include <list>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace dynfilter::detail {

/// An unused entry, or a new one. T has a flag `valid`, which this sets.
/// A list keeps references to its entries valid while it grows.
template <class T>
T& next_slot(std::list<T>& slots) {
  for (T& slot : slots)
    if (!slot.valid) {
      slot.valid = true;
      return slot;
    }
  slots.emplace_back();
  slots.back().valid = true;
  return slots.back();
}

template <class T>
void free_slots(std::list<T>& slots) {
  for (T& slot : slots) slot.valid = false;
}

}  // namespace dynfilter::detail

namespace dynfilter {

/// How features are tracked.
struct TrackOptions {
  int max_length = 1;  ///< how many earlier positions are kept
  double max_jump_px =
      2.0;                 ///< how far a new feature may be from the end of the flow whose track it continues
  bool use_depth = false;  ///< also demand the same depth, and keep it

  bool operator==(const TrackOptions& o) const {
    return max_length == o.max_length && max_jump_px == o.max_jump_px && use_depth == o.use_depth;
  }
};

/// Tracks features over frames by chaining the matches of consecutive frames. A match with a reference index
/// (the host's tracks) continues that feature's track. A match with a position only (flow on newly detected
/// features) continues the track of the nearest feature in the last frame. That feature must be within
/// `max_jump_px` and at the same depth. Its past positions are shifted accordingly. Cost: O(n), about 60 us
/// for 1000 features, without extra flow.
class FeatureTracks {
 public:
  static constexpr float kNoDepth = std::numeric_limits<float>::quiet_NaN();

  explicit FeatureTracks(const TrackOptions& options)
      : options_(options),
        max_length_(static_cast<std::size_t>(options.max_length)),
        max_jump_px_(static_cast<float>(options.max_jump_px)) {}

  const TrackOptions& options() const { return options_; }

  /// Adds the next frame: distorted and undistorted pixels of its features, their depths [m], and their match
  /// to an earlier frame. A depth is NaN if unknown; an empty array means no depth at all.
  /// Without a match to the last added frame, all tracks restart.
  void follow(std::int64_t frame_id, const Match& match, const std::vector<cv::Point2f>& px,
              const std::vector<cv::Point2f>& undistorted_px, const std::vector<float>& depths_m = {});

  void reset() { has_last_ = goes_on_ = false; }

  std::size_t size() const { return length_.size(); }
  /// Of the frame added last; -1: none.
  std::int64_t last_id() const { return has_last_ ? last_id_ : -1; }
  /// Number of earlier positions of feature i.
  int length(std::size_t i) const { return length_[i]; }
  /// Undistorted pixels k frames ago; k = 0 is the current frame.
  const cv::Point2f& at(std::size_t i, int k) const { return place(i, k).undistorted_px; }
  /// Depth [m] k frames ago; NaN: no depth.
  float depth_m(std::size_t i, int k) const { return place(i, k).depth_m; }
  /// Index in the previously added frame of the feature that continues here; -1: none.
  int previous(std::size_t i) const { return previous_[i]; }
  /// Mean over the steps of feature i.
  MatchSpread spread(std::size_t i) const;

 private:
  static constexpr float kDepthShare = 0.04F;
  static constexpr std::size_t kPadding = 3;  ///< places per feature that shift_places() may overwrite

  struct Place {
    cv::Point2f undistorted_px;
    float depth_m;
  };
  /// Of a track's steps: the mean of what each adds to the unit covariance. Of the last one: the surface's
  /// slope, along the edge.
  struct Slide {
    float xx = 0, xy = 0, yy = 0;
    cv::Point2f depth_per_px;
  };
  struct LastFeature {
    cv::Point2f px;  ///< distorted
    float depth_m;
    std::int32_t index;
  };
  std::size_t row_places() const { return max_length_ + 1 + kPadding; }
  const Place& place(std::size_t i, int k) const {
    return past_[i * row_places() + static_cast<std::size_t>(k)];
  }
  Place& place(std::size_t i, int k) { return past_[i * row_places() + static_cast<std::size_t>(k)]; }

  int previous_of(const Match& match, std::size_t i) const;
  /// Order by position, so that the order of the features does not matter.
  static bool before(const LastFeature& a, const LastFeature& b) {
    return a.px.y != b.px.y ? a.px.y < b.px.y : a.px.x < b.px.x;
  }
  static float reference_depth_m(const Match& match, std::size_t i) {
    return i < match.reference_depth_m.size() ? match.reference_depth_m[i] : kNoDepth;
  }
  /// Sorts by grid cell, so that a neighbourhood is contiguous in memory.
  void lay_out_last();

  /// Shifts four places at a time, and up to kPadding more than `count`.
  static void shift_places(const Place* from, int count, const Place& shift, Place* to);

  void take_over(std::size_t i, int previous);
  static Slide slide_of(const MatchSpread& spread);

  TrackOptions options_;
  std::size_t max_length_;
  float max_jump_px_;
  bool has_last_ = false, goes_on_ = false;
  std::int64_t last_id_ = 0;
  std::vector<Place> past_, last_past_;  ///< row_places() per feature
  std::vector<Slide> slide_, last_slide_;
  std::vector<cv::Point2f> last_px_;
  std::vector<LastFeature> last_by_place_;
  std::vector<int> length_, last_length_, previous_;
  PointGrid grid_;
};

inline void FeatureTracks::follow(std::int64_t frame_id, const Match& match,
                                  const std::vector<cv::Point2f>& px,
                                  const std::vector<cv::Point2f>& undistorted_px,
                                  const std::vector<float>& depths_m) {
  const std::size_t n = px.size();
  goes_on_ = match.reference != nullptr && has_last_ && match.reference->id == last_id_;
  std::swap(past_, last_past_);
  std::swap(length_, last_length_);
  std::swap(slide_, last_slide_);
  slide_.assign(n, {});
  past_.resize(n * row_places());
  length_.assign(n, 0);
  previous_.assign(n, -1);
  if (goes_on_) lay_out_last();
  for (std::size_t i = 0; i < n; ++i) {
    place(i, 0) = {undistorted_px[i], depths_m.empty() ? kNoDepth : depths_m[i]};
    if (match.reference == nullptr || !match.found(i)) continue;
    place(i, 1) = {match.reference_undistorted_px[i], reference_depth_m(match, i)};
    length_[i] = 1;
    slide_[i] = slide_of(match.correspondences.spread[i]);
    if (goes_on_) take_over(i, previous_of(match, i));
  }
  last_px_ = px;
  last_id_ = frame_id;
  has_last_ = true;
}

inline int FeatureTracks::previous_of(const Match& match, std::size_t i) const {
  const int index = match.correspondences.reference_index[i];
  if (index >= 0) return static_cast<std::size_t>(index) < last_px_.size() ? index : -1;
  const cv::Point2f& px = match.correspondences.reference_px[i];
  const float depth_m = reference_depth_m(match, i);
  const LastFeature* best = nullptr;
  float best2 = max_jump_px_ * max_jump_px_;
  grid_.ranges_around(px, max_jump_px_, [&](std::size_t begin, std::size_t end) {
    for (const LastFeature* last = &last_by_place_[begin]; last != last_by_place_.data() + end; ++last) {
      const cv::Point2f d = last->px - px;
      const float apart2 = d.dot(d);
      if (apart2 > best2 || (best != nullptr && apart2 == best2 && !before(*last, *best))) continue;
      // NaN compares false: a missing depth passes the check.
      if (std::abs(last->depth_m - depth_m) > kDepthShare * depth_m) continue;
      best2 = apart2;
      best = last;
    }
  });
  return best != nullptr ? best->index : -1;
}

inline void FeatureTracks::lay_out_last() {
  grid_.build(Span<const cv::Point2f>(last_px_), 4 * max_jump_px_);
  last_by_place_.clear();
  for (const std::int32_t j : grid_.entries()) {
    const auto k = static_cast<std::size_t>(j);
    last_by_place_.push_back({last_px_[k], last_past_[k * row_places()].depth_m, j});
  }
}

inline void FeatureTracks::shift_places(const Place* from, int count, const Place& shift, Place* to) {
  static_assert(sizeof(Place) == 3 * sizeof(float));
  using Four = detail::Float4;
  const float x = shift.undistorted_px.x, y = shift.undistorted_px.y, z = shift.depth_m;
  const Four shifts[3] = {{x, y, z, x}, {y, z, x, y}, {z, x, y, z}};
  for (int k = 0; k < count; k += 4, from += 4, to += 4) {
    Four four[3];
    std::memcpy(four, from, sizeof four);
    for (int part = 0; part < 3; ++part) four[part] += shifts[part];
    std::memcpy(static_cast<void*>(to), four, sizeof four);
  }
}

inline void FeatureTracks::take_over(std::size_t i, int previous) {
  if (previous < 0) return;
  const auto j = static_cast<std::size_t>(previous);
  previous_[i] = previous;
  const Place* past = &last_past_[j * row_places()];
  const cv::Point2f shift = place(i, 1).undistorted_px - past[0].undistorted_px;
  const float deeper_m = place(i, 1).depth_m - past[0].depth_m;
  length_[i] = std::min(last_length_[j] + 1, static_cast<int>(max_length_));
  shift_places(past + 1, length_[i] - 1, {shift, deeper_m}, &place(i, 2));
  const Slide& before = last_slide_[j];
  Slide& mean = slide_[i];
  const auto share = 1 / static_cast<float>(length_[i]);
  mean.xx = before.xx + share * (mean.xx - before.xx);
  mean.xy = before.xy + share * (mean.xy - before.xy);
  mean.yy = before.yy + share * (mean.yy - before.yy);
}

inline FeatureTracks::Slide FeatureTracks::slide_of(const MatchSpread& spread) {
  const float more = spread.along - spread.across, x = spread.edge.x, y = spread.edge.y;
  const float across = spread.across - 1;
  return {more * x * x + across, more * x * y, more * y * y + across, spread.depth_per_px * spread.edge};
}

inline MatchSpread FeatureTracks::spread(std::size_t i) const {
  const Slide& mean = slide_[i];
  MatchSpread spread;
  if (mean.xx == 0 && mean.yy == 0) return spread;
  const detail::Axes2 axes = detail::axes_of(mean.xx, mean.xy, mean.yy);
  spread.edge = {static_cast<float>(axes.x), static_cast<float>(axes.y)};
  spread.along = static_cast<float>(1 + axes.most);
  spread.across = static_cast<float>(1 + axes.least);
  spread.depth_per_px = mean.depth_per_px.dot(spread.edge);
  return spread;
}

}  // namespace dynfilter
