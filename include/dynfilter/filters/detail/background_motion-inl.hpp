// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/background_motion.hpp>

#include <Eigen/Geometry>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/motion/patch_relief.hpp>
#include <dynfilter/motion/rigid_background.hpp>
#include <opencv2/core.hpp>
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
  camera_poses_.clear();
  belief_.clear();
  mobility_.clear();
  places_.clear();
  last_places_.clear();
  estimator_.reset();
  prior_watch_.reset();
  forecast_.clear();
  match_noise_px_.clear();
  twists_.clear();
  stamps_s_.clear();
  frame_ids_.clear();
  unbroken_ = 0;
  first_choice_ = true;
  step_ratio_ = kFirstStepRatio;
  track_ratio_ = kFirstTrackRatio;
}

DYNFILTER_INLINE void BackgroundMotionFilter::apply(const Evidence& evidence, Votes& votes) {
  const Match& match = evidence.match({});
  tracks_ = &evidence.tracks(kTracks);
  keep_time(evidence.frame());
  sensor_ = depth_noise_of(evidence.frame());
  judges_directions_ = is_stereo(evidence.frame());
  std::swap(places_, last_places_);
  places_.build(evidence.pixels(), evidence.depths_m(), static_cast<float>(params_.neighbour_px));
  recall(evidence, match);
  judge(evidence, match, votes);
  views_.clear();  // they refer to images of kept frames
  remember_mobility(evidence);
}

inline void BackgroundMotionFilter::judge(const Evidence& evidence, const Match& match, Votes& votes) {
  if (match.reference == nullptr) {
    unbroken_ = 0;
    forecast_.clear();
    return votes.note("no earlier frame");
  }
  if (!follow_background(evidence, match, votes)) return;
  if (estimator_.confidence() < least_confidence_) return abstain(evidence, votes);
  if (!rejects_) votes.note("the first choices of a background reject nothing: they are not sure");
  forecast_.advance(between(0, 1), *evidence.frame().camera, elapsed_s(1));
  measure_misses(evidence, match);
  measure_noise(evidence);
  weigh_misses(evidence);
  add_neighbours(evidence);
  set_rest_log_odds();
  find_cores(evidence);
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (evidence.judged(i)) cast(evidence, i, votes);
  if (judges_directions_) learn_forecast(evidence);
}

inline void BackgroundMotionFilter::abstain(const Evidence& evidence, Votes& votes) {
  votes.note("background uncertain");
  forecast_.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (evidence.judged(i)) votes.cast(i, Vote::Unknown, Votes::kNoIdea);
  if (least_confidence_ == kLeastFirstConfidence) forget_motion();  // nor expect it to go on
}

inline void BackgroundMotionFilter::forget_motion() {
  camera_poses_.clear();
  match_noise_px_.clear();
  twists_.clear();
  forecast_.clear();
  unbroken_ = 0;
}

inline void BackgroundMotionFilter::keep_time(const FrameView& frame) {
  stamps_s_.insert(stamps_s_.begin(), frame.timestamp_s);
  frame_ids_.insert(frame_ids_.begin(), frame.id);
  if (stamps_s_.size() > kMaxFrames + 1) stamps_s_.pop_back(), frame_ids_.pop_back();
}

inline double BackgroundMotionFilter::elapsed_s(std::size_t frames) const {
  const double elapsed = frames < stamps_s_.size() ? stamps_s_[0] - stamps_s_[frames] : 0;
  return elapsed > 0 ? elapsed : static_cast<double>(frames) * kUnknownStep_s;
}

inline void BackgroundMotionFilter::recall(const Evidence& evidence, const Match& match) {
  std::swap(last_belief_, belief_);
  std::swap(last_mobility_, mobility_);
  const std::size_t n = tracks_->size();
  remembered_.assign(n, 0);
  mobility_.resize(n);
  static_belief_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto from = static_cast<std::size_t>(tracks_->previous(i));
    const bool known = tracks_->previous(i) >= 0 && from < last_belief_.size();
    if (known) remembered_[i] = last_belief_[from];
    mobility_[i] = known ? last_mobility_[from] : mobility_around(evidence, match, i);
    const float still = 1 - mobility_[i];
    static_belief_[i] = still * still / (1 + portable::exp(confidence_weight() * remembered_[i] / 2));
  }
  belief_.assign(n, 0);
}

