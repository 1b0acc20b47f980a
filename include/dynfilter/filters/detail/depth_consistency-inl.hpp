// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/depth_consistency.hpp>

#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <opencv2/core.hpp>
#include <optional>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<DepthConsistencyParams>& DepthConsistencyParams::fields() {
  using P = DepthConsistencyParams;
  static const FieldTable<P> table{
      choice("against", &P::against,
             {{"frame", DepthReference::Frame},
              {"keyframe", DepthReference::Keyframe},
              {"covisible", DepthReference::Covisible}},
             "view that predicts the depth: the frame gap_frames back, the last keyframe, or the host's "
             "covisible keyframes"),
      integer("gap_frames", &P::gap_frames, "frames", {1, 30}, "number of frames back, for against frame"),
      choice("prediction", &P::prediction,
             {{"match", DepthPrediction::Match},
              {"view", DepthPrediction::View},
              {"both", DepthPrediction::Both}},
             "match moves the feature's reference point, view reads the reference depth at its position, "
             "both combines them"),
      choice("form", &P::form, {{"relative", DepthForm::Relative}, {"metric", DepthForm::Metric}},
             "relative tests against max_deviation like DeS-SLAM, metric against max_difference_m like "
             "DynaSLAM"),
      real("max_deviation", &P::max_deviation, "", {0, 10},
           "largest relative deviation of a static feature (DeS-SLAM: 0.12, at keyframes 0.08)"),
      real("max_difference_m", &P::max_difference_m, "m", {0, 100},
           "largest depth difference of a static feature (DynaSLAM: 0.4, 0.6 in its code)"),
      motion_source("motion", &P::motion),
  };
  return table;
}

DYNFILTER_INLINE Needs DepthConsistencyFilter::needs() const {
  const Input always = Input::Depth | Input::Camera;
  if (params_.against == DepthReference::Covisible)
    return {always | Input::Keyframes | Input::Pose, Input::MapPoints, 0};
  return {always | Input::Correspondence, Input::Pose, params_.gap_frames};
}

DYNFILTER_INLINE void DepthConsistencyFilter::apply(const Evidence& evidence, Votes& votes) {
  if (params_.against == DepthReference::Covisible) return judge_by_keyframes(evidence, votes);
  const Match& match = evidence.match({params_.against == DepthReference::Keyframe, params_.gap_frames});
  if (match.reference == nullptr) return votes.note("no earlier frame");
  const std::optional<RigidMotion> motion = camera_motion(evidence, match, params_.motion, votes, seeds_);
  if (motion) judge_by_frame(evidence, match, motion->T_current_reference, votes);
}

inline void DepthConsistencyFilter::Opinion::add(Vote vote, double deviation, double limit) {
  if (vote == Vote::Unknown) return;
  dynamic = dynamic || vote == Vote::Dynamic;
  fixed = fixed || vote == Vote::Static;
  suspicion = std::max(suspicion, dynfilter::suspicion(std::abs(deviation), limit));
}

DYNFILTER_INLINE double DepthConsistencyFilter::deviation(double predicted_m, double measured_m,
                                                          double of_m) const {
  const double difference_m = predicted_m - measured_m;
  return params_.form == DepthForm::Relative ? difference_m / of_m : difference_m;
}

inline bool DepthConsistencyFilter::judgeable(const Evidence& evidence, std::size_t i) const {
  const float z = evidence.points_m()[i].z;
  return evidence.judged(i) && valid_depth(z) && static_cast<double>(z) <= Params::kMaxDepth_m;
}

inline void DepthConsistencyFilter::judge_by_frame(const Evidence& evidence, const Match& match,
                                                   const Pose& T_current_reference, Votes& votes) {
  const Eigen::Matrix3d R = T_current_reference.R();
  const Eigen::Vector3d t = T_current_reference.t();
  if (by_view()) view_.from(*match.reference);
  if (by_match()) here_.from(*evidence.kept_frame(evidence.frame().id));
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!judgeable(evidence, i)) continue;
    const cv::Point3f& p = evidence.points_m()[i];
    const Eigen::Vector3d now(p.x, p.y, p.z);
    Opinion opinion;
    if (by_match() && match.found(i) && match.has_reference_point(i)) {
      const cv::Point3f& then = match.reference_points_m[i];
      add_match(p, (R * Eigen::Vector3d(then.x, then.y, then.z)).z() + t.z(), opinion);
    }
    if (by_view() && parallax_fits(now, t)) add_view(R.transpose() * (now - t), opinion);
    if (opinion.vote() != Vote::Unknown) votes.cast(i, opinion.vote(), opinion.suspicion);
  }
  view_.forget_image();
  here_.forget_image();
}

inline void DepthConsistencyFilter::add_match(const cv::Point3f& now, double predicted_m,
                                              Opinion& opinion) const {
  const double measured_m = static_cast<double>(now.z);
  if (!(predicted_m > 0)) return;
  const double off = deviation(predicted_m, measured_m, measured_m);
  if (std::abs(off) <= limit()) return opinion.add(Vote::Static, off, limit());
  if (!beside_edge(now, predicted_m)) opinion.add(Vote::Dynamic, off, limit());
}

