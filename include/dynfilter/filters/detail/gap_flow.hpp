// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/filters/detail/flow_view.hpp>
#include <dynfilter/motion/flow_groups.hpp>
#include <dynfilter/motion/neighbour_field.hpp>
#include <dynfilter/motion/view_motion.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <tuple>
#include <vector>

namespace dynfilter::detail {

/// A feature that can be judged over a gap.
struct FlowPoint {
  std::size_t feature;
  ViewPair pair;
  ViewFlow flow;
  double length_px;
  bool seed;
  double across_noise = 1, along_noise = 1;  ///< of the flow across and along its line, 1: of a corner

  double line_length() const { return flow.inverse_depth != 0 ? flow.along_px / flow.inverse_depth : 0; }
};

/// The flow of the features over one gap, relative to the camera's motion, and which flows are similar.
class GapFlow {
 public:
  static constexpr double kNoise_px = 0.15;       ///< smallest noise of a flow; larger noise is measured
  static constexpr double kMaxDistance_px = 1.0;  ///< from its line of a point that supports a motion
  static constexpr double kReach = 0.05;          ///< [image widths] radius of a neighbourhood

  /// Sorts the features with a track by position, so that nothing depends on their order.
  void begin(const FeatureTracks& tracks, const FlowView& view) {
    order_.clear();
    for (std::size_t i = 0; i < tracks.size(); ++i)
      if (tracks.length(i) > 0 && FlowView::within(tracks.at(i, 0)))
        order_.push_back({view.centred(tracks.at(i, 0)), i});
    std::sort(order_.begin(), order_.end(), [](const Placed& a, const Placed& b) {
      return std::tie(a.now.x, a.now.y, a.feature) < std::tie(b.now.x, b.now.y, b.feature);
    });
  }
  /// The pairs of points over a gap.
  void collect(const Evidence& evidence, const FeatureTracks& tracks, const FlowView& view, int gap) {
    points_.clear();
    for (const auto& [now, i] : order_) {
      if (tracks.length(i) < gap || !FlowView::within(tracks.at(i, gap))) continue;
      const cv::Point2d then = view.centred(tracks.at(i, gap));
      const bool seed = tracks.spread(i).along < MatchSpread::kSaysNothing && evidence.seed(i);
      points_.push_back({i, {then.x, then.y, now.x, now.y}, {}, 0, seed});
    }
    const auto before = [](const FlowPoint& p, const FlowPoint& q) {
      return std::tie(p.pair.x, p.pair.y, p.pair.reference_x, p.pair.reference_y, p.feature) <
             std::tie(q.pair.x, q.pair.y, q.pair.reference_x, q.pair.reference_y, q.feature);
    };
    // Only features at the same position may still be out of order.
    if (!std::is_sorted(points_.begin(), points_.end(), before))
      std::sort(points_.begin(), points_.end(), before);
    pairs_.clear();
    seeds_.clear();
    for (std::size_t k = 0; k < points_.size(); ++k) {
      pairs_.push_back(points_[k].pair);
      if (points_[k].seed) seeds_.push_back(static_cast<int>(k));
    }
  }
  const std::vector<ViewPair>& pairs() const { return pairs_; }
  const std::vector<int>& seeds() const { return seeds_; }

  /// Takes the camera's motion off. A match that slides far says nothing, and takes no part from then on.
  void measure(const ViewMotion& motion, const FeatureTracks& tracks, const FlowView& view) {
    has_baseline_ = motion.has_baseline();
    const ViewFlowModel model(motion);
    for (FlowPoint& p : points_) {
      p.flow = model(p.pair);
      p.length_px = p.flow.length_px();
      set_noise(tracks.spread(p.feature), p);
    }
    const auto silent = [](const FlowPoint& p) { return p.across_noise > kMostNoise; };
    points_.erase(std::remove_if(points_.begin(), points_.end(), silent), points_.end());
    noise_px_ = measured_noise_px();
    group(view);
  }
  std::size_t size() const { return points_.size(); }
  const FlowPoint& operator[](std::size_t k) const { return points_[k]; }
  const FlowGroups& groups() const { return groups_; }
  double noise_px() const { return noise_px_; }