inline float BackgroundMotionFilter::mobility_around(const Evidence& evidence, const Match& match,
                                                     std::size_t i) const {
  const bool found = match.reference != nullptr && match.found(i);
  const float depth_m =
      found && match.has_reference_point(i) ? match.reference_points_m[i].z : evidence.depths_m()[i];
  const NeighbourPlaces::Sum sum = last_places_.around(
      moved_, found ? match.correspondences.reference_px[i] : evidence.pixels()[i], depth_m,
      kMobilityReach * static_cast<float>(params_.neighbour_px), reach_m(params_.neighbour_m, depth_m));
  return sum.weights > 0 ? sum.values / sum.weights : 0;
}

inline float BackgroundMotionFilter::reach_m(double least_m, float depth_m) const {
  if (!judges_directions_ || std::isnan(depth_m)) return static_cast<float>(least_m);
  const double noise_m = kReachSigmas * std::sqrt(2.0) * sensor_.sigma_m(static_cast<double>(depth_m));
  return static_cast<float>(std::sqrt(least_m * least_m + noise_m * noise_m));
}

inline void BackgroundMotionFilter::remember_mobility(const Evidence& evidence) {
  const auto kept = static_cast<float>(portable::exp(-elapsed_s(1) / Params::kMobility_s));
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const float now = belief_[i] > 0 ? confidence_weight() * (1 - portable::exp(-belief_[i])) : 0.0F;
    mobility_[i] = std::max(kept * mobility_[i], now);
  }
  places_.lay_out(
      moved_, [&](std::size_t i) { return mobility_[i]; }, [](std::size_t) { return 1.0F; });
}

inline bool BackgroundMotionFilter::follow_background(const Evidence& evidence, const Match& match,
                                                      Votes& votes) {
  RigidBackgroundScene scene;
  scene.camera = *evidence.frame().camera;
  scene.depth_noise = sensor_;
  scene.reference_m = match.reference_points_m;
  scene.current_m = evidence.points_m();
  scene.pixels = evidence.pixels();
  scene.static_belief = static_belief_;
  scene.mobility = mobility_;
  const bool known = camera_poses_.size() >= 2;  // what the camera does: then suspects take part
  evidence.collect_seeds(match, known, seeds_);
  if (static_cast<int>(seeds_.size()) < kMinSeeds) evidence.collect_seeds(match, true, seeds_);
  drop_sliding_seeds(match);
  scene.seeds = seeds_;
  scene.predicted = evidence.host_motion(match);
  scene.prior = evidence.motion_prior(match);
  scene.prior_wrong = prior_watch_.wrong();
  if (known) scene.expected = usual_step();
  scene.elapsed_s = elapsed_s(1);
  if (known) scene.last_turn_radps = rotation_vector(between(0, 1).R()) / (elapsed_s(2) - elapsed_s(1));
  least_confidence_ = !known && first_choice_ ? kLeastFirstConfidence : kLeastConfidence;
  first_choice_ = false;
  scene.noise_ratio = step_ratio_;
  motion_ = estimator_.estimate(scene);
  if (scene.prior && motion_.ok) prior_watch_.observe(estimator_.prior_distance2(), elapsed_s(1));
  if (scene.prior && !prior_watch_.trusts()) votes.note("the motion prior contradicts the images: ignored");
  note_motion(votes);
  note_slides(match, votes);
  if (!motion_.ok) {
    forget_motion();
    return false;
  }
  remember_pose();
  const bool with_last = frame_ids_.size() > 1 && match.reference->id == frame_ids_[1];
  rejects_ = camera_poses_.size() > kFirstPoses || estimator_.confidence() >= kSureFirstConfidence;
  unbroken_ = with_last && rejects_ ? unbroken_ + 1 : 0;
  return true;
}

inline void BackgroundMotionFilter::note_motion(Votes& votes) const {
  if (!motion_.ok) return votes.note("background: none of the motions explains enough");
  const MotionProposal& p = estimator_.proposals()[estimator_.chosen()];
  votes.note("background: ", motion_.inliers, " of ", estimator_.points(), " points, motion ",
             (p.from == MotionProposal::From::Expected    ? "as expected"
              : p.from == MotionProposal::From::Predicted ? "as predicted"
                                                          : "by support"),
             ", one of ", estimator_.proposals().size());
}

