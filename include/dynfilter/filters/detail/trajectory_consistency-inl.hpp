// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/trajectory_consistency.hpp>

#include <Eigen/Core>
#include <cmath>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/rigid_residual.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<TrajectoryConsistencyParams>& TrajectoryConsistencyParams::fields() {
  using P = TrajectoryConsistencyParams;
  static const FieldTable<P> table{
      choice("mode", &P::mode,
             {{"rigid", TrajectoryMode::Rigid}, {"displacement", TrajectoryMode::Displacement}},
             "rigid compares with the position that the motion predicts; displacement compares lengths "
             "only, as published"),
      choice("threshold", &P::threshold,
             {{"noise", TrajectoryThreshold::Noise}, {"metric", TrajectoryThreshold::Metric}},
             "noise tests chi-square under the depth camera's noise; metric tests against alpha_m + beta * "
             "depth"),
      real("pixel_sigma_px", &P::pixel_sigma_px, "px", {0.01, 100},
           "threshold noise: standard deviation of a correspondence, per axis"),
      flag("measured_noise", &P::measured_noise,
           "threshold noise: raises both to what this frame's matches show, and refits the motion with "
           "them"),
      real("alpha_m", &P::alpha_m, "m", {0, 10}, "threshold metric: tolerance at depth 0"),
      real("beta", &P::beta, "m/m", {0, 10}, "threshold metric: growth of the tolerance per metre of depth"),
      real("max_displacement_m", &P::max_displacement_m, "m", {0, 100},
           "largest displacement that mode rigid judges, because larger ones are likely mismatches; 0: no "
           "limit"),
      integer("gap_frames", &P::gap_frames, "frames", {1, 30}, "number of frames back"),
      motion_source("motion", &P::motion),
  };
  return table;
}

DYNFILTER_INLINE void TrajectoryConsistencyFilter::apply(const Evidence& evidence, Votes& votes) {
  const Match& match = evidence.match({false, params_.gap_frames});
  if (match.reference == nullptr) return votes.note("no earlier frame");
  const std::optional<RigidMotion> motion = camera_motion(evidence, match, params_.motion, votes, seeds_);
  if (!motion) return;
  if (params_.mode == TrajectoryMode::Displacement)
    judge_displacement(evidence, match, *motion, votes);
  else
    judge_rigid(evidence, match, *motion, votes);
}

inline bool TrajectoryConsistencyFilter::judgeable(const Evidence& evidence, const Match& match,
                                                   std::size_t i) const {
  if (!evidence.judged(i) || !match.found(i) || !match.has_reference_point(i)) return false;
  const double z = static_cast<double>(evidence.points_m()[i].z);
  return z <= Params::kMaxDepth_m && static_cast<double>(match.reference_depth_m[i]) <= Params::kMaxDepth_m;
}

inline void TrajectoryConsistencyFilter::judge_displacement(const Evidence& evidence, const Match& match,
                                                            const RigidMotion& motion, Votes& votes) const {
  const double camera_m = motion.T_current_reference.t().norm();
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!judgeable(evidence, match, i)) continue;
    const cv::Point3f& now = evidence.points_m()[i];
    const double point_m = cv::norm(now - match.reference_points_m[i]);
    cast(votes, i, std::abs(point_m - camera_m), limit_m(match, now, i));
  }
}

inline void TrajectoryConsistencyFilter::judge_rigid(const Evidence& evidence, const Match& match,
                                                     const RigidMotion& motion, Votes& votes) {
  if (params_.threshold == TrajectoryThreshold::Metric) return judge_metric(evidence, match, motion, votes);
  if (params_.measured_noise) return judge_measured(evidence, match, motion, votes);
  judge_noise(evidence, match, motion, {params_.pixel_sigma_px, Params::kDepthSigmaFactor}, votes);
}

