// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <dynfilter/context/context.hpp>
#include <dynfilter/context/feature_tracks.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/filters/neighbour_field.hpp>
#include <dynfilter/geometry/rigid_background.hpp>
#include <dynfilter/geometry/rigid_residual.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

struct BackgroundMotionParams {
  double max_chi2 = 30.0;
  double depth_sigma_factor = 2.0;
  double memory = 0.4;
  double mobility_memory = 0.95;
  double neighbour_px = 25;
  double neighbour_m = 0.12;
  double neighbour_weight = 1.0;
  double prior_suspicion = 0.05;

  static const FieldTable<BackgroundMotionParams>& fields() {
    using P = BackgroundMotionParams;
    static const FieldTable<P> table{
        real("max_chi2", &P::max_chi2, "", {0.1, 1e6},
             "a miss beyond this speaks for motion; 3 degrees of freedom, noise as measured in the sequence"),
        real("depth_sigma_factor", &P::depth_sigma_factor, "", {0.01, 100},
             "the depth camera's noise against the model's"),
        real("memory", &P::memory, "", {0, 0.99}, "share of a track's belief that the next frame takes over"),
        real("mobility_memory", &P::mobility_memory, "", {0, 0.999},
             "share of having moved that a feature keeps per frame: who stands still for a while is not yet "
             "background"),
        real("neighbour_px", &P::neighbour_px, "px", {1, 1000}, "features this near are asked too ..."),
        real("neighbour_m", &P::neighbour_m, "m", {0, 10}, "... if their depth differs by no more than this"),
        real("neighbour_weight", &P::neighbour_weight, "", {0, 10}, "their mean evidence against one's own"),
        real("prior_suspicion", &P::prior_suspicion, "", {0, 10},
             "evidence for motion that being a prior suspect counts as; 1: a miss of twice max_chi2"),
    };
    return table;
  }
};

/// Features that do not follow the background. The default rejector: needs no detector.
///
/// Formula:  the background's motion is chosen among several (geometry/rigid_background.hpp); prior suspects
///           take part once it is known what the camera does. Against it a feature's evidence is
///           chi2 / max_chi2 - 1, at most 3, of the larger of two misses in (u, v, depth): since the last
///           frame and over its track (context/feature_tracks.hpp), up to 6 frames back, where slow motion
///           shows. Noise is measured: about the median miss of each gap, over features that did not move
///           lately. Belief = evidence + memory * belief in the last frame, within [-2, 5]; plus
///           neighbour_weight * its mean over neighbours at a like depth; plus prior_suspicion for prior
///           suspects. Dynamic above 0. Features that moved lately (1 - exp(-2 belief), fading by
///           mobility_memory a frame, taken over by features that appear beside them) count less when the
///           background is chosen, and the expected motion is refined without them.
/// Needs:    depth, camera, correspondences. Optional: the host's poses (a proposal more).
/// Abstains: on the first frame, without any motion, and on features that have neither evidence nor
///           neighbours with some (suspects with a depth are dynamic then).
/// Blind to: motion within the noise over 6 frames; everything, when a mover is taken for the background: the
///           report says what was chosen among what.
/// State:    the camera's last motions, noise per gap, belief and mobility per track. Cost: about 0.4 ms for
///           1000 features.
class BackgroundMotionFilter final : public Filter {
 public:
  using Params = BackgroundMotionParams;
  static constexpr const char* kName = "background_motion";
  static constexpr const char* kSummary =
      "features that do not follow the background, whoever has the majority";

  explicit BackgroundMotionFilter(Params params = Params()) : params_(params) {
    check_parameters(params_, kName);
    reset();
  }

  std::string name() const override { return kName; }
  Needs needs() const override {
    return {Input::Depth | Input::Camera | Input::Correspondence, Input::Pose, 1};
  }
  void reset() override {
    trail_.clear();
    tracks_.reset();
    belief_.clear();
    mobility_.clear();
    moved_.clear();
    estimator_.reset();
    noise_px_.fill(kFirstNoise_px);
  }