inline void BackgroundMotionFilter::note_slides(const Match& match, Votes& votes) const {
  const std::vector<MatchSpread>& spread = match.correspondences.spread;
  const auto slide = static_cast<std::size_t>(std::count_if(
      spread.begin(), spread.end(), [](const MatchSpread& s) { return s.along >= MatchSpread::kFar; }));
  if (slide > 0)
    votes.note(slide, slide == 1 ? " feature slides along an edge" : " features slide along an edge");
}

inline void BackgroundMotionFilter::remember_pose() {
  if (camera_poses_.empty()) camera_poses_.push_back(Pose());
  const Pose T = camera_poses_.front() * inverse(motion_.T_current_reference);
  // Made a rotation again in every step: otherwise rounding grows with the chain.
  const Eigen::Matrix3d R = Eigen::Quaterniond(T.R()).normalized().toRotationMatrix();
  camera_poses_.insert(camera_poses_.begin(), Pose::from(R, T.t()));
  match_noise_px_.insert(match_noise_px_.begin(), estimator_.match_noise_px());
  twists_.insert(twists_.begin(), estimator_.row_twist());
  // As many as lie within the window, two at least.
  std::size_t keep = 2;
  while (keep < camera_poses_.size() - 1 && keep < kMaxFrames &&
         elapsed_s(keep + 1) < kWindow_s + kUnknownStep_s / 2)
    ++keep;
  if (camera_poses_.size() > keep + 1) camera_poses_.resize(keep + 1);
  if (match_noise_px_.size() > keep) match_noise_px_.resize(keep);
  if (twists_.size() > keep) twists_.resize(keep);
}

inline Pose BackgroundMotionFilter::usual_step() const {
  const std::size_t frames = std::min<std::size_t>(4, camera_poses_.size() - 1);
  const auto share = 1 / static_cast<double>(frames);
  const Pose over = between(0, frames);
  const Eigen::Vector3d turn = share * rotation_vector(over.R());
  const double angle_rad = turn.norm();
  const Eigen::Matrix3d R =
      angle_rad > 0 ? rotation_about(turn / angle_rad, angle_rad) : Eigen::Matrix3d::Identity();
  return Pose::from(R, share * over.t());
}

inline void BackgroundMotionFilter::measure_misses(const Evidence& evidence, const Match& match) {
  const Camera& camera = *evidence.frame().camera;
  models_.clear();
  twist_over_ = twists_;
  for (std::size_t k = 1; k < twists_.size(); ++k) twist_over_[k].a_rad += twist_over_[k - 1].a_rad;
  for (std::size_t gap = 1; gap < camera_poses_.size(); ++gap)
    models_.emplace_back(camera, between(0, gap), noise(chained_noise_px(gap)));
  step_.assign(evidence.size(), {});
  track_.assign(evidence.size(), {});
  track_misses_.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!match.found(i)) continue;
    measure(evidence, i, 1, {match.reference_undistorted_px[i], match.reference_depth_m[i]},
            match.correspondences.spread[i], step_[i], nullptr);
    const int longest = std::min(tracks_->length(i), static_cast<int>(std::min(unbroken_, models_.size())));
    if (longest > 1)
      measure(evidence, i, longest, {tracks_->at(i, longest), tracks_->depth_m(i, longest)},
              tracks_->spread(i), track_[i], &track_misses_);
  }
}

inline void BackgroundMotionFilter::measure(const Evidence& evidence, std::size_t i, int gap,
                                            const SeenPoint& then, const MatchSpread& spread, Measured& out,
                                            std::vector<Miss>* misses) {
  const SeenPoint seen = now(evidence, i, gap);
  if (!judges_directions_ && !(valid_depth(then.depth_m) && valid_depth(seen.depth_m))) return;
  const StaticMiss miss = models_[static_cast<std::size_t>(gap - 1)].miss(then, seen);
  if (miss.axes == StaticMiss::Axes::None) return;
  // What misses with a depth at one end of a track only has a wrong depth nine times out of ten.
  if (misses != nullptr && miss.axes != StaticMiss::Axes::Space) return;
  out = {gap, then, miss.image_px, miss.axes, spread_of(spread, miss, gap)};
  if (misses == nullptr) return;
  misses->push_back({evidence.pixels()[i], seen.depth_m, miss.miss_px,
                     static_cast<float>(chained_noise_px(static_cast<std::size_t>(gap)))});
}

