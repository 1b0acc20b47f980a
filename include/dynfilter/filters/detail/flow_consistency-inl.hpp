// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/flow_consistency.hpp>

#include <algorithm>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <limits>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<FlowConsistencyParams>& FlowConsistencyParams::fields() {
  using P = FlowConsistencyParams;
  static const FieldTable<P> table{
      real("max_gap_s", &P::max_gap_s, "s", {0, 100},
           "longest time over which flow is measured; less while most tracks are younger"),
      flag("ground", &P::ground,
           "groups that do not stand on the ground are dynamic; used only while the camera drives forward"),
  };
  return table;
}

DYNFILTER_INLINE FlowConsistencyFilter::FlowConsistencyFilter(Params params) : params_(params) {
  check_parameters(params_, kName);
  ViewMotionOptions options;
  options.max_distance_px = detail::GapFlow::kMaxDistance_px;
  estimator_ = ViewMotionEstimator(options);
}

DYNFILTER_INLINE void FlowConsistencyFilter::apply(const Evidence& evidence, Votes& votes) {
  const Match& match = evidence.match({false, 1});
  const FeatureTracks& tracks = evidence.tracks({detail::FlowClock::kMostFrames});
  clock_.pass(evidence, match);
  tracked_.take_over(tracks, clock_.passed_s());
  main_motion_.pass(clock_.passed_s());
  ground_.pass(clock_.passed_s());
  view_.look(evidence);
  clock_.choose(tracks, params_.max_gap_s, params_.ground, gaps_);
  flow_.begin(tracks, view_);
  std::optional<TimedMotion> last = main_motion_.value();
  for (const int gap : gaps_.all) {
    if (!needs_gap(tracks, gap)) continue;
    flow_.collect(evidence, tracks, view_, gap);
    const std::optional<ViewMotion> motion = follow(gap, last, votes);
    if (!motion) continue;
    last = TimedMotion{*motion, clock_.gap_s(gap)};
    flow_.measure(*motion, tracks, view_);
    tracked_.weigh(flow_, view_);
    if (gap == gaps_.ground) ground_.weigh(flow_, *motion, last->gap_s, view_, tracked_);
    if (gap < gaps_.ground && gap == gaps_.all.back()) ground_.infer(flow_, tracks, gaps_.ground, tracked_);
  }
  vote(evidence, votes);
}

DYNFILTER_INLINE void FlowConsistencyFilter::reset() {
  tracked_.clear();
  clock_.reset();
  main_motion_.reset();
  ground_.reset();
  prior_watch_.reset();
  view_.reset();
}

inline ViewMotion FlowConsistencyFilter::TimedMotion::over(double other_s) const {
  ViewMotion scaled = motion;
  for (double& w : scaled.rotation_rad) w *= other_s / gap_s;
  return scaled;
}

inline bool FlowConsistencyFilter::needs_gap(const FeatureTracks& tracks, int gap) const {
  if (gap == gaps_.all.front() || gap == gaps_.ground) return true;
  for (std::size_t i = 0; i < tracks.size(); ++i)
    if (!tracked_.judged(i) && tracks.length(i) >= gap) return true;
  return false;
}

inline std::optional<ViewMotion> FlowConsistencyFilter::follow(int gap,
                                                               const std::optional<TimedMotion>& guess,
                                                               Votes& votes) {
  const double gap_s = clock_.gap_s(gap);
  const bool main = gap == gaps_.all.front();
  const std::optional<ViewTurn> turn = clock_.turn_over(gap);
  const std::optional<ViewMotion> found =
      estimator_.estimate(flow_.pairs(), flow_.seeds(), view_.cells(), view_.focal_px(),
                          guess ? std::optional<ViewMotion>(guess->over(gap_s)) : std::nullopt, !main,
                          prior_watch_.trusts() ? turn : std::nullopt);
  if (!main) return found;
  if (found && turn)
    prior_watch_.observe(ViewMotionEstimator::turn_distance2(*turn, *found, detail::GapFlow::kMaxDistance_px),
                         clock_.passed_s());
  if (turn && !prior_watch_.trusts()) votes.note("the motion prior contradicts the images: ignored");
  main_motion_.reset();
  if (found) main_motion_.confirm({*found, gap_s});
  note(gap, found, votes);
  return found;
}

inline void FlowConsistencyFilter::note(int gap, const std::optional<ViewMotion>& found, Votes& votes) const {
  if (!found) return votes.note("model: none, ", flow_.seeds().size(), " seeds with a track");
  votes.note("model: ", found->has_baseline() ? "rotation and direction" : "rotation", " over ", gap,
             " frames, ", flow_.size(), " features");
}

inline void FlowConsistencyFilter::spread(const Evidence& evidence) {
  const std::size_t n = evidence.size();
  depths_m_.assign(n, std::numeric_limits<float>::quiet_NaN());
  excess_.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    if (tracked_.judged(i)) excess_[i] = static_cast<float>(tracked_.excess(i));
  neighbours_.build(evidence.pixels(), depths_m_,
                    static_cast<float>(detail::GapFlow::kReach * view_.width_px()));
  neighbours_.lay_out(
      excess_around_, [&](std::size_t i) { return excess_[i]; },
      [&](std::size_t i) { return tracked_.judged(i) ? 1.0F : 0.0F; });
}

inline float FlowConsistencyFilter::mean_around(const Evidence& evidence, std::size_t i) const {
  const NeighbourPlaces::Sum sum =
      neighbours_.around(excess_around_, evidence.pixels()[i], depths_m_[i],
                         static_cast<float>(kUntrackedReach * view_.width_px()), 0);
  return sum.values / (sum.weights + kOwnWeight);
}

inline void FlowConsistencyFilter::vote(const Evidence& evidence, Votes& votes) {
  constexpr double kLimit = detail::FlowEvidence::kLimit;
  spread(evidence);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!evidence.judged(i)) continue;
    const bool tracked = tracked_.judged(i);
    const double excess = static_cast<double>(tracked ? excess_[i] : mean_around(evidence, i));
    const Vote otherwise = tracked ? Vote::Static : Vote::Unknown;
    votes.cast(i, excess > 0 ? Vote::Dynamic : otherwise, suspicion(std::max(0.0, kLimit + excess), kLimit));
  }
}

}  // namespace dynfilter
