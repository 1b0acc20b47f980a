// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/background_motion.hpp>

#include <cmath>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/motion/moving_odds.hpp>
#include <limits>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<BackgroundMotionParams>& BackgroundMotionParams::fields() {
  static const FieldTable<BackgroundMotionParams> table;  // nothing that a user should have to set
  return table;
}

DYNFILTER_INLINE BackgroundMotionFilter::BackgroundMotionFilter(Params params) : params_(params) {
  check_parameters(params_, kName);
  reset();
}

DYNFILTER_INLINE void BackgroundMotionFilter::reset() {
  has_chosen_ = false;
  estimator_.reset();
  prior_watch_.reset();
  path_.reset();
  memory_.clear();
  noise_.reset();
  forecast_.clear();
}

DYNFILTER_INLINE void BackgroundMotionFilter::apply(const Evidence& evidence, Votes& votes) {
  const detail::JudgedFrame frame{evidence,
                                  evidence.match({}),
                                  evidence.tracks(kTracks),
                                  *evidence.frame().camera,
                                  depth_noise_of(evidence.frame()),
                                  is_stereo(evidence.frame()),
                                  params_.neighbour_px,
                                  params_.neighbour_m};
  path_.begin(evidence.frame());
  neighbours_.build(frame);
  memory_.recall(frame);
  odds_.reset(frame);
  judge(frame, votes);
  views_.clear();  // they refer to images of kept frames
  memory_.learn(odds_.own, odds_.belief, neighbours_.places(), certainty(), path_.elapsed_s(1));
}

inline void BackgroundMotionFilter::judge(const detail::JudgedFrame& seen, Votes& votes) {
  if (seen.match.reference == nullptr) {
    path_.chain(false);
    forecast_.clear();
    return votes.note("no earlier frame");
  }
  const Choice choice = follow_background(seen, votes);
  if (!choice.known) return;
  if (estimator_.confidence() < choice.least_confidence) {
    abstain(votes);
    if (choice.least_confidence == kLikelyConfidence) path_.forget_motion();
    return;
  }
  if (!choice.is_sure) votes.note("the background is not sure: rejected is what moves by all likely ones");
  const detail::JudgedFrame frame = seen.with(seen.stereo ? look_again(seen) : seen.match);
  forecast_.advance(path_.between(0, 1), frame.camera, path_.elapsed_s(1));
  const DepthNoise depths = frame.sensor.scaled(std::max(kDepthFactor, estimator_.depth_factor()));
  misses_.measure(frame, path_, depths);
  noise_.measure(frame, path_, misses_, memory_.mobility());
  weigh(frame, depths);
  neighbours_.add(frame, odds_);
  neighbours_.find_cores(frame, odds_);
  const float limit = limit_nats();
  for (std::size_t i = 0; i < frame.size(); ++i)
    if (frame.evidence.judged(i)) cast(frame, i, choice, limit, votes);
  if (choice.forgets()) odds_.forget_motion();
  learn_forecast(frame, limit);
}

inline const Match& BackgroundMotionFilter::look_again(const detail::JudgedFrame& frame) {
  misses_.measure(frame, path_, frame.sensor);
  return frame.evidence.second_look(frame.match, path_.between(0, 1),
                                    misses_.doubted(kDoubtedSigmas * path_.noise_px(1)));
}

inline void BackgroundMotionFilter::abstain(Votes& votes) {
  votes.note("background uncertain");
  votes.doubt();
  forecast_.clear();
}

// ---- the background's motion

inline BackgroundMotionFilter::Choice BackgroundMotionFilter::follow_background(
    const detail::JudgedFrame& frame, Votes& votes) {
  Choice choice;
  if (!std::exchange(has_chosen_, true)) choice.least_confidence = kLikelyConfidence;
  const RigidBackgroundScene scene = scene_of(frame);
  const RigidMotion motion = estimator_.estimate(scene);
  if (scene.prior && motion.ok) prior_watch_.observe(estimator_.prior_distance2(), path_.elapsed_s(1));
  if (scene.prior && !prior_watch_.trusts()) votes.note("the motion prior contradicts the images: ignored");
  note_motion(motion, votes);
  if (!motion.ok) {
    path_.forget_motion();
    forecast_.clear();
    if (estimator_.points() >= kMinSeeds) votes.doubt();
    return choice;
  }
  path_.add(motion.T_current_reference, {estimator_.match_noise_px(), estimator_.row_twist()});
  choice.known = true;
  choice.is_first = path_.steps() < kFirstSteps;
  const bool rows_count = choice.is_first && estimator_.rows_may_part();
  const double sure = rows_count                             ? kSureDespiteRows
                      : choice.is_first && path_.steps() > 1 ? kSureNextConfidence
                                                             : kSureConfidence;
  choice.is_sure = estimator_.confidence() >= sure;
  path_.chain(path_.is_last_frame(frame.match.reference->id) && !choice.forgets());
  return choice;
}

