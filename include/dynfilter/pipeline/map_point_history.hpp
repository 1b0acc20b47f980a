// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <limits>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dynfilter {

/// Which map points of the host move, by the verdicts on features over time.
///
/// Formula:  Bayes' rule per map point: log-odds += w log(P(vote | moves) / P(vote | static)), within bounds.
///           Frames within 0.2 s share matches and poses, so they count as one observation. w = dt / 0.2 s,
///           at most 1, so the rate of the camera does not matter.
/// Places:   where the host says that it sees the point. Then it goes on with the nearest feature on the same
///           surface, whose vote it takes. So it is followed when its own features are rejected, and when
///           others are detected in their place.
/// State:    one number per map point, of at most kMostPoints.
class MapPointHistory {
 public:
  /// A frame that was judged before the pose, while its evidence lasts. `frame` is as the host gave it.
  void learn(const FrameView& frame, const FrameEvidence& evidence, const Verdict& verdict);
  /// Map points of the frame that was learned last. Keypoints are in its order, and some may be missing.
  void assign(std::int64_t frame_id, Span<const cv::KeyPoint> keypoints, Span<const std::int64_t> ids) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (frame_id == frame_id_) place(keypoints, ids);
  }
  void reset();

  /// Dynamic above 80 %, Static below what is assumed at first. From any thread, as moved().
  MapPointVerdict verdict(std::int64_t map_point_id) const;
  std::vector<std::int64_t> moved() const;  ///< all Dynamic ones, sorted

 private:
  static constexpr double kIndependent_s = 0.2, kUnknownStep_s = 1.0 / 30;
  // P(dynamic | moves) = 0.7, P(dynamic | static) = 0.03: less sure than the measured recall and kept share.
  static constexpr float kDynamic = 3.15F, kStatic = -1.17F;             ///< log-odds of a vote
  static constexpr float kFirst = -2.94F, kMoves = 1.39F, kMost = 4.0F;  ///< 5 %, 80 %, 98 %
  static constexpr float kReach_px = 18, kBlindReach_px = 3;  ///< to the nearest feature; without a depth
  static constexpr float kSurface_m = 0.1F, kSurfaceShare = 0.04F;  ///< difference in depth on one surface
  static constexpr float kKeptOffset = 0.5F;      ///< from that feature's depth: noise must not add up
  static constexpr int kMostMisses = 8;           ///< frames without such a feature
  static constexpr std::size_t kMostLooks = 512;  ///< at features of a crowd: bounds the time
  static constexpr std::size_t kMostPoints = 100'000;

  struct Point {
    float log_odds = kFirst;
    std::int64_t frame_id = -1;  ///< that voted last: one vote a frame
    cv::Point2f px, step_px;     ///< place in the last frame, and its last motion
    float depth_m = 0;
    int misses = kMostMisses + 1, unseen = 0;  ///< misses above kMostMisses: its place is not known
  };
  /// To this frame, all points whose place is known.
  void carry_on(const FrameEvidence& evidence, const Verdict& verdict, float weight);
  static std::size_t nearest(const Point& point, const PointGrid& grid, const Match& match,
                             const Verdict& verdict);
  static void vote(Point& point, std::int64_t frame_id, const Verdict& verdict, std::size_t i, float weight);
  void place(Span<const cv::KeyPoint> keypoints, Span<const std::int64_t> ids);
  void lose_places();

  std::int64_t frame_id_ = -1;
  double stamp_s_ = 0;
  std::vector<cv::KeyPoint> keypoints_;
  std::vector<float> depths_m_;
  PointGrid grid_;
  mutable std::mutex mutex_;  ///< of points_
  std::unordered_map<std::int64_t, Point> points_;
  std::vector<Point*> placed_;  ///< points whose place is known
};

inline void MapPointHistory::reset() {
  const std::lock_guard<std::mutex> lock(mutex_);
  placed_.clear();
  points_.clear();
  frame_id_ = -1;
}

inline void MapPointHistory::learn(const FrameView& frame, const FrameEvidence& evidence,
                                   const Verdict& verdict) {
  if (frame.id == frame_id_) return;
  const double step_s = frame.timestamp_s - std::exchange(stamp_s_, frame.timestamp_s);
  const auto weight =
      static_cast<float>(std::clamp((step_s > 0 ? step_s : kUnknownStep_s) / kIndependent_s, 0.0, 1.0));
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::int64_t last_id = std::exchange(frame_id_, frame.id);
  const bool follows = evidence.spread() != nullptr && evidence.match({}).reference->id == last_id;
  if (!follows || points_.size() > kMostPoints) lose_places();
  if (!placed_.empty()) carry_on(evidence, verdict, weight);
  keypoints_.assign(frame.keypoints.begin(), frame.keypoints.end());
  depths_m_ = evidence.depths_m();
  for (std::size_t i = 0; i < frame.size() && frame.depth_m.size() == frame.size(); ++i)
    if (std::isnan(depths_m_[i]) && valid_depth(frame.depth_m[i])) depths_m_[i] = frame.depth_m[i];
  place(frame.keypoints, frame.map_point_ids);
  if (frame.map_point_ids.size() == frame.size())
    for (std::size_t i = 0; i < frame.size(); ++i)
      if (frame.map_point_ids[i] >= 0) vote(points_[frame.map_point_ids[i]], frame.id, verdict, i, weight);
}