inline SeenPoint BackgroundMotionFilter::now(const Evidence& evidence, std::size_t i, int gap) const {
  const SeenPoint seen{evidence.undistorted_pixels()[i], evidence.depths_m()[i]};
  const RowTwist& over_gap = twist_over_[static_cast<std::size_t>(gap - 1)];
  if (over_gap.none()) return seen;
  const Camera& c = *evidence.frame().camera;
  const Eigen::Vector3d ray((seen.px.x - c.cx_px) / c.fx_px, (seen.px.y - c.cy_px) / c.fy_px, 1);
  const Eigen::Vector3d q = over_gap.straighten(ray, RowTwist::row(c, evidence.pixels()[i].y));
  return {{static_cast<float>(c.fx_px * q.x() / q.z() + c.cx_px),
           static_cast<float>(c.fy_px * q.y() / q.z() + c.cy_px)},
          static_cast<float>(seen.depth_m * q.z())};
}

inline MatchSpread BackgroundMotionFilter::spread_of(const MatchSpread& spread, const StaticMiss& miss,
                                                     int gap) const {
  MatchSpread out = spread;
  if (!spread.slides()) return out;
  const float off = MatchSpread::kEdgeTurn_rad * miss.miss_px.dot(spread.edge) /
                    static_cast<float>(chained_noise_px(static_cast<std::size_t>(gap)));
  out.across += off * off;
  out.along = std::max(out.along, out.across);
  return out;
}

inline void BackgroundMotionFilter::drop_sliding_seeds(const Match& match) {
  const std::vector<MatchSpread>& spread = match.correspondences.spread;
  firm_.clear();
  for (const int i : seeds_)
    if (spread[static_cast<std::size_t>(i)].along < MatchSpread::kSaysNothing) firm_.push_back(i);
  if (firm_.size() >= kEnoughFirm) std::swap(seeds_, firm_);
}

DYNFILTER_INLINE double BackgroundMotionFilter::chained_noise_px(std::size_t gap) const {
  double sum2 = 0;
  for (std::size_t k = 0; k < gap && k < match_noise_px_.size(); ++k)
    sum2 += match_noise_px_[k] * match_noise_px_[k] + kLeastMatchNoise_px * kLeastMatchNoise_px;
  return std::sqrt(sum2);
}

inline RigidResidualNoise BackgroundMotionFilter::noise(double pixel_sigma_px) const {
  RigidResidualNoise noise;
  noise.pixel_sigma_px = pixel_sigma_px;
  noise.depth_noise = sensor_.scaled(std::max(kDepthFactor, estimator_.depth_factor()));
  return noise;
}

inline void BackgroundMotionFilter::measure_noise(const Evidence& evidence) {
  ratios_.clear();
  const double noise_px = chained_noise_px(1);
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (step_[i].in_space() && likely_static(i) &&
        static_cast<double>(step_[i].image_px) < 3 * kMostStepRatio * noise_px)
      ratios_.push_back(static_cast<float>(static_cast<double>(step_[i].image_px) / noise_px));
  step_scale_ = usual(1, kMostStepRatio, step_ratio_);
  const double shared = std::clamp(neighbour_noise_.scale(track_misses_, kNoiseReach_px).value_or(1),
                                   kLeastTrackScale, kMostTrackScale);
  ratios_.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (track_[i].in_space() && step_[i].in_space() && likely_static(i) &&
        static_cast<double>(step_[i].image_px) < 2 * step_scale_ * noise_px)
      ratios_.push_back(static_cast<float>(static_cast<double>(track_[i].image_px) /
                                           chained_noise_px(static_cast<std::size_t>(track_[i].gap))));
  track_scale_ = usual(shared, kMostTrackRatio, track_ratio_);
}

