// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/filters/detail/judged_frame.hpp>
#include <dynfilter/motion/neighbour_field.hpp>
#include <vector>

namespace dynfilter::detail {

/// Motion of a frame's features [nats].
struct FeatureOdds {
  std::vector<float> prior;        ///< log-odds of motion beforehand
  std::vector<float> own;          ///< evidence of its track (TrackEvidence)
  std::vector<float> belief;       ///< log-odds: the prior, its own evidence, and the neighbours'
  std::vector<std::uint8_t> seen;  ///< has evidence of its own in this frame

  void reset(const JudgedFrame& frame) {
    prior.resize(frame.size());
    for (std::size_t i = 0; i < frame.size(); ++i)
      prior[i] = static_cast<float>(portable::log_odds(frame.evidence.prior(i) ? kSuspects : kShare));
    belief = prior;
    own.assign(frame.size(), 0);
    seen.assign(frame.size(), 0);
  }
  /// What seems to move may do so against a mover.
  void forget_motion() {
    for (std::size_t i = 0; i < own.size(); ++i)
      own[i] = std::min(own[i], 0.0F), belief[i] = std::min(belief[i], prior[i]);
  }
  static constexpr double kShare = 0.05, kSuspects = 0.5;  ///< that move: of all, of suspects
};

/// What the neighbours of a feature say, and which features are cores of movers.
class NeighbourVotes {
 public:
  void build(const JudgedFrame& frame) {
    places_.build(frame.evidence.pixels(), frame.evidence.depths_m(), static_cast<float>(frame.neighbour_px));
  }
  NeighbourPlaces& places() { return places_; }

  /// Adds the mean evidence of the neighbours, near ones first.
  void add(const JudgedFrame& frame, FeatureOdds& odds) {
    places_.lay_out(
        evidence_, [&](std::size_t i) { return odds.own[i]; },
        [&](std::size_t i) { return odds.seen[i] != 0 ? 1.0F : 0.0F; });
    for (std::size_t i = 0; i < frame.size(); ++i)
      odds.belief[i] += odds.own[i] + mean_around(frame, odds, i);
  }
  /// A core moves, and so do most of its neighbours: a mismatch is alone.
  void find_cores(const JudgedFrame& frame, const FeatureOdds& odds) {
    places_.lay_out(
        moving_, [&](std::size_t i) { return odds.prior[i] + odds.own[i] > 0 ? 1.0F : 0.0F; },
        [&](std::size_t i) { return odds.seen[i] != 0 ? 1.0F : 0.0F; });
    is_core_.assign(frame.size(), 0);
    for (std::size_t i = 0; i < frame.size(); ++i)
      is_core_[i] = odds.seen[i] != 0 && odds.belief[i] > TrackMemory::kMoves && supported(frame, i) ? 1 : 0;
    places_.lay_out(
        cores_, [](std::size_t) { return 1.0F; },
        [&](std::size_t i) { return static_cast<float>(is_core_[i]); });
  }
  bool near_core(const JudgedFrame& frame, std::size_t i) const {
    return is_core_[i] != 0 ||
           places_.any_around(cores_, frame.evidence.pixels()[i], frame.depth_m(i), kCoreReach_px,
                              frame.reach_m(kCoreReach_m, frame.depth_m(i)));
  }

 private:
  // Features without evidence look farther. Without a depth they may lie on another surface than neighbours.
  static constexpr float kUnseenReach = 2.5F, kBlindReach = 1.3F;
  static constexpr float kBlindTrust = 0.3F;  ///< of neighbours, for a feature without depth
  static constexpr float kOwnWeight = 0.5F;   ///< of zero evidence in the mean over neighbours
  static constexpr float kSupportReach_px = 40, kSupportReach_m = 0.25F;  ///< neighbours of a core
  static constexpr float kMinSupport = 1.3F;       ///< two of them within 24 px, or more farther away
  static constexpr float kMinSupportShare = 0.5F;  ///< of them that must move, too
  static constexpr float kCoreReach_px = 120, kCoreReach_m = 0.4F;  ///< from a core to its object's features

  float mean_around(const JudgedFrame& frame, const FeatureOdds& odds, std::size_t i) const {
    const cv::Point2f& px = frame.evidence.pixels()[i];
    const float depth_m = frame.depth_m(i);
    // Its neighbours hide it from the right camera, so it lies on what is behind them.
    if (std::isnan(depth_m) && !frame.evidence.frame().right_grey.empty()) return 0;
    const bool seen = odds.seen[i] != 0;
    const float times = std::isnan(depth_m) ? kBlindReach : seen ? 1 : kUnseenReach;
    const float reach = times * static_cast<float>(frame.neighbour_px);
    NeighbourPlaces::Sum sum =
        places_.around(evidence_, px, depth_m, reach, frame.reach_m(frame.neighbour_m, depth_m));
    if (seen && PointGrid::usable(px)) sum.values -= odds.own[i], sum.weights -= 1;  // itself
    const float trust = std::isnan(depth_m) ? kBlindTrust : 1.0F;
    return trust * sum.values / (trust * sum.weights + kOwnWeight);
  }
  bool supported(const JudgedFrame& frame, std::size_t i) const {
    const NeighbourPlaces::Sum sum =
        places_.around(moving_, frame.evidence.pixels()[i], frame.depth_m(i), kSupportReach_px,
                       frame.reach_m(kSupportReach_m, frame.depth_m(i)), kOnePatch_px);
    return sum.values >= kMinSupport && sum.values >= kMinSupportShare * sum.weights;
  }

  NeighbourPlaces places_;
  NeighbourPlaces::Field evidence_, moving_, cores_;
  std::vector<std::uint8_t> is_core_;
};

}  // namespace dynfilter::detail
