// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/filters/detail/flow_clock.hpp>
#include <dynfilter/filters/detail/flow_evidence.hpp>
#include <dynfilter/filters/detail/ground_distances.hpp>
#include <dynfilter/motion/expiring.hpp>
#include <dynfilter/motion/neighbour_field.hpp>
#include <dynfilter/motion/prior_evidence.hpp>
#include <dynfilter/motion/view_motion.hpp>
#include <dynfilter/motion/view_motion_search.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

struct FlowConsistencyParams {
  double max_gap_s = 1.0;
  bool ground = true;

  static const FieldTable<FlowConsistencyParams>& fields();
};

/// Rejects features whose flow over several time gaps differs from that of the static scene.
/// Needs no depth. docs/reference/filters/flow_consistency.md has the derivation.
///
/// Formula:  The camera's rotation and direction over a gap are estimated from flow, as the motion that
///           covers most of the image (motion/view_motion_search.hpp). Per feature, two medians are taken
///           over itself and its neighbours with similar flow. One is of the distance from the epipolar line.
///           The other is of the flow against the direction of static points, or of what exceeds five times
///           the flow of the middle of the scene along it. Both are in standard deviations, averaged over
///           time and over the group. Each feature is judged over the longest gap that its track covers. A
///           feature without a track has the mean excess over the limit of its neighbours. While the camera
///           drives forward, groups that do not stand on the ground are dynamic, too: cars ahead seem to be
///           beneath it, oncoming ones to hover (motion/ground_contact.hpp).
/// Needs:    correspondences from frame to frame. Optional: a camera, else a focal length is assumed, and the
///           turn of a motion prior.
/// Abstains: on features without a track whose neighbours do not move, with fewer than 12 tracks,
///           and if the tracks cover less than 5 of 72 cells of the image.
/// Blind to: movers along their epipolar line that seem no nearer than that, without `ground` or where the
///           ground is not seen; a mover that covers more of the image than the background does.
/// State:    own tracks over up to 30 frames and their evidence; the last motion and ground. The pipeline
///           keeps one earlier frame.
/// Cost:     about 1.1 ms for 320 features, 3.3 ms for 1280, without flow.
class FlowConsistencyFilter final : public NamedFilter<FlowConsistencyFilter> {
 public:
  using Params = FlowConsistencyParams;
  static constexpr const char* kName = "flow_consistency";
  static constexpr const char* kSummary = "features whose flow differs from that of the static scene (mono)";

  explicit FlowConsistencyFilter(Params params = Params());

  Needs needs() const override { return {Input::Correspondence, Input::Camera, 1}; }

  void apply(const Evidence& evidence, Votes& votes) override;
  void reset() override;

 private:
  /// A motion and its duration.
  struct TimedMotion {
    ViewMotion motion;
    double gap_s;

    /// The motion over another time at the same speed.
    ViewMotion over(double other_s) const;
  };
  static constexpr double kUntrackedReach = 0.075;  ///< [image widths] neighbourhood without a track
  static constexpr float kOwnWeight = 0.5F;         ///< of no excess in the mean over neighbours

  bool needs_gap(const FeatureTracks& tracks, int gap) const;
  /// The camera's motion over a gap. `guess`: over another gap. None if nothing explains enough.
  std::optional<ViewMotion> follow(int gap, const std::optional<TimedMotion>& guess, Votes& votes);
  void note(int gap, const std::optional<ViewMotion>& found, Votes& votes) const;
  void spread(const Evidence& evidence);
  /// Mean excess of the neighbours, near ones first: a body has features whose tracks have just begun.
  float mean_around(const Evidence& evidence, std::size_t i) const;
  void vote(const Evidence& evidence, Votes& votes);

  Params params_;
  ViewMotionEstimator estimator_;
  PriorWatch prior_watch_;
  Expiring<TimedMotion> main_motion_;  ///< over the last frame's longest gap
  detail::FlowView view_;
  detail::FlowClock clock_;
  detail::FlowClock::Gaps gaps_;  ///< of this frame
  detail::GapFlow flow_;          ///< over the current gap
  detail::FlowEvidence tracked_;
  detail::GroundDistances ground_;
  NeighbourPlaces neighbours_;
  NeighbourPlaces::Field excess_around_;
  std::vector<float> excess_, depths_m_;  ///< over the limit, in standard deviations; depths: unknown
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/flow_consistency-inl.hpp>
#endif