inline void MapPointHistory::lose_places() {
  for (Point* const point : placed_) point->misses = kMostMisses + 1;
  placed_.clear();
  if (points_.size() <= kMostPoints) return;
  for (auto it = points_.begin(); it != points_.end();)
    it = it->second.log_odds <= kMoves ? points_.erase(it) : std::next(it);
}

inline void MapPointHistory::vote(Point& point, std::int64_t frame_id, const Verdict& verdict, std::size_t i,
                                  float weight) {
  const bool moves = verdict.called_dynamic(i);
  if (!moves && verdict.decision[i] == Vote::Unknown) return;
  if (std::exchange(point.frame_id, frame_id) == frame_id) return;
  point.log_odds = std::clamp(point.log_odds + weight * (moves ? kDynamic : kStatic), -kMost, kMost);
}

inline void MapPointHistory::carry_on(const FrameEvidence& evidence, const Verdict& verdict, float weight) {
  const Match& match = evidence.match({});
  grid_.build(Span<const cv::Point2f>(match.correspondences.reference_px), kReach_px);
  for (Point* const point : placed_) {
    const std::size_t i = nearest(*point, grid_, match, verdict);
    ++point->misses, ++point->unseen;
    if (i < verdict.size()) {
      point->misses = 0;
      point->step_px = evidence.pixels()[i] - match.correspondences.reference_px[i];
      const float depth_m = evidence.depths_m()[i], off_m = point->depth_m - match.reference_depth_m[i];
      if (std::isfinite(depth_m)) point->depth_m = depth_m + (std::isfinite(off_m) ? kKeptOffset * off_m : 0);
      vote(*point, frame_id_, verdict, i, weight);
    }
    point->px += point->step_px;
  }
  const auto is_done = [](Point* point) {  // lost, or static for sure until the host sees it again
    if (point->log_odds <= -kMost && point->unseen > kMostMisses) point->misses = kMostMisses + 1;
    return point->misses > kMostMisses;
  };
  placed_.erase(std::remove_if(placed_.begin(), placed_.end(), is_done), placed_.end());
}

/// Features with a verdict first. None: verdict.size().
inline std::size_t MapPointHistory::nearest(const Point& point, const PointGrid& grid, const Match& match,
                                            const Verdict& verdict) {
  const float surface_m = std::max(kSurface_m, kSurfaceShare * point.depth_m);
  const bool blind = !valid_depth(point.depth_m);
  const float reach_px = blind ? kBlindReach_px : kReach_px;
  std::size_t best = verdict.size();
  std::pair<bool, float> best_by(true, std::numeric_limits<float>::infinity());
  const auto look = [&](std::size_t i) {
    const cv::Point2f apart = match.correspondences.reference_px[i] - point.px;
    const float apart_m = blind ? 0 : std::abs(match.reference_depth_m[i] - point.depth_m);
    if (!(apart_m <= surface_m) || apart.dot(apart) > reach_px * reach_px) return;
    const bool unknown = verdict.decision[i] == Vote::Unknown && verdict.restored[i] == 0;
    const std::pair<bool, float> by(unknown, apart.dot(apart));
    if (by < best_by) best = i, best_by = by;
  };
  std::size_t left = kMostLooks;
  grid.ranges_around(point.px, kReach_px, [&](std::size_t begin, std::size_t end) {
    end = std::min(end, begin + left), left -= end - begin;
    for (std::size_t e = begin; e < end; ++e) look(static_cast<std::size_t>(grid.entries()[e]));
  });
  return best;
}

inline void MapPointHistory::place(Span<const cv::KeyPoint> keypoints, Span<const std::int64_t> ids) {
  if (ids.size() != keypoints.size()) return;
  for (std::size_t i = 0, j = 0; i < keypoints_.size() && j < ids.size(); ++i) {
    while (j + 1 < ids.size() && std::isnan(keypoints[j].pt.x)) ++j;
    if (keypoints_[i].pt != keypoints[j].pt || ids[j++] < 0) continue;
    Point& point = points_[ids[j - 1]];
    if (point.misses > kMostMisses) placed_.push_back(&point);
    point.px = keypoints[j - 1].pt, point.depth_m = depths_m_[i], point.misses = point.unseen = 0;
  }
}

inline MapPointVerdict MapPointHistory::verdict(std::int64_t map_point_id) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto at = points_.find(map_point_id);
  if (at == points_.end() || at->second.frame_id < 0) return {map_point_id, Vote::Unknown, Votes::kNoIdea};
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