inline bool DepthConsistencyFilter::beside_edge(const cv::Point3f& now, double predicted_m) const {
  if (!here_.has_image()) return false;
  double smallest = 0;
  return here_.look(
             now, Params::kPatch_px, limit(),
             [&](double z_m) { return deviation(z_m, predicted_m, predicted_m); },
             smallest) == SeenThere::Surface;
}

inline void DepthConsistencyFilter::add_view(const Eigen::Vector3d& point_m, Opinion& opinion) const {
  const cv::Point3f there = to_point(point_m);
  double off = 0;
  const SeenThere seen = view_.look(
      there, Params::kPatch_px, limit(), [&](double z_m) { return deviation(z_m, point_m.z(), point_m.z()); },
      off);
  if (seen == SeenThere::Surface) opinion.add(Vote::Static, off, limit());
  if (seen == SeenThere::Beyond) opinion.add(Vote::Dynamic, off, limit());
}

inline bool DepthConsistencyFilter::parallax_fits(const Eigen::Vector3d& point_m,
                                                  const Eigen::Vector3d& centre_m) const {
  constexpr double kDegree = 3.14159265358979323846 / 180;
  const Eigen::Vector3d from_there = point_m - centre_m;
  const double cosine = point_m.dot(from_there) / (point_m.norm() * from_there.norm());
  return cosine >= portable::cos(Params::kMaxParallax_deg * kDegree);
}

inline void DepthConsistencyFilter::judge_by_keyframes(const Evidence& evidence, Votes& votes) {
  tallies_.assign(evidence.size(), Tally());
  const Span<const KeyframeView> keyframes = evidence.frame().covisible_keyframes;
  for (const KeyframeView& keyframe : keyframes) judge_by_keyframe(evidence, keyframe);
  votes.note(keyframes.size(), " keyframes");
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const Tally& tally = tallies_[i];
    if (tally.dynamic == tally.fixed) continue;  // no view decides, or they contradict each other
    votes.cast(i, tally.dynamic > tally.fixed ? Vote::Dynamic : Vote::Static, tally.suspicion);
  }
}

inline void DepthConsistencyFilter::judge_by_keyframe(const Evidence& evidence,
                                                      const KeyframeView& keyframe) {
  const Pose T_keyframe_world = inverse(keyframe.T_world_camera);
  const Pose T_keyframe_current = T_keyframe_world * evidence.frame().T_world_camera;
  const Eigen::Matrix3d R = T_keyframe_current.R();
  const Eigen::Vector3d t = T_keyframe_current.t(), centre_m = inverse(T_keyframe_current).t();
  const bool use_matches = by_match() && learn_points(evidence, keyframe);
  if (by_view()) view_.from(keyframe, *evidence.frame().camera);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!judgeable(evidence, i)) continue;
    const cv::Point3f& p = evidence.points_m()[i];
    const Eigen::Vector3d now(p.x, p.y, p.z), there = R * now + t;
    if (!(there.z() > 0) || !parallax_fits(now, centre_m)) continue;
    Opinion opinion;
    if (use_matches && seen_by_keyframe(evidence.frame().map_point_ids[i]))
      add_map_point(T_keyframe_world, evidence.frame().map_points_world_m[i], there.z(), opinion);
    if (by_view()) add_view(there, opinion);
    tallies_[i].dynamic += opinion.vote() == Vote::Dynamic ? 1 : 0;
    tallies_[i].fixed += opinion.vote() == Vote::Static ? 1 : 0;
    tallies_[i].suspicion = std::max(tallies_[i].suspicion, opinion.suspicion);
  }
}

inline void DepthConsistencyFilter::add_map_point(const Pose& T_keyframe_world, const cv::Point3f& world_m,
                                                  double reprojected_m, Opinion& opinion) const {
  const double optimised_m = (T_keyframe_world.R() * Eigen::Vector3d(world_m.x, world_m.y, world_m.z)).z() +
                             T_keyframe_world.t().z();
  if (!(optimised_m > 0) || !std::isfinite(optimised_m)) return;
  const double off = deviation(optimised_m, reprojected_m, optimised_m);
  opinion.add(std::abs(off) > limit() ? Vote::Dynamic : Vote::Static, off, limit());
}

inline bool DepthConsistencyFilter::learn_points(const Evidence& evidence, const KeyframeView& keyframe) {
  const FrameView& frame = evidence.frame();
  keyframe_points_.assign(keyframe.map_point_ids.begin(), keyframe.map_point_ids.end());
  std::sort(keyframe_points_.begin(), keyframe_points_.end());
  return frame.map_point_ids.size() == frame.size() && frame.map_points_world_m.size() == frame.size();
}

}  // namespace dynfilter
