// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/context/match.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace dynfilter {

/// Where the current features were in the last frames. Features are
/// detected anew in every frame, so a track is a chain: a feature's place in the last frame lies close to a
/// feature of that frame, and takes over its past, shifted by the few pixels between the two (their flow is
/// taken to be the same). This costs no flow of its own: about 60 us for 1000 features.
class Tracks {
 public:
  static constexpr int kLength = 6;  ///< frames back that are kept
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

  struct Place {
    cv::Point2f undistorted_px;
    float depth_m = kNone;  ///< NaN: none
  };

  void clear() {
    last_.reset({}, {}, {});
    now_.reset({}, {}, {});
    last_id_ = now_id_ = kNoFrame;
  }

  std::size_t size() const { return now_.age.size(); }
  /// So many frames back the track of feature i goes; 0: it was not found in the last frame.
  int age(std::size_t i) const { return now_.age[i]; }
  /// Where feature i was `gap` frames back, 1 <= gap <= age(i).
  const Place& place(std::size_t i, int gap) const { return now_.past[at(i, gap)]; }
  /// Which feature of the frame last_frame_id() continues as feature i; -1: none. For what a filter
  /// remembers.
  int linked(std::size_t i) const { return now_.linked[i]; }
  std::int64_t last_frame_id() const { return last_id_; }

  /// The features of a frame; `match` is with the frame before it.
  void advance(std::int64_t frame_id, const Match& match, const std::vector<cv::Point2f>& pixels,
               const std::vector<cv::Point2f>& undistorted_px, const std::vector<float>& depths_m) {
    if (frame_id != now_id_) {
      std::swap(last_, now_);
      last_id_ = std::exchange(now_id_, frame_id);
    }
    now_.reset(pixels, undistorted_px, depths_m);
    const bool continues = match.reference != nullptr && match.reference->id == last_id_;
    if (continues) grid_.build(Span<const cv::Point2f>(last_.pixels), kReach_px);
    for (std::size_t i = 0; i < now_.size(); ++i) {
      if (!match.found(i)) continue;
      now_.age[i] = 1;
      now_.past[at(i, 1)] = {match.reference_undistorted_px[i], match.reference_depth_m[i]};
      if (continues) link(i, match);
    }
  }

 private:
  static constexpr std::int64_t kNoFrame = std::numeric_limits<std::int64_t>::min();
  static constexpr float kReach_px = 3.0F, kDepthShare = 0.04F;

  struct Frame {
    std::vector<cv::Point2f> pixels, undistorted_px;
    std::vector<float> depths_m;
    std::vector<int> age, linked;
    std::vector<Place> past;

    std::size_t size() const { return pixels.size(); }
    void reset(const std::vector<cv::Point2f>& px, const std::vector<cv::Point2f>& ideal_px,
               const std::vector<float>& depth_m) {
      pixels = px;
      undistorted_px = ideal_px;
      depths_m = depth_m;
      linked.assign(px.size(), -1);
      age.assign(px.size(), 0);
      past.resize(px.size() * kLength);
    }
  };

  static std::size_t at(std::size_t i, int gap) { return i * kLength + static_cast<std::size_t>(gap - 1); }

  void link(std::size_t i, const Match& match) {
    const Place& then = now_.past[at(i, 1)];
    const std::int32_t index = match.correspondences.reference_index[i];
    const bool told = index >= 0 && static_cast<std::size_t>(index) < last_.size();
    const int other = told ? index : nearest(match.correspondences.reference_px[i], then.depth_m);
    if (other < 0) return;
    const auto j = static_cast<std::size_t>(other);
    now_.linked[i] = other;
    const cv::Point2f shift = then.undistorted_px - last_.undistorted_px[j];
    const float deeper_m = then.depth_m - last_.depths_m[j];
    const int known = std::min(last_.age[j], kLength - 1);
    for (int gap = 1; gap <= known; ++gap) {
      const Place& earlier = last_.past[at(j, gap)];
      now_.past[at(i, gap + 1)] = {earlier.undistorted_px + shift, earlier.depth_m + deeper_m};
    }
    now_.age[i] = known + 1;
  }

  /// The closest feature of the last frame that is not at another depth, or -1.
  int nearest(const cv::Point2f& px, float depth_m) const {
    int best = -1;
    float best2 = kReach_px * kReach_px;
    grid_.around(px, kReach_px, [&](std::int32_t j) {
      const auto k = static_cast<std::size_t>(j);
      const cv::Point2f d = last_.pixels[k] - px;
      const float d2 = d.dot(d);
      if (d2 > best2 || std::abs(last_.depths_m[k] - depth_m) > kDepthShare * depth_m) return;
      best2 = d2;
      best = j;
    });
    return best;
  }

  Frame last_, now_;
  std::int64_t last_id_ = kNoFrame, now_id_ = kNoFrame;
  PointGrid grid_;
};

}  // namespace dynfilter