  /// Of the middle of the static scene: median over the image's cells of each cell's median. Infinite without
  /// a baseline, or if fewer than kLeastCells are left. `agrees(k)`: point k is static.
  template <class Agrees>
  double middle_inverse_depth(const FlowView& view, const Agrees& agrees) {
    in_cell_.build(static_cast<std::size_t>(view.cells().count()), size(), [&](std::size_t k) {
      const FlowPoint& p = points_[k];
      return agrees(k) ? static_cast<CellLists::Key>(view.cells().of(p.pair.x, p.pair.y))
                       : CellLists::kNoCell;
    });
    values_.clear();
    in_one_.reserve(order_.capacity());  // no allocation later, whichever cell the points gather in
    for (std::size_t c = 0; c < in_cell_.size(); ++c) {
      if (in_cell_[c].empty()) continue;
      in_one_.clear();
      for (const std::int32_t k : in_cell_[c])
        in_one_.push_back(points_[static_cast<std::size_t>(k)].flow.inverse_depth);
      values_.push_back(averaged_median_in_place(in_one_));
    }
    return has_baseline_ && values_.size() >= kLeastCells ? std::max(0.0, averaged_median_in_place(values_))
                                                          : std::numeric_limits<double>::infinity();
  }
  /// Flow along the line that no static point has: against its direction, or as if it were too near.
  double wrong_way_px(const FlowPoint& p, double along_px, double middle_inverse_depth) const {
    if (!has_baseline_) return along_px;
    if (along_px < 0 || std::isinf(middle_inverse_depth)) return std::min(0.0, along_px);
    const double middle_px = middle_inverse_depth * p.line_length();
    return std::max(0.0, along_px - kNearest * (middle_px + noise_px_));
  }

 private:
  /// Deviations of a corner from which on a flow across its line says nothing. A match that slides meets
  /// other places of its edge, and no variance describes how far.
  static constexpr double kMostNoise = 3;
  static constexpr int kNeighbours = 6;                          ///< judged together if their flow is ...
  static constexpr double kAlike_px = 0.4, kAlikeOfFlow = 0.06;  ///< ... similar: largest difference
  static constexpr std::size_t kLeastCells = 9;                  ///< that tell the middle of the scene
  /// What moves along its line seems to be nearer or farther than it is. Static things are seldom nearer than
  /// a fifth of the middle of the scene. Movers often seem to be: they outrun a camera in the hand.
  static constexpr double kNearest = 5;

  struct Placed {
    cv::Point2d now;
    std::size_t feature;
  };

  static void set_noise(const MatchSpread& spread, FlowPoint& p) {
    if (!spread.slides()) return;
    constexpr double kTurn2 = MatchSpread::kEdgeTurn_rad * MatchSpread::kEdgeTurn_rad;
    const double on_line = spread.edge.x * p.flow.line_x + spread.edge.y * p.flow.line_y;
    const double across2 = spread.across, more2 = spread.along - across2, share = on_line * on_line;
    p.along_noise = std::sqrt(across2 + more2 * share);
    p.across_noise = std::sqrt(across2 + more2 * (std::max(0.0, 1 - share) + kTurn2));
  }
  /// 1.48 times the median distance of the points that agree with the motion.
  double measured_noise_px() {
    values_.clear();
    for (const FlowPoint& p : points_)
      if (std::abs(p.flow.across_px) < kMaxDistance_px)
        values_.push_back(std::abs(p.flow.across_px) / p.across_noise);
    return values_.empty() ? kNoise_px : std::max(kNoise_px, 1.48 * averaged_median_in_place(values_));
  }
  /// Two flows are similar if a common depth and a common distance from the epipolar line explain both.
  void group(const FlowView& view) {
    places_.clear();
    for (const FlowPoint& p : points_) places_.emplace_back(p.pair.x, p.pair.y);
    groups_.build(places_, kReach * view.width_px(), kNeighbours, kOnePatch_px,
                  [&](std::size_t i, std::size_t j) {
                    const FlowPoint &p = points_[i], &q = points_[j];
                    const double along = has_baseline_ ? (p.flow.inverse_depth - q.flow.inverse_depth) * 0.5 *
                                                             (p.line_length() + q.line_length())
                                                       : p.flow.along_px - q.flow.along_px;
                    const double limit = kAlike_px + kAlikeOfFlow * 0.5 * (p.length_px + q.length_px);
                    const double across = p.flow.across_px - q.flow.across_px;
                    return along * along + across * across < limit * limit;
                  });
  }

  bool has_baseline_ = false;
  double noise_px_ = 0;
  std::vector<Placed> order_;
  std::vector<FlowPoint> points_;
  std::vector<ViewPair> pairs_;
  std::vector<int> seeds_;
  FlowGroups groups_;
  std::vector<cv::Point2d> places_;
  std::vector<double> values_, in_one_;
  CellLists in_cell_;
};

}  // namespace dynfilter::detail