inline double BackgroundMotionFilter::usual(double base, double most, double& ratio) {
  if (ratios_.size() < kMinMeasured) return std::min(ratio, most) * base;
  const double now =
      std::clamp(static_cast<double>(median_in_place(ratios_)) / kMedianOfRayleigh / base, kLeastRatio, most);
  ratio += (now > ratio ? kRatioRises : kRatioFalls) * (now - ratio);
  return std::min(now, kRatioSlack * ratio) * base;
}

inline void BackgroundMotionFilter::weigh_misses(const Evidence& evidence) {
  const Camera& camera = *evidence.frame().camera;
  models_.clear();
  for (std::size_t gap = 1; gap < camera_poses_.size(); ++gap)
    models_.emplace_back(camera, between(0, gap), noise(sigma_px(static_cast<int>(gap))));
  const MovingOdds odds({Params::kSlow_mps, Params::kFast_mps, Params::kMovingShare});
  const MovingOdds odds_of_suspect({Params::kSlow_mps, Params::kFast_mps, Params::kMovingSuspects});
  const auto kept = static_cast<float>(portable::exp(-elapsed_s(1) / Params::kMemory_s));
  open_views(evidence);
  seen_.assign(evidence.size(), 0);
  own_.resize(evidence.size());
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    own_[i] = kept * remembered_[i];
    const bool matched = step_[i].gap > 0 || track_[i].gap > 0;
    float now = matched ? odds_of_match(evidence, i, evidence.prior(i) ? odds_of_suspect : odds)
                        : space_odds(evidence.points_m()[i]);
    const bool can_show_rest = step_[i].can_show_rest() || track_[i].can_show_rest();
    const float expected = can_show_rest ? 0 : forecast(evidence, i);
    if (expected > 0 && !(now > expected)) now = expected;
    if (now <= 0 && matched && !can_show_rest)
      own_[i] = std::max(own_[i] + std::max(now, kLeastLineOdds), kLeastBelief);
    if (std::isnan(now) || (now <= 0 && !can_show_rest)) continue;
    seen_[i] = 1;
    own_[i] = std::clamp(own_[i] + now, kLeastBelief, kMostBelief);
  }
}

inline float BackgroundMotionFilter::forecast(const Evidence& evidence, std::size_t i) const {
  const float depth_m = evidence.depths_m()[i];
  return forecast_.evidence(evidence.undistorted_pixels()[i], depth_m,
                            reach_m(MoverForecast::kNear_m, depth_m));
}

inline void BackgroundMotionFilter::learn_forecast(const Evidence& evidence) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const Camera& camera = *evidence.frame().camera;
  const Pose T_now_then = between(0, 1);
  to_forecast_.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const cv::Point3f& now = evidence.points_m()[i];
    const bool moves = belief_[i] > rest_log_odds_;
    if (!std::isfinite(now.z) || !(moves || seen_[i] != 0)) continue;
    MoverForecast::Seen seen{now, {kNone, kNone, kNone}, moves ? own_[i] : std::min(own_[i], 0.0F), moves};
    if (moves && step_[i].in_space() && near_core(evidence, i)) {
      const cv::Point3f p = back_project(camera, step_[i].then.px, step_[i].then.depth_m);
      const Eigen::Vector3d still = T_now_then.R() * Eigen::Vector3d(p.x, p.y, p.z) + T_now_then.t();
      seen.velocity_mps = (now - to_point(still)) / static_cast<float>(elapsed_s(1));
    }
    to_forecast_.push_back(seen);
  }
  forecast_.learn(to_forecast_);
}

inline float BackgroundMotionFilter::odds_of_match(const Evidence& evidence, std::size_t i,
                                                   const MovingOdds& odds) const {
  const float now = odds_with_relief(evidence, i, 0, odds);
  const double per_m = now > 0 ? relief_per_m(evidence, i) : 0;
  if (per_m == 0) return now;
  const float explained = odds_with_relief(evidence, i, per_m, odds);
  return explained > 0 ? explained : std::numeric_limits<float>::quiet_NaN();
}

inline float BackgroundMotionFilter::odds_with_relief(const Evidence& evidence, std::size_t i,
                                                      double relief_per_m, const MovingOdds& odds) const {
  const float over_track = odds_of(evidence, i, track_[i], relief_per_m, odds);
  if (is_undone(i)) return over_track;
  return std::max(odds_of(evidence, i, step_[i], relief_per_m, odds), over_track);
}