inline RigidBackgroundScene BackgroundMotionFilter::scene_of(const detail::JudgedFrame& frame) {
  collect_seeds(frame);
  RigidBackgroundScene scene;
  scene.camera = frame.camera;
  scene.depth_noise = frame.sensor;
  scene.reference_m = frame.match.reference_points_m;
  scene.current_m = frame.points_m;
  scene.pixels = frame.evidence.pixels();
  scene.mobility = memory_.mobility();
  scene.seeds = seeds_;
  scene.predicted = frame.evidence.host_motion(frame.match);
  scene.prior = frame.evidence.motion_prior(frame.match);
  scene.prior_wrong = prior_watch_.wrong();
  scene.elapsed_s = path_.elapsed_s(1);
  if (path_.steps() > 0) {
    scene.expected = path_.usual_step();
    scene.last_turn_radps = path_.last_turn_radps();
  }
  scene.noise_ratio = noise_.step_ratio();
  return scene;
}

/// Suspects take part where it is known what the camera does, or where there is little else.
inline void BackgroundMotionFilter::collect_seeds(const detail::JudgedFrame& frame) {
  frame.evidence.collect_seeds(frame.match, path_.steps() > 0, seeds_);
  if (seeds_.size() < kMinSeeds) frame.evidence.collect_seeds(frame.match, true, seeds_);
  firm_.clear();
  for (const int i : seeds_)
    if (frame.match.correspondences.spread[static_cast<std::size_t>(i)].along < MatchSpread::kSaysNothing)
      firm_.push_back(i);
  if (firm_.size() >= kEnoughFirm) std::swap(seeds_, firm_);
}

inline void BackgroundMotionFilter::note_motion(const RigidMotion& motion, Votes& votes) const {
  if (!motion.ok) return votes.note("background: none of the motions explains enough");
  const MotionProposal& p = estimator_.proposals()[estimator_.chosen()];
  votes.note("background: ", motion.inliers, " of ", estimator_.points(), " points, motion ",
             (p.from == MotionProposal::From::Expected    ? "as expected"
              : p.from == MotionProposal::From::Predicted ? "as predicted"
                                                          : "by support"),
             ", one of ", estimator_.proposals().size());
}

// ---- evidence of each feature

inline void BackgroundMotionFilter::weigh(const detail::JudgedFrame& frame, const DepthNoise& depths) {
  misses_.set_noise(frame, path_, depths, [&](std::size_t gap) { return noise_.sigma_px(path_, gap); });
  open_views(frame, depths);
  const detail::MissOdds odds_of_match(frame, path_, misses_, noise_, depths);
  const TrackEvidence over_time(path_.elapsed_s(1));
  for (std::size_t i = 0; i < frame.size(); ++i) {
    float& own = odds_.own[i];
    own = over_time.faded(memory_.evidence(i));
    const detail::TrackMisses::Measured &step = misses_.step(i), &track = misses_.track(i);
    const bool matched = step.gap > 0 || track.gap > 0;
    float now = matched ? odds_of_match(i) : space_odds(frame.points_m[i]);
    // Movers on a road keep to their epipolar line.
    const bool can_show_rest = matched && (track.in_space() || !step.on_line() || !frame.stereo);
    const float expected = can_show_rest ? 0 : forecast(frame, i);
    if (expected > 0 && !(now > expected)) now = expected;
    if (std::isnan(now)) continue;
    odds_.seen[i] = now > 0 || can_show_rest ? 1 : 0;
    own = over_time.with(own, now, odds_of_match.most_over_track(i));
  }
}