inline void TrajectoryConsistencyFilter::judge_noise(const Evidence& evidence, const Match& match,
                                                     const RigidMotion& motion, const Noise& sigma,
                                                     Votes& votes) const {
  RigidResidualNoise noise;
  noise.pixel_sigma_px = sigma.pixel_px;
  noise.depth_noise = depth_noise_of(evidence.frame()).scaled(sigma.depth_factor);
  const bool fitted = motion.inliers > 0;
  const RigidResidualModel residual(*evidence.frame().camera, motion.T_current_reference, noise,
                                    fitted ? motion.covariance.data() : nullptr);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!judgeable(evidence, match, i)) continue;
    const MatchSpread spread = params_.measured_noise ? match.correspondences.spread[i] : MatchSpread();
    const RigidResidual r = residual(match.reference_points_m[i], evidence.points_m()[i], spread);
    if (r.valid && possible(displacement_m(motion, match, evidence, i)))
      cast(votes, i, static_cast<double>(r.chi2), Params::kMaxChi2);
  }
}

inline void TrajectoryConsistencyFilter::judge_measured(const Evidence& evidence, const Match& match,
                                                        RigidMotion motion, Votes& votes) {
  if (evidence.count_judged() == 0) return;
  collect_measured(evidence, match, motion);
  std::optional<Noise> noise = measure(evidence, match, motion);
  for (int k = 0; k < kRefits && noise && motion.inliers > 0; ++k) {
    fit_under(*noise, evidence, match, motion);
    noise = measure(evidence, match, motion);
  }
  if (!noise) votes.note("noise: not measured, too few neighbours");
  Noise used = noise.value_or(Noise{0, 0});
  used.pixel_px = std::max(used.pixel_px, params_.pixel_sigma_px);
  used.depth_factor = std::max(used.depth_factor, Params::kDepthSigmaFactor);
  judge_noise(evidence, match, motion, used, votes);
}

inline void TrajectoryConsistencyFilter::collect_measured(const Evidence& evidence, const Match& match,
                                                          const RigidMotion& motion) {
  if (motion.inliers == 0) evidence.collect_seeds(match, false, seeds_);  // the host's
  const auto flat = [&](int seed) {
    const auto i = static_cast<std::size_t>(seed);
    return !valid_depth(match.reference_points_m[i].z) || !valid_depth(evidence.points_m()[i].z);
  };
  seeds_.erase(std::remove_if(seeds_.begin(), seeds_.end(), flat), seeds_.end());
}

inline std::optional<TrajectoryConsistencyFilter::Noise> TrajectoryConsistencyFilter::measure(
    const Evidence& evidence, const Match& match, const RigidMotion& motion) {
  misses_.measure(
      *evidence.frame().camera, motion.T_current_reference,
      {match.reference_points_m, evidence.points_m(), evidence.pixels(), depth_noise_of(evidence.frame())},
      seeds_);
  const std::optional<double> pixel_px = neighbour_noise_.whole_scale(misses_.misses(), kNeighbours_px);
  if (!pixel_px) return std::nullopt;
  return Noise{*pixel_px, misses_.depth_factor()};
}

inline void TrajectoryConsistencyFilter::fit_under(const Noise& noise, const Evidence& evidence,
                                                   const Match& match, RigidMotion& motion) {
  RigidMotionOptions& options = refit_.options();
  options.pixel_sigma_px = std::max(noise.pixel_px, RigidMotionOptions().pixel_sigma_px);
  options.depth_noise = depth_noise_of(evidence.frame()).scaled(noise.depth_factor);
  const RigidMotion finer = refit_.refine(*evidence.frame().camera, match.reference_points_m,
                                          evidence.points_m(), seeds_, motion.T_current_reference);
  if (finer.ok) motion = finer;
}

inline void TrajectoryConsistencyFilter::judge_metric(const Evidence& evidence, const Match& match,
                                                      const RigidMotion& motion, Votes& votes) const {
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!judgeable(evidence, match, i)) continue;
    const double moved_m = displacement_m(motion, match, evidence, i);
    if (possible(moved_m)) cast(votes, i, moved_m, limit_m(match, evidence.points_m()[i], i));
  }
}

inline double TrajectoryConsistencyFilter::displacement_m(const RigidMotion& motion, const Match& match,
                                                          const Evidence& evidence, std::size_t i) {
  const Pose& T = motion.T_current_reference;
  const cv::Point3f &then = match.reference_points_m[i], &now = evidence.points_m()[i];
  Eigen::Vector3d miss = T.R() * Eigen::Vector3d(then.x, then.y, then.z) + T.t();
  miss -= Eigen::Vector3d(now.x, now.y, now.z);
  return miss.norm();
}

}  // namespace dynfilter