inline double BackgroundMotionFilter::relief_per_m(const Evidence& evidence, std::size_t i) const {
  const FrameView& frame = evidence.frame();
  const double depth_m = evidence.depths_m()[i];
  return PatchRelief(frame.depth, frame.depth_unit_m)
      .per_m(evidence.pixels()[i], depth_m, noise(1).depth_noise.sigma_m(depth_m));
}

inline float BackgroundMotionFilter::odds_of(const Evidence& evidence, std::size_t i,
                                             const Measured& measured, double relief_per_m,
                                             const MovingOdds& odds) const {
  if (measured.gap == 0) return kLeastOdds;
  const SeenPoint seen = now(evidence, i, measured.gap);
  const StaticMiss miss =
      models_[static_cast<std::size_t>(measured.gap - 1)](measured.then, seen, measured.spread);
  if (miss.axes == StaticMiss::Axes::None) return kLeastOdds;
  double shift_px = 0;
  if (relief_per_m > 0)
    shift_px = relief_shift_px(*evidence.frame().camera, between(0, static_cast<std::size_t>(measured.gap)),
                               seen.px, relief_per_m);
  MovingOddsInput in = odds_in_image(measured, miss, shift_px);
  in.depth_axis = measured.in_space();
  if (in.depth_axis) in.sigma_depth_m = noise(1).depth_noise.sigma_m(static_cast<double>(seen.depth_m));
  in.px_per_m = static_cast<double>(miss.px_per_m);
  in.elapsed_s = elapsed_s(static_cast<std::size_t>(measured.gap));
  return std::clamp(static_cast<float>(odds(in)), kLeastOdds, kMostOdds);
}

inline MovingOddsInput BackgroundMotionFilter::odds_in_image(const Measured& measured, const StaticMiss& miss,
                                                             double shift_px) const {
  MovingOddsInput in;
  in.chi2 = static_cast<double>(miss.chi2);
  in.image_axes = miss.axes == StaticMiss::Axes::Line ? 1 : 2;
  const double miss2_px2 = static_cast<double>(miss.image_px * miss.image_px);
  const double sigma2_px2 = sigma_px(measured.gap) * sigma_px(measured.gap), shift2_px2 = shift_px * shift_px;
  double across2_px2 = sigma2_px2 * measured.spread.across, along2_px2 = sigma2_px2 * measured.spread.along;
  if (in.image_axes == 1 && in.chi2 > 0)
    across2_px2 = along2_px2 = miss2_px2 / in.chi2;  // the miss's own axis
  in.chi2 *= across2_px2 / (across2_px2 + shift2_px2);
  in.sigma_px = std::sqrt(across2_px2 + shift2_px2);
  in.along = (along2_px2 + shift2_px2) / (across2_px2 + shift2_px2);
  const double along_px = static_cast<double>(miss.miss_px.dot(measured.spread.edge));
  in.along2_px2 = along_px * along_px;
  in.across2_px2 = std::max(0.0, miss2_px2 - in.along2_px2);
  return in;
}

inline void BackgroundMotionFilter::open_views(const Evidence& evidence) {
  views_.clear();
  const std::size_t oldest = std::min(unbroken_, camera_poses_.size() - 1);
  if (oldest > 0) open_view(evidence, 1);
  if (oldest > 1) open_view(evidence, oldest);
}

inline void BackgroundMotionFilter::open_view(const Evidence& evidence, std::size_t gap) {
  const PastFrame* frame = evidence.kept_frame(frame_ids_[gap]);
  if (frame == nullptr) return;
  FreeSpaceView::Model model;
  model.moving_share = Params::kMovingShare;
  model.sigma_px = sigma_px(static_cast<int>(gap));
  model.depth_noise = noise(model.sigma_px).depth_noise;
  views_.emplace_back(*evidence.frame().camera, frame->depth, frame->depth_unit_m, between(gap, 0), model);
}

inline float BackgroundMotionFilter::space_odds(const cv::Point3f& point_m) const {
  double most = 0;
  for (const FreeSpaceView& view : views_) most = std::max(most, view.odds(point_m));
  return std::min(static_cast<float>(most), kMostOdds);
}

