// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/context/context.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/filters/camera_motion.hpp>
#include <dynfilter/filters/depth_view.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

enum class DepthReference {
  Frame,     ///< gap_frames back
  Keyframe,  ///< the last keyframe
  Covisible  ///< FrameView::covisible_keyframes
};
enum class DepthPrediction {
  Match,  ///< of the feature's own point in the reference
  View,   ///< of what the reference saw where the feature would have been
  Both
};
enum class DepthForm {
  Relative,  ///< a share of the depth (DeS-SLAM)
  Metric     ///< metres (DynaSLAM)
};

struct DepthConsistencyParams {
  DepthReference against = DepthReference::Frame;
  int gap_frames = 1;
  DepthPrediction prediction = DepthPrediction::Both;
  DepthForm form = DepthForm::Relative;
  double max_deviation = 0.12;
  double max_difference_m = 0.4;
  double max_parallax_deg = 30;
  int patch_px = 3;
  double max_depth_m = 6.0;
  MotionSource motion = MotionSource::Seeds;

  static const FieldTable<DepthConsistencyParams>& fields() {
    using P = DepthConsistencyParams;
    static const FieldTable<P> table{
        choice(
            "against", &P::against,
            {{"frame", DepthReference::Frame},
             {"keyframe", DepthReference::Keyframe},
             {"covisible", DepthReference::Covisible}},
            "frame: gap_frames back; keyframe: the last one; covisible: the keyframes that the host names"),
        integer("gap_frames", &P::gap_frames, "frames", {1, 30}, "against frame: compare with so many back"),
        choice("prediction", &P::prediction,
               {{"match", DepthPrediction::Match},
                {"view", DepthPrediction::View},
                {"both", DepthPrediction::Both}},
               "match: the feature's own point there, moved; view: what was seen there at its place"),
        choice("form", &P::form, {{"relative", DepthForm::Relative}, {"metric", DepthForm::Metric}},
               "relative: max_deviation (DeS-SLAM); metric: max_difference_m (DynaSLAM)"),
        real("max_deviation", &P::max_deviation, "", {0, 10},
             "form relative: dynamic beyond (DeS-SLAM: 0.12, at keyframes 0.08)"),
        real("max_difference_m", &P::max_difference_m, "m", {0, 100},
             "form metric: dynamic beyond (DynaSLAM: 0.4, 0.6 in its code)"),
        real("max_parallax_deg", &P::max_parallax_deg, "deg", {0, 180},
             "views whose rays to the point differ by more say nothing (DynaSLAM: 30)"),
        integer("patch_px", &P::patch_px, "px", {0, 50},
                "the depths so far around a place are looked at, to tell edges from motion; 0: one pixel"),
        real("max_depth_m", &P::max_depth_m, "m", {0.1, 1000}, "farther features are not judged"),
        motion_source("motion", &P::motion),
    };
    return table;
  }
};

/// Features whose depth is not what an earlier view of a static scene predicts (DeS-SLAM sec. 3.2, eq. 1-6;
/// DynaSLAM sec. III-C).
///
/// Formula:  form relative |1 - d_proj / z| > max_deviation, at keyframes |z_r - d_r| / z_r; form metric
///           d_proj - z > max_difference_m. prediction match: d_proj is the feature's own point of the
///           reference, moved by the camera's motion. prediction view: the feature is moved into the
///           reference, d_proj is the depth that was seen there; only farther depths tell of motion, nearer
///           ones hide the place.
/// Needs:    depth, camera; correspondences (for match, and to fit the motion), or covisible keyframes and
///           poses.
/// Abstains: without depth, beyond max_depth_m, on silhouettes, where the place was hidden or out of view,
/// and
///           without a motion.
/// Blind to: prediction match: motion across the line of sight. prediction view: motion inside the outline of
///           a large mover. Both: motion below the threshold, 0.36 m at 3 m with 12 %.
/// State:    none of its own. Cost: about 0.1 ms for 1000 features, motion included, flow not.
class DepthConsistencyFilter final : public Filter {
 public:
  using Params = DepthConsistencyParams;
  static constexpr const char* kName = "depth_consistency";
  static constexpr const char* kSummary = "features at another depth than an earlier view predicts";

  explicit DepthConsistencyFilter(Params params = Params()) : params_(params) {
    check_parameters(params_, kName);
  }

  std::string name() const override { return kName; }
  Needs needs() const override {
    const Input always = Input::Depth | Input::Camera;
    if (params_.against == DepthReference::Covisible)
      return {always | Input::Keyframes | Input::Pose, Input::MapPoints, 0};
    return {always | Input::Correspondence, Input::Pose, params_.gap_frames};
  }

