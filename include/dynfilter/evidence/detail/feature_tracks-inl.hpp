// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/feature_tracks.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/correspondence/patch_spread.hpp>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE void FeatureTracks::follow(std::int64_t frame_id, const Match& match,
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

DYNFILTER_INLINE MatchSpread FeatureTracks::spread(std::size_t i) const {
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