inline void BackgroundMotionFilter::add_neighbours(const Evidence& evidence) {
  places_.lay_out(
      evidence_, [&](std::size_t i) { return own_[i]; },
      [&](std::size_t i) { return seen_[i] != 0 ? 1.0F : 0.0F; });
  for (std::size_t i = 0; i < evidence.size(); ++i) belief_[i] = own_[i] + mean_around(evidence, i);
}

inline float BackgroundMotionFilter::mean_around(const Evidence& evidence, std::size_t i) const {
  const cv::Point2f& px = evidence.pixels()[i];
  const float depth_m = evidence.depths_m()[i];
  // Its neighbours hide it from the right camera, so it lies on what is behind them.
  if (std::isnan(depth_m) && !evidence.frame().right_grey.empty()) return 0;
  const float unseen = std::isnan(depth_m) ? kBlindReach : kUnseenReach;
  const float reach = static_cast<float>(params_.neighbour_px) * (seen_[i] != 0 ? 1 : unseen);
  NeighbourPlaces::Sum sum =
      places_.around(evidence_, px, depth_m, reach, reach_m(params_.neighbour_m, depth_m));
  if (seen_[i] != 0 && PointGrid::usable(px)) sum.values -= own_[i], sum.weights -= 1;  // itself
  const float trust = std::isnan(depth_m) ? kBlindTrust : 1.0F;
  return trust * sum.values / (trust * sum.weights + kOwnWeight);
}

inline void BackgroundMotionFilter::find_cores(const Evidence& evidence) {
  places_.lay_out(
      moving_, [&](std::size_t i) { return own_[i] > 0 ? 1.0F : 0.0F; },
      [&](std::size_t i) { return seen_[i] != 0 ? 1.0F : 0.0F; });
  is_core_.assign(evidence.size(), 0);
  for (std::size_t i = 0; i < evidence.size(); ++i)
    is_core_[i] = seen_[i] != 0 && belief_[i] > 0 && supported(evidence, i) ? 1 : 0;
  places_.lay_out(
      cores_, [](std::size_t) { return 1.0F; },
      [&](std::size_t i) { return static_cast<float>(is_core_[i]); });
}

inline bool BackgroundMotionFilter::supported(const Evidence& evidence, std::size_t i) const {
  const NeighbourPlaces::Sum sum =
      places_.around(moving_, evidence.pixels()[i], evidence.depths_m()[i], kSupportReach_px,
                     reach_m(kSupportReach_m, evidence.depths_m()[i]), kOnePatch_px);
  return sum.values >= kMinSupport && sum.values >= kMinSupportShare * sum.weights;
}

inline void BackgroundMotionFilter::cast(const Evidence& evidence, std::size_t i, Votes& votes) const {
  const float limit = seen_[i] != 0 ? rest_log_odds_ : limit_without_evidence(evidence, i);
  if (!(belief_[i] > limit)) return votes.cast(i, seen_[i] != 0 ? Vote::Static : Vote::Unknown, score(i));
  const bool supported =
      rejects_ && (evidence.prior(i) || near_core(evidence, i) || forecast(evidence, i) > 0);
  votes.cast(i, supported ? Vote::Dynamic : Vote::Unknown, score(i));
}

inline void BackgroundMotionFilter::set_rest_log_odds() {
  double moving = 0, all = 0;
  for (std::size_t i = 0; i < belief_.size(); ++i)
    if (seen_[i] != 0) moving += belief_[i] > 0 ? 1 : 0, all += 1;
  const double share = std::clamp(all > 0 ? moving / all : 0.0, Params::kMovingShare, 0.5);
  rest_log_odds_ = static_cast<float>(portable::log((1 - share) / share));
}

inline float BackgroundMotionFilter::limit_without_evidence(const Evidence& evidence, std::size_t i) const {
  const bool blind = std::isnan(evidence.depths_m()[i]);
  if (!evidence.prior(i))
    return blind ? kBlindLimit + (judges_directions_ ? 0 : rest_log_odds_) : kUnseenLimit;
  return blind ? kUnseenLimit : kSuspectLimit;
}

}  // namespace dynfilter
