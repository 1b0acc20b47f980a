// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <mutex>
#include <opencv2/core/types.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dynfilter {

/// Which map points of the host move, by the verdicts on their features over time.
///
/// Formula:  Bayes' rule per map point: log-odds += w log(P(vote | moves) / P(vote | static)), within bounds.
///           Frames within 0.2 s share matches and poses, so they count as one observation:
///           w = dt / 0.2 s, at most 1. So the rate of the camera does not matter.
/// Features: those for which the host says the map point. A rejected feature has none in the host any more.
///           It keeps the one of the feature that was at the end of its match in the last frame.
/// State:    one number per map point, of at most kMostPoints.
class MapPointHistory {
 public:
  /// A frame that was judged before the pose, while its evidence lasts. `frame` is as the host gave it.
  void learn(const FrameView& frame, const FrameEvidence& evidence, const Verdict& verdict);
  /// Map points of the frame that was learned last. Keypoints are in its order, and some may be missing.
  void assign(std::int64_t frame_id, Span<const cv::KeyPoint> keypoints, Span<const std::int64_t> ids);
  void reset();

  /// Dynamic above 90 %, Static below what is assumed at first. From any thread, as moved().
  MapPointVerdict verdict(std::int64_t map_point_id) const;
  std::vector<std::int64_t> moved() const;  ///< all Dynamic ones, sorted

 private:
  static constexpr double kIndependent_s = 0.2, kUnknownStep_s = 1.0 / 30;
  // P(dynamic | moves) = 0.7, P(dynamic | static) = 0.05: less sure than the measured recall and kept share.
  static constexpr float kDynamic = 2.64F, kStatic = -1.15F;            ///< log-odds of a vote
  static constexpr float kFirst = -2.94F, kMoves = 2.2F, kMost = 5.0F;  ///< 5 %, 90 %, 99.3 %
  static constexpr float kJump_px = 3;  ///< from the end of a match, as in background_motion
  static constexpr std::size_t kMostPoints = 100'000;
  static constexpr std::int64_t kNone = -1;

  struct Point {
    float log_odds = kFirst;
    std::int64_t frame_id = -1;  ///< that voted last: one vote a frame
  };
  void carry_on(const FrameEvidence& evidence);

  std::int64_t frame_id_ = -1;
  double stamp_s_ = 0;
  std::vector<cv::KeyPoint> keypoints_, last_keypoints_;
  std::vector<std::int64_t> ids_, last_ids_, told_;
  PointGrid grid_;
  mutable std::mutex mutex_;  ///< of points_
  std::unordered_map<std::int64_t, Point> points_;
};

inline void MapPointHistory::reset() {
  const std::lock_guard<std::mutex> lock(mutex_);
  points_.clear();
  ids_.clear();
  frame_id_ = -1;
}

inline void MapPointHistory::learn(const FrameView& frame, const FrameEvidence& evidence,
                                   const Verdict& verdict) {
  if (frame.id == frame_id_) return;
  ids_.swap(last_ids_);
  keypoints_.swap(last_keypoints_);
  keypoints_.assign(frame.keypoints.begin(), frame.keypoints.end());
  ids_.assign(frame.size(), kNone);
  carry_on(evidence);
  frame_id_ = frame.id;
  assign(frame.id, frame.keypoints, frame.map_point_ids);
  const double step_s = frame.timestamp_s - std::exchange(stamp_s_, frame.timestamp_s);
  const auto weight =
      static_cast<float>(std::clamp((step_s > 0 ? step_s : kUnknownStep_s) / kIndependent_s, 0.0, 1.0));
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    const bool moves = verdict.called_dynamic(i);
    if (ids_[i] < 0 || (!moves && verdict.decision[i] == Vote::Unknown)) continue;
    Point& point = points_[ids_[i]];
    if (std::exchange(point.frame_id, frame.id) == frame.id) continue;
    point.log_odds = std::clamp(point.log_odds + weight * (moves ? kDynamic : kStatic), -kMost, kMost);
  }
  if (points_.size() <= kMostPoints) return;
  for (auto it = points_.begin(); it != points_.end();)  // unknown and static points are kept alike
    it = it->second.log_odds <= kMoves ? points_.erase(it) : std::next(it);
}

inline void MapPointHistory::carry_on(const FrameEvidence& evidence) {
  const bool any = std::any_of(last_ids_.begin(), last_ids_.end(), [](std::int64_t id) { return id >= 0; });
  if (!any || evidence.spread() == nullptr) return;
  const Match& match = evidence.match({});
  if (match.reference->id != frame_id_) return;
  grid_.build(Span<const cv::KeyPoint>(last_keypoints_), 4 * kJump_px);
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (!match.found(i)) continue;
    const cv::Point2f& px = match.correspondences.reference_px[i];
    float best2 = kJump_px * kJump_px;
    grid_.around(px, kJump_px, [&](std::int32_t j) {
      const cv::Point2f apart = last_keypoints_[static_cast<std::size_t>(j)].pt - px;
      if (apart.dot(apart) >= best2) return;
      best2 = apart.dot(apart);
      ids_[i] = last_ids_[static_cast<std::size_t>(j)];
    });
  }
}

inline void MapPointHistory::assign(std::int64_t frame_id, Span<const cv::KeyPoint> keypoints,
                                    Span<const std::int64_t> ids) {
  if (frame_id != frame_id_ || ids.empty() || ids.size() != keypoints.size()) return;
  told_.assign(ids.begin(), ids.end());
  std::sort(told_.begin(), told_.end());
  std::size_t j = 0;
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    while (j < ids.size() && std::isnan(keypoints[j].pt.x)) ++j;
    const bool there = j < ids.size() && keypoints_[i].pt == keypoints[j].pt;
    const std::int64_t told = there ? ids[j++] : kNone;
    if (told >= 0)
      ids_[i] = told;
    else if (ids_[i] >= 0 && std::binary_search(told_.begin(), told_.end(), ids_[i]))
      ids_[i] = kNone;  // the host has it elsewhere
  }
}

inline MapPointVerdict MapPointHistory::verdict(std::int64_t map_point_id) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto at = points_.find(map_point_id);
  if (at == points_.end()) return {map_point_id, Vote::Unknown, Votes::kNoIdea};
  const float odds = at->second.log_odds;
  const Vote vote = odds > kMoves ? Vote::Dynamic : odds < kFirst ? Vote::Static : Vote::Unknown;
  return {map_point_id, vote, 1 / (1 + portable::exp(-odds / 2))};
}

inline std::vector<std::int64_t> MapPointHistory::moved() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::int64_t> ids;
  for (const auto& [id, point] : points_)
    if (point.log_odds > kMoves) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace dynfilter