  void apply(Context& context, Votes& votes) override {
    if (params_.against == DepthReference::Covisible) return judge_by_keyframes(context, votes);
    const Match& match = context.match({params_.against == DepthReference::Keyframe, params_.gap_frames});
    if (match.reference == nullptr) return context.note("no earlier frame");
    const std::optional<RigidMotion> motion = camera_motion(context, match, params_.motion, seeds_);
    if (motion) judge_by_frame(context, match, motion->T_current_reference, votes);
  }

 private:
  /// What one view says of one feature.
  struct Opinion {
    bool dynamic = false, fixed = false;
    float score = 0;

    void add(Vote vote, double deviation, double limit) {
      if (vote == Vote::Unknown) return;
      dynamic = dynamic || vote == Vote::Dynamic;
      fixed = fixed || vote == Vote::Static;
      score = std::max(score, suspicion(std::abs(deviation), limit));
    }
    Vote vote() const { return dynamic ? Vote::Dynamic : fixed ? Vote::Static : Vote::Unknown; }
  };
  /// Votes of several views.
  struct Tally {
    int dynamic = 0, fixed = 0;
    float score = 0;
  };

  bool by_match() const { return params_.prediction != DepthPrediction::View; }
  bool by_view() const { return params_.prediction != DepthPrediction::Match; }
  double limit() const {
    return params_.form == DepthForm::Relative ? params_.max_deviation : params_.max_difference_m;
  }
  /// How much farther the predicted depth is than the measured one; `of`: what a share is a share of.
  double deviation(double predicted_m, double measured_m, double of_m) const {
    const double difference_m = predicted_m - measured_m;
    return params_.form == DepthForm::Relative ? difference_m / of_m : difference_m;
  }
  bool judgeable(Context& context, std::size_t i) const {
    const float z = context.points_m()[i].z;
    return context.judged(i) && valid_depth(z) && static_cast<double>(z) <= params_.max_depth_m;
  }

  // ---- against one earlier frame
  void judge_by_frame(Context& context, const Match& match, const Pose& T_current_reference, Votes& votes) {
    const Eigen::Matrix3d R = T_current_reference.R();
    const Eigen::Vector3d t = T_current_reference.t();
    if (by_view()) view_.from(*match.reference);
    if (by_match()) here_.from(*context.history().find(context.frame().id));
    for (std::size_t i = 0; i < context.size(); ++i) {
      if (!judgeable(context, i)) continue;
      const cv::Point3f& p = context.points_m()[i];
      const Eigen::Vector3d now(p.x, p.y, p.z);
      Opinion opinion;
      if (by_match() && match.found(i) && match.has_depth(i)) {
        const cv::Point3f& then = match.reference_points_m[i];
        add_match(p, R.row(2).dot(Eigen::Vector3d(then.x, then.y, then.z)) + t.z(), opinion);
      }
      if (by_view() && parallax_fits(now, t)) add_view(R.transpose() * (now - t), opinion);
      if (opinion.vote() != Vote::Unknown) votes.cast(i, opinion.vote(), opinion.score);
    }
  }

  /// Another depth than predicted is motion, unless the predicted surface is right beside: then the match
  /// slid over an edge.
  void add_match(const cv::Point3f& now, double predicted_m, Opinion& opinion) const {
    const double measured_m = static_cast<double>(now.z);
    if (!(predicted_m > 0)) return;
    const double off = deviation(predicted_m, measured_m, measured_m);
    if (std::abs(off) <= limit()) return opinion.add(Vote::Static, off, limit());
    if (!beside_edge(now, predicted_m)) opinion.add(Vote::Dynamic, off, limit());
  }
  bool beside_edge(const cv::Point3f& now, double predicted_m) const {
    if (params_.patch_px == 0 || !here_.has_image()) return false;
    double smallest = 0;
    return here_.look(
               now, params_.patch_px, limit(),
               [&](double z_m) { return deviation(z_m, predicted_m, predicted_m); },
               smallest) == SeenThere::Surface;
  }

  void add_view(const Eigen::Vector3d& point_m, Opinion& opinion) const {
    const cv::Point3f there(static_cast<float>(point_m.x()), static_cast<float>(point_m.y()),
                            static_cast<float>(point_m.z()));
    double off = 0;
    const SeenThere seen = view_.look(
        there, params_.patch_px, limit(),
        [&](double z_m) { return deviation(z_m, point_m.z(), point_m.z()); }, off);
    if (seen == SeenThere::Surface) opinion.add(Vote::Static, off, limit());
    if (seen == SeenThere::Beyond) opinion.add(Vote::Dynamic, off, limit());
  }

