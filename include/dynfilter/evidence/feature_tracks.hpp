// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <limits>
#include <list>
#include <opencv2/core/types.hpp>
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

/// Tracks features over frames by chaining the matches of consecutive frames.
/// A match with a reference index (the host's tracks) continues that feature's track.
/// A match with a position only (flow on newly detected features) continues the track of the nearest feature
/// in the last frame.
/// That feature must be within `max_jump_px` and at the same depth.
/// Its past positions are shifted accordingly.
/// Cost: O(n), about 60 us for 1000 features, without extra flow.
class FeatureTracks {
 public:
  static constexpr float kNoDepth = std::numeric_limits<float>::quiet_NaN();

  explicit FeatureTracks(const TrackOptions& options)
      : options_(options),
        max_length_(static_cast<std::size_t>(options.max_length)),
        max_jump_px_(static_cast<float>(options.max_jump_px)) {}

  const TrackOptions& options() const { return options_; }

  /// Adds the next frame: distorted and undistorted pixels of its features, their depths [m], and their match
  /// to an earlier frame.
  /// A depth is NaN if unknown; an empty array means no depth at all.
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/feature_tracks-inl.hpp>
#endif