inline void BackgroundMotionFilter::open_views(const detail::JudgedFrame& frame, const DepthNoise& depths) {
  views_.clear();
  const std::size_t oldest = std::min(path_.unbroken(), path_.steps());
  for (std::size_t gap = 1; gap <= oldest; gap += std::max<std::size_t>(1, oldest - 1)) {
    const PastFrame* past = frame.evidence.kept_frame(path_.frame_id(gap));
    if (past == nullptr) continue;
    const FreeSpaceView::Model model{noise_.sigma_px(path_, gap), depths};
    views_.emplace_back(frame.camera, past->depth, past->depth_unit_m, path_.between(gap, 0), model);
  }
}

inline float BackgroundMotionFilter::space_odds(const cv::Point3f& point_m) const {
  double most = 0;
  for (const FreeSpaceView& view : views_) most = std::max(most, view.odds(point_m));
  return std::min(static_cast<float>(most), detail::MissOdds::kMost);
}

inline float BackgroundMotionFilter::forecast(const detail::JudgedFrame& frame, std::size_t i) const {
  const float depth_m = frame.depth_m(i);
  const bool blind = std::isnan(depth_m);
  if (blind && !frame.stereo) return 0;  // holes of structured light lie behind outlines
  const float near_m = blind ? depth_m : frame.reach_m(MoverForecast::kNearShare * depth_m, depth_m);
  return forecast_.evidence(frame.evidence.undistorted_pixels()[i], depth_m, near_m);
}

inline void BackgroundMotionFilter::learn_forecast(const detail::JudgedFrame& frame, float limit) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const PointMotion now_of_then(path_.between(0, 1));
  const auto per_s = static_cast<float>(1 / path_.elapsed_s(1));
  to_forecast_.clear();
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const cv::Point3f& now = frame.points_m[i];
    if (!std::isfinite(now.z) || odds_.seen[i] == 0) continue;
    const float evidence = odds_.belief[i] - odds_.prior[i];  // the prior is counted once
    const bool moves = detail::TrackMemory::kUnknown + evidence > limit;
    MoverForecast::Seen seen{
        now, {kNone, kNone, kNone}, moves ? evidence : std::min(odds_.own[i], 0.0F), moves};
    const detail::TrackMisses::Measured& step = misses_.step(i);
    if (moves && step.in_space() && neighbours_.near_core(frame, i))
      seen.velocity_mps =
          per_s * (now - now_of_then(back_project(frame.camera, step.then.px, step.then.depth_m)));
    to_forecast_.push_back(seen);
  }
  forecast_.learn(to_forecast_);
}

inline float BackgroundMotionFilter::limit_nats() const {
  double moving = 0, all = 0;
  for (std::size_t i = 0; i < odds_.belief.size(); ++i)
    if (odds_.seen[i] != 0) moving += odds_.belief[i] > detail::TrackMemory::kMoves ? 1 : 0, all += 1;
  const double share = std::clamp(all > 0 ? moving / all : 0.0, detail::FeatureOdds::kShare, 0.5);
  return kRejectCost_nats + detail::TrackMemory::kUnknown - static_cast<float>(portable::log_odds(share));
}

inline void BackgroundMotionFilter::cast(const detail::JudgedFrame& frame, std::size_t i,
                                         const Choice& choice, float limit, Votes& votes) const {
  const bool seen = odds_.seen[i] != 0;
  const float belief = odds_.belief[i], score = 1 / (1 + portable::exp(-belief / 2));
  const float unmatched = seen || forecast_.expects() ? 0 : kNoMatch_nats;
  if (!(belief + unmatched > limit)) return votes.cast(i, seen ? Vote::Static : Vote::Unknown, score);
  const bool supported = frame.evidence.prior(i) || neighbours_.near_core(frame, i) || forecast(frame, i) > 0;
  const bool rejects = supported && (choice.is_sure || follows_no_rival(frame, i));
  votes.cast(i, rejects ? Vote::Dynamic : Vote::Unknown, score);
}

inline bool BackgroundMotionFilter::follows_no_rival(const detail::JudgedFrame& frame, std::size_t i) const {
  const detail::TrackMisses::Measured& step = misses_.step(i);
  if (!step.in_space()) return false;
  const cv::Point3f then = back_project(frame.camera, step.then.px, step.then.depth_m);
  return estimator_.rest_by_rivals(frame.camera, then, frame.points_m[i]) < 1 - kSureNextConfidence;
}

}  // namespace dynfilter