  /// Between the rays to a point from here and from a camera whose centre is at `centre_m`.
  bool parallax_fits(const Eigen::Vector3d& point_m, const Eigen::Vector3d& centre_m) const {
    constexpr double kDegree = 3.14159265358979323846 / 180;
    const Eigen::Vector3d from_there = point_m - centre_m;
    const double cosine = point_m.dot(from_there) / (point_m.norm() * from_there.norm());
    return cosine >= std::cos(params_.max_parallax_deg * kDegree);
  }

  // ---- against the covisible keyframes
  void judge_by_keyframes(Context& context, Votes& votes) {
    tallies_.assign(context.size(), Tally());
    int used = 0;
    for (const KeyframeView& keyframe : context.frame().covisible_keyframes) {
      if (!is_rigid(keyframe.T_world_camera)) {
        context.note("a keyframe's pose is not rigid");
        continue;
      }
      ++used;
      judge_by_keyframe(context, keyframe);
    }
    context.note(std::to_string(used) + " keyframes");
    for (std::size_t i = 0; i < context.size(); ++i) {
      const Tally& tally = tallies_[i];
      if (tally.dynamic == tally.fixed) continue;  // none can tell, or they contradict each other
      votes.cast(i, tally.dynamic > tally.fixed ? Vote::Dynamic : Vote::Static, tally.score);
    }
  }

  void judge_by_keyframe(Context& context, const KeyframeView& keyframe) {
    const Pose T_keyframe_world = inverse(keyframe.T_world_camera);
    const Pose T_keyframe_current = T_keyframe_world * context.frame().T_world_camera;
    const Eigen::Matrix3d R = T_keyframe_current.R();
    const Eigen::Vector3d t = T_keyframe_current.t(), centre_m = -(R.transpose() * t);
    const bool use_matches = by_match() && learn_points(context, keyframe);
    if (by_view()) view_.from(keyframe, *context.frame().camera);
    for (std::size_t i = 0; i < context.size(); ++i) {
      if (!judgeable(context, i)) continue;
      const cv::Point3f& p = context.points_m()[i];
      const Eigen::Vector3d now(p.x, p.y, p.z), there = R * now + t;
      if (!(there.z() > 0) || !parallax_fits(now, centre_m)) continue;
      Opinion opinion;
      if (use_matches && seen_by_keyframe(context.frame().map_point_ids[i]))
        add_map_point(T_keyframe_world, context.frame().map_points_world_m[i], there.z(), opinion);
      if (by_view()) add_view(there, opinion);
      tallies_[i].dynamic += opinion.vote() == Vote::Dynamic ? 1 : 0;
      tallies_[i].fixed += opinion.vote() == Vote::Static ? 1 : 0;
      tallies_[i].score = std::max(tallies_[i].score, opinion.score);
    }
  }

  /// Equation 5: z_r is the map point's depth in the keyframe, d_r that of the feature's point reprojected.
  void add_map_point(const Pose& T_keyframe_world, const cv::Point3f& world_m, double reprojected_m,
                     Opinion& opinion) const {
    const double optimised_m =
        T_keyframe_world.R().row(2).dot(Eigen::Vector3d(world_m.x, world_m.y, world_m.z)) +
        T_keyframe_world.t().z();
    if (!(optimised_m > 0) || !std::isfinite(optimised_m)) return;
    const double off = deviation(optimised_m, reprojected_m, optimised_m);
    opinion.add(std::abs(off) > limit() ? Vote::Dynamic : Vote::Static, off, limit());
  }

  bool learn_points(const Context& context, const KeyframeView& keyframe) {
    const FrameView& frame = context.frame();
    keyframe_points_.assign(keyframe.map_point_ids.begin(), keyframe.map_point_ids.end());
    std::sort(keyframe_points_.begin(), keyframe_points_.end());
    return frame.map_point_ids.size() == frame.size() && frame.map_points_world_m.size() == frame.size();
  }
  bool seen_by_keyframe(std::int64_t map_point_id) const {
    return map_point_id >= 0 &&
           std::binary_search(keyframe_points_.begin(), keyframe_points_.end(), map_point_id);
  }

  Params params_;
  std::vector<int> seeds_;
  DepthView view_, here_;
  std::vector<Tally> tallies_;
  std::vector<std::int64_t> keyframe_points_;
};

}  // namespace dynfilter