  void apply(Context& context, Votes& votes) override {
    const Match& match = context.match({});
    tracks_.follow(context.frame().id, match, context.pixels(), context.undistorted_pixels(),
                   context.depths_m());
    recall(context, match);
    judge(context, match, votes);
    remember_mobility(context);
  }

 private:
  static constexpr int kFrames = 6;  ///< that a track goes back
  static constexpr double kFirstNoise_px = 0.5, kLeastNoise_px = 0.05, kMostNoise_px = 1.0;
  static constexpr float kLeastBelief = -2, kMostBelief = 5;
  static constexpr float kUnseenReach = 1.5F;    ///< features without evidence ask farther away ...
  static constexpr float kUnseenDoubt = 0.3F;    ///< ... and need more of it
  static constexpr float kMobilityReach = 1.2F;  ///< features that appear take mobility from as far
  static constexpr int kMinSeeds = 30;

  void judge(Context& context, const Match& match, Votes& votes) {
    if (match.reference == nullptr) return context.note("no earlier frame");
    if (!follow_background(context, match)) return;
    weigh_misses(context, match);
    ask_neighbours(context);
    for (std::size_t i = 0; i < context.size(); ++i)
      if (context.judged(i)) cast(context, i, votes);
  }

  // ---- what is known from earlier frames
  void recall(Context& context, const Match& match) {
    std::swap(last_belief_, belief_);
    std::swap(last_mobility_, mobility_);
    const std::size_t n = tracks_.size();
    remembered_.assign(n, 0);
    mobility_.resize(n);
    static_belief_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const auto from = static_cast<std::size_t>(tracks_.previous(i));
      const bool known = tracks_.previous(i) >= 0 && from < last_belief_.size();
      if (known) remembered_[i] = last_belief_[from];
      mobility_[i] = known ? last_mobility_[from] : mobility_around(context, match, i);
      const float still = 1 - mobility_[i];
      static_belief_[i] = still * still / (1 + std::exp(remembered_[i]));
    }
    belief_.assign(n, 0);
  }

  /// A feature without a past takes that of the features around the place where it was.
  float mobility_around(Context& context, const Match& match, std::size_t i) const {
    const bool found = match.reference != nullptr && match.found(i);
    const NeighbourField::Sum sum = moved_.around(
        found ? match.correspondences.reference_px[i] : context.pixels()[i],
        found && match.has_depth(i) ? match.reference_points_m[i].z : context.depths_m()[i],
        kMobilityReach * static_cast<float>(params_.neighbour_px), static_cast<float>(params_.neighbour_m));
    return sum.weights > 0 ? sum.values / sum.weights : 0;
  }

  void remember_mobility(Context& context) {
    moved_.clear();
    for (std::size_t i = 0; i < context.size(); ++i) {
      const float now = belief_[i] > 0 ? 1 - std::exp(-2 * belief_[i]) : 0.0F;
      mobility_[i] = std::max(static_cast<float>(params_.mobility_memory) * mobility_[i], now);
      moved_.add(context.pixels()[i], context.depths_m()[i], mobility_[i]);
    }
    moved_.build(static_cast<float>(params_.neighbour_px));
  }

  // ---- the background's motion
  bool follow_background(Context& context, const Match& match) {
    RigidBackgroundScene scene;
    scene.camera = *context.frame().camera;
    scene.reference_m = match.reference_points_m;
    scene.current_m = context.points_m();
    scene.pixels = context.pixels();
    scene.static_belief = static_belief_;
    scene.mobility = mobility_;
    const bool known = trail_.size() >= 2;  // what the camera does: then suspects take part
    context.collect_seeds(match, known, seeds_);
    if (static_cast<int>(seeds_.size()) < kMinSeeds) context.collect_seeds(match, true, seeds_);
    scene.seeds = seeds_;
    scene.predicted = context.host_motion(match);
    if (known) scene.expected = usual_step();
    scene.noise_px = std::clamp(0.8 * noise_px_[1], kLeastNoise_px, 0.3);
    motion_ = estimator_.estimate(scene);
    note_motion(context);
    if (!motion_.ok) {
      trail_.clear();
      return false;
    }
    extend_trail();
    return true;
  }

  void note_motion(Context& context) const {
    if (!motion_.ok) return context.note("background: none of the motions explains enough");
    const MotionProposal& p = estimator_.proposals()[estimator_.chosen()];
    context.note("background: " + std::to_string(motion_.inliers) + " of " +
                 std::to_string(estimator_.points()) + " points, motion " +
                 (p.from == MotionProposal::From::Expected    ? "as expected"
                  : p.from == MotionProposal::From::Predicted ? "as the host predicts"
                                                              : "by support") +
                 ", one of " + std::to_string(estimator_.proposals().size()));
  }

  /// T_world_camera of the last frames, newest first; the world is the first camera.
  void extend_trail() {
    if (trail_.empty()) trail_.push_back(Pose());
    const Pose T = trail_.front() * inverse(motion_.T_current_reference);
    // Made a rotation again in every step: otherwise rounding grows with the chain.
    const Eigen::Matrix3d R = Eigen::Quaterniond(T.R()).normalized().toRotationMatrix();
    trail_.insert(trail_.begin(), Pose::from(R, T.t()));
    if (trail_.size() > kFrames + 1) trail_.pop_back();
  }
  /// The motion from frame to frame, over the last few: a mover that sets off slowly drags it away less.
  Pose usual_step() const {
    const std::size_t frames = std::min<std::size_t>(4, trail_.size() - 1);
    const auto share = 1 / static_cast<double>(frames);
    const Pose over = between(0, frames);
    const Eigen::AngleAxisd turn(over.R());
    return Pose::from(Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix(),
                      share * over.t());
  }
  /// From the camera `then` frames back to that of `now` frames back.
  Pose between(std::size_t now, std::size_t then) const { return inverse(trail_[now]) * trail_[then]; }

  // ---- evidence
  void weigh_misses(Context& context, const Match& match) {
    const Camera& camera = *context.frame().camera;
    residuals_.clear();
    for (std::size_t gap = 1; gap < trail_.size(); ++gap) {
      residuals_.emplace_back(camera, between(0, gap), noise(noise_px_[gap]));
      misses_px_[gap].clear();
      calm_misses_px_[gap].clear();
    }
    seen_.assign(context.size(), 0);
    own_.resize(context.size());
    for (std::size_t i = 0; i < context.size(); ++i) {
      own_[i] = static_cast<float>(params_.memory) * remembered_[i];
      if (!match.found(i)) continue;
      const cv::Point3f& now = context.points_m()[i];
      const bool calm = mobility_[i] < RigidBackgroundEstimator::kMobile;
      double chi2 = miss(1, match.reference_points_m[i], now, calm);
      const int longest = std::min(tracks_.length(i), static_cast<int>(residuals_.size()));
      if (longest > 1)
        chi2 = std::max(
            chi2, miss(longest, back_project(camera, tracks_.at(i, longest), tracks_.depth_m(i, longest)),
                       now, calm));
      if (chi2 < 0) continue;
      seen_[i] = 1;
      own_[i] = std::clamp(own_[i] + evidence(chi2), kLeastBelief, kMostBelief);
    }
    measure_noise();
  }

  RigidResidualNoise noise(double pixel_sigma_px) const {
    RigidResidualNoise noise;
    noise.pixel_sigma_px = pixel_sigma_px;
    noise.depth_noise.base_m *= params_.depth_sigma_factor;
    noise.depth_noise.quadratic_per_m *= params_.depth_sigma_factor;
    return noise;
  }

  /// chi2 against the background over `gap` frames; negative where it cannot be said. `calm`: it did not move
  /// lately.
  double miss(int gap, const cv::Point3f& then, const cv::Point3f& now, bool calm) {
    const RigidResidual r = residuals_[static_cast<std::size_t>(gap - 1)](then, now);
    if (!r.valid) return -1;
    misses_px_[static_cast<std::size_t>(gap)].push_back(r.image_px);
    if (calm) calm_misses_px_[static_cast<std::size_t>(gap)].push_back(r.image_px);
    return static_cast<double>(r.chi2);
  }
  float evidence(double chi2) const { return static_cast<float>(std::min(3.0, chi2 / params_.max_chi2 - 1)); }

  /// The median of the static features' misses, 1.18 sigma for two coordinates; half as much again, since
  /// they have longer tails. Who is static? Nearly all that did not move lately; and the better 70 % of all,
  /// which holds until movers have the majority. Slow movers that nobody found yet spoil the first, so the
  /// smaller of the two.
  void measure_noise() {
    constexpr double kRate = 0.3, kScale = 1.3;
    for (std::size_t gap = 1; gap < misses_px_.size(); ++gap) {
      std::vector<float>&all = misses_px_[gap], &calm = calm_misses_px_[gap];
      if (all.size() < 30) continue;
      float typical_px = quantile_in_place(all, 35);
      if (calm.size() >= 30) typical_px = std::min(typical_px, median_in_place(calm));
      const double sigma =
          std::clamp(kScale * static_cast<double>(typical_px), kLeastNoise_px, kMostNoise_px);
      noise_px_[gap] += kRate * (sigma - noise_px_[gap]);
      all.clear();
      calm.clear();
    }
  }

  // ---- neighbours
  void ask_neighbours(Context& context) {
    lay_out_witnesses(context);
    for (std::size_t i = 0; i < context.size(); ++i) {
      belief_[i] = own_[i] + static_cast<float>(params_.neighbour_weight) * mean_around(context, i);
      if (context.prior(i)) belief_[i] += static_cast<float>(params_.prior_suspicion);
    }
  }

  void lay_out_witnesses(Context& context) {
    witnesses_.clear();
    for (std::size_t i = 0; i < context.size(); ++i)
      if (seen_[i] != 0) witnesses_.add(context.pixels()[i], context.depths_m()[i], own_[i]);
    witnesses_.build(static_cast<float>(params_.neighbour_px));
  }

  /// Mean evidence of the neighbours, the near ones first; features without depth are asked with less trust.
  float mean_around(Context& context, std::size_t i) const {
    const cv::Point2f& px = context.pixels()[i];
    const float depth_m = context.depths_m()[i];
    const bool blind = std::isnan(depth_m);
    const float reach = static_cast<float>(params_.neighbour_px) * (seen_[i] != 0 ? 1 : kUnseenReach);
    NeighbourField::Sum sum = witnesses_.around(px, depth_m, reach, static_cast<float>(params_.neighbour_m));
    if (seen_[i] != 0 && PointGrid::usable(px)) sum.values -= own_[i], sum.weights -= 1;  // itself
    const float trust = blind ? 0.3F : 1.0F;
    return trust * sum.values / (trust * sum.weights + 0.5F);
  }

  void cast(Context& context, std::size_t i, Votes& votes) const {
    const float score = 1 / (1 + std::exp(-belief_[i]));
    if (seen_[i] != 0)
      votes.cast(i, belief_[i] > 0 ? Vote::Dynamic : Vote::Static, score);
    else
      votes.cast(i, belief_[i] > doubt(context, i) ? Vote::Dynamic : Vote::Unknown, score);
  }

  /// What a feature without evidence must exceed. Being suspect is enough with a depth, which the stage that
  /// suspects it can look at; without one the neighbours must lean towards motion.
  float doubt(Context& context, std::size_t i) const {
    if (!context.prior(i)) return kUnseenDoubt;
    return std::isnan(context.depths_m()[i]) ? static_cast<float>(params_.prior_suspicion) : 0.0F;
  }

  Params params_;
  FeatureTracks tracks_{kFrames, 3.0};
  RigidBackgroundEstimator estimator_;
  RigidMotion motion_;
  std::vector<Pose> trail_;
  std::array<double, kFrames + 1> noise_px_{};
  std::array<std::vector<float>, kFrames + 1> misses_px_, calm_misses_px_;
  std::vector<RigidResidualModel> residuals_;  ///< [g - 1]: over g frames
  std::vector<int> seeds_;
  std::vector<float> remembered_, static_belief_, own_;
  std::vector<float> belief_, last_belief_;
  std::vector<std::uint8_t> seen_;
  std::vector<float> mobility_, last_mobility_;
  NeighbourField witnesses_, moved_;  ///< evidence of this frame, mobility of the last
};

}  // namespace dynfilter
