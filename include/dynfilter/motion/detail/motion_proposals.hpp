// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <dynfilter/geometry/rigid_misses.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/motion/detail/background_points.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// One rigid motion that some of the points follow.
struct MotionProposal {
  /// Where the proposal comes from.
  enum class From { Expected, Predicted, Support };
  From from = From::Support;
  RigidMotion motion;
  double area = 0;     ///< share of the visible surface that it explains best
  double order = 0.5;  ///< share of the neighbouring points of other motions that are nearer
  double score = 0;    ///< log-probability of being the background, up to a constant
};

namespace detail {

/// Proposes rigid motions for the points of a scene, and measures the noise of the frame.
///
/// 1. A motion is fitted to all points with a shrinking inlier distance, and with little weight on depth. The
///    differences between neighbours' residuals give the noise of the matches (neighbour_noise.hpp). The
///    median residual in depth scales the depth camera's noise model, because colour and depth are not
///    exposed at the same time.
/// 2. Proposals are that motion where it explains nearly all points, the host's, and the expected one. The
///    expected one is refined at three inlier distances, and again from the widest to the narrowest. Points
///    that moved recently do not take part. If none of these explains nearly all others even roughly, RANSAC
///    searches them.
/// 3. Further proposals come from a search: the points of the best motion so far are removed, and RANSAC
///    searches the rest. While no motion is expected, the far points and all points are searched first.
class MotionProposals {
 public:
  using From = MotionProposal::From;

  static constexpr double kMinShare = 0.04;        ///< of the points: support of a motion worth a search
  static constexpr double kLeastRefined_px = 0.1;  ///< inlier noise; a narrower fit loses good points

  MotionProposals() : rigid_(rigid_options()) {}

  /// A fit to all points with a shrinking inlier distance. It follows most points, whatever its start.
  /// `points` have been sampled from the scene. Both must outlive search().
  RigidMotion follow_most(const RigidBackgroundScene& scene, BackgroundPoints& points) {
    scene_ = &scene;
    points_ = &points;
    const RigidMotion motion = fit_gradually();
    measure_noise(motion);
    return motion;
  }
  /// Of the points as they are now. `most`: of follow_most().
  void measure_noise(const RigidMotion& most) {
    const Pose start = most.ok ? most.T_current_reference : scene_->expected.value_or(Pose());
    misses_.measure(scene_->camera, start,
                    {scene_->reference_m, scene_->current_m, scene_->pixels, scene_->depth_noise},
                    points_->features());
    rigid_.options().depth_noise = scene_->depth_noise.scaled(depth_factor());
    points_->set_depth_noise(scene_->depth_noise.scaled(depth_factor()));
    match_noise_px_ = neighbour_noise_.scale(misses_.misses(), kNeighbourReach_px).value_or(kFirstNoise_px);
    noise_px_ = std::max(kNarrow_px, scene_->noise_ratio * match_noise_px_);
  }
  /// Proposes motions for the points, with the noise as it was measured last.
  void search(const RigidMotion& most) {
    proposals_.clear();
    image2_px2_.clear();
    depth2_.clear();
    if (most.ok) propose_most(most.T_current_reference);
    propose_known();
    propose_by_support();
  }

  std::vector<MotionProposal>& all() { return proposals_; }
  const std::vector<MotionProposal>& all() const { return proposals_; }
  /// Squared residuals, a row of BackgroundPoints::stride() per motion. See BackgroundPoints::measure().
  Span<const float> image2_px2() const { return image2_px2_; }
  Span<const float> depth2() const { return depth2_; }
  /// Noise of the matches that neighbours do not share [px per axis].
  double match_noise_px() const { return match_noise_px_; }
  /// Whole noise of a static match [px per axis].
  double noise_px() const { return noise_px_; }
  /// Error of the depths in units of the sensor's noise model, at least 1.
  double depth_factor() const { return misses_.depth_factor(); }

  /// Least squares on some of the features.
  RigidMotion refine(const std::vector<int>& features, double sigma_px, const Pose& start) {
    rigid_.options().pixel_sigma_px = sigma_px;
    return rigid_.refine(scene_->camera, scene_->reference_m, scene_->current_m, features, start);
  }

  bool uses_prior() const { return scene_->prior && scene_->prior_wrong <= 0.5; }

 private:
  static constexpr std::size_t kMinUnmoved = 30;    ///< points; with fewer, all take part
  static constexpr double kNearlyAll = 0.9;         ///< share that one motion explains roughly, at rest
  static constexpr std::size_t kFewestPoints = 12;  ///< fewer are not searched
  static constexpr double kFirstNoise_px = 0.3;     ///< with too few neighbours to measure it
  static constexpr double kWide_px = 0.8, kSupport_px = 0.25, kNarrow_px = 0.05;  ///< least inlier noise
  static constexpr double kSupportWidth = 0.7;              ///< of the noise: RANSAC finds the sharper points
  static constexpr double kGraduated_px[] = {12, 5, 2, 1};  ///< noise assumed by one fit after the other
  static constexpr double kLooseDepth = RigidMisses::kMostDepthFactor;  ///< depth factor of these fits
  static constexpr double kStep_sigmas = 0.1;        ///< a fit that is nearer to its optimum is good enough
  static constexpr float kNeighbourReach_px = 40;    ///< a cell of the grid
  static constexpr double kFarShare = 0.4;           ///< of the points, the farthest first
  static constexpr int kFarSearch = 150;             ///< samples among the far points
  static constexpr int kSearch = 100;                ///< samples among the points that no motion explains
  static constexpr int kFirstMotions = 3;            ///< per inlier distance, while no motion is expected
  static constexpr std::size_t kTranslations = 100;  ///< tried among the points
  static constexpr int kMostSearches = 4;            ///< more movers than that share a motion

  static RigidMotionOptions rigid_options() {
    RigidMotionOptions options;
    options.min_inlier_share = 0.02;
    options.refine_iterations = 5;
    options.refine_until_sigmas = kStep_sigmas;
    return options;
  }

  RigidMotion fit_gradually() {
    RigidMotion motion;
    Pose start = scene_->expected.value_or(Pose());
    rigid_.options().depth_noise = scene_->depth_noise.scaled(kLooseDepth);
    for (const double sigma_px : kGraduated_px) {
      const RigidMotion finer = refine(points_->features(), sigma_px, start);
      if (!finer.ok) break;
      motion = finer;
      start = finer.T_current_reference;
    }
    return motion;
  }
  /// In the first frame one between the background's and a mover's may explain both within the noise.
  double peel_px() const {
    return std::max(kLeastRefined_px, scene_->expected ? noise_px_ : 0.5 * match_noise_px_);
  }
  double support_px() const { return std::max(kSupport_px, kSupportWidth * match_noise_px_); }
  double wide_px() const { return std::max(kWide_px, 3 * noise_px_); }

  // ---- proposals from what is known
  /// Of a world at rest, nearly all points follow one motion roughly, also where rows are times. One that
  /// explains fewer lies between the motions of movers and of the room.
  void propose_most(const Pose& start) {
    const RigidMotion wide = refine(points_->features(), wide_px(), start);
    if (wide.ok && wide.inliers >= kNearlyAll * static_cast<double>(points_->size()))
      propose_from(From::Support, points_->features(), std::max(kSupport_px, 2 * noise_px_), start);
  }
  void propose_known() {
    if (scene_->predicted)
      propose_from(From::Predicted, points_->features(), support_px(), *scene_->predicted);
    if (uses_prior()) propose_prior(scene_->prior->T_current_reference);
    if (scene_->expected) propose_expected();
  }
  /// Where the prior does not tell the translation, the expected one goes with its turn.
  void propose_prior(const Pose& T) {
    if (!scene_->prior->has_translation && !scene_->expected) return;
    const bool whole = scene_->prior->has_translation;
    propose_from(From::Predicted, points_->features(), support_px(),
                 whole ? T : Pose::from(T.R(), scene_->expected->t()));
  }
  void propose_expected() {
    const bool enough_unmoved = collect_unmoved();
    const double narrow_px = std::max(kNarrow_px, 0.8 * noise_px_);
    bool found = false;
    for (const double sigma_px : {narrow_px, 2.5 * narrow_px, wide_px()})
      found = propose_from(From::Expected, unmoved_, sigma_px, *scene_->expected);
    if (enough_unmoved && !is_unmoved_explained()) {
      rigid_.options().max_iterations = kSearch;
      found = propose_searched(unmoved_, support_px()) &&
              propose_from(From::Support, unmoved_, narrow_px, last_motion());
    }
    // Where the camera's motion changed: from the widest, narrower in every step.
    for (const double sigma_px : {2.5 * narrow_px, narrow_px})
      found = found && propose_from(From::Expected, unmoved_, sigma_px, last_motion());
  }
  /// The points that did not move recently, as the rest. False, and all in unmoved_, if these are too few.
  bool collect_unmoved() {
    in_rest_.assign(points_->stride(), 0);
    for (std::size_t k = 0; k < points_->size(); ++k) in_rest_[k] = points_->moved_recently(k) ? 0.0F : 1.0F;
    unmoved_ = rest();
    if (unmoved_.size() >= kMinUnmoved) return true;
    unmoved_ = points_->features();
    return false;
  }
  /// Whether a proposal explains nearly all of them. Else a motion between theirs and a mover's may be best.
  bool is_unmoved_explained() const {
    std::size_t most = 0;
    for (std::size_t h = 0; h < proposals_.size(); ++h) most = std::max(most, explained_by(h, wide_px()));
    return static_cast<double>(most) > kNearlyAll * static_cast<double>(unmoved_.size());
  }

  // ---- proposals by search
  void propose_by_support() {
    if (!scene_->expected) {
      if (uses_prior()) propose_translations(scene_->prior->T_current_reference.R());
      propose_far();
      for (const double sigma_px : {support_px(), wide_px()}) propose_in_turn(sigma_px);
    }
    propose_rest();
  }

  /// While movers fill the view, a small background is rarely drawn among all points. Not where a motion is
  /// expected: the depth of far points is poor, and a poor fit would win by its depth order.
  void propose_far() {
    const auto far = static_cast<std::ptrdiff_t>(kFarShare * static_cast<double>(points_->size()));
    rest_features_.assign(points_->features().begin(), points_->features().begin() + far);
    rigid_.options().max_iterations = kFarSearch;
    if (rest_features_.size() >= kFewestPoints) propose_searched(rest_features_, support_px());
  }

  /// The best motion of all points, then that of the points which it does not explain, and so on.
  void propose_in_turn(double sigma_px) {
    rigid_.options().max_iterations = kSearch;
    restore_all();
    for (int k = 0; k < kFirstMotions && enough(rest_size_); ++k) {
      if (!propose_searched(rest(), sigma_px)) return;
      drop_explained(proposals_.size() - 1, sigma_px);
    }
  }

  /// The points that no motion so far explains, one motion after the other.
  void propose_rest() {
    rigid_.options().max_iterations = kSearch;
    restore_all();
    peeled_.assign(proposals_.size(), 0);
    for (int searches = 0; searches < kMostSearches; ++searches) {
      const std::size_t before = rest_size_;
      while (peel_best()) {
      }
      if (!enough(rest_size_) || (searches > 0 && rest_size_ == before)) return;
      if (!propose_searched(rest(), support_px())) return;
      propose_from(From::Support, rest(), peel_px(), last_motion());
      peeled_.resize(proposals_.size(), 0);
    }
  }
  bool enough(std::size_t points) const {
    return points >= kFewestPoints &&
           static_cast<double>(points) >= kMinShare * static_cast<double>(points_->size());
  }
  /// Removes the points of the motion that explains most of the rest.
  bool peel_best() {
    std::size_t most = 0, best = 0;
    for (std::size_t h = 0; h < proposals_.size(); ++h) {
      if (peeled_[h] != 0) continue;
      const std::size_t points = explained_by(h, peel_px());
      if (points > most) most = points, best = h;
    }
    if (!enough(most)) return false;
    peeled_[best] = 1;
    drop_explained(best, peel_px());
    return true;
  }

  // ---- one proposal
  bool propose_from(From from, const std::vector<int>& features, double sigma_px, const Pose& start) {
    return add(from, refine(features, sigma_px, start));
  }
  bool propose_searched(const std::vector<int>& features, double sigma_px) {
    rigid_.options().pixel_sigma_px = sigma_px;
    return add(From::Support,
               rigid_.estimate(scene_->camera, scene_->reference_m, scene_->current_m, features));
  }
  bool add(From from, const RigidMotion& motion) {
    if (!motion.ok) return false;
    MotionProposal proposal;
    proposal.from = from;
    proposal.motion = motion;
    proposals_.push_back(proposal);
    const std::size_t row = image2_px2_.size();
    image2_px2_.resize(row + points_->stride());
    depth2_.resize(row + points_->stride());
    points_->measure(motion.T_current_reference, image2_px2_.data() + row, depth2_.data() + row);
    return true;
  }
  const Pose& last_motion() const { return proposals_.back().motion.T_current_reference; }

  /// Where the camera's turn is known, one point tells a translation, and a motion between the background's
  /// and a mover's is none. The one that explains most of the rest, one after the other.
  void propose_translations(const Eigen::Matrix3d& R) {
    restore_all();
    for (int k = 0; k < kMostSearches && enough(rest_size_); ++k) {
      const std::optional<Pose> best = best_translation(R);
      if (!best || !propose_from(From::Support, rest(), support_px(), *best)) return;
      drop_explained(proposals_.size() - 1, support_px());
    }
  }
  std::optional<Pose> best_translation(const Eigen::Matrix3d& R) {
    const std::size_t step = std::max<std::size_t>(1, points_->size() / kTranslations);
    const std::size_t row = proposals_.size();  // one more than there is, as scratch
    image2_px2_.resize((row + 1) * points_->stride());
    depth2_.resize((row + 1) * points_->stride());
    std::optional<Pose> best;
    std::size_t most = kFewestPoints;
    for (std::size_t k = 0; k < points_->size(); k += step) {
      if (in_rest_[k] == 0) continue;
      const cv::Point3f &p = points_->reference_m(k), &c = points_->current_m(k);
      const Pose T = Pose::from(R, Eigen::Vector3d(c.x, c.y, c.z) - R * Eigen::Vector3d(p.x, p.y, p.z));
      points_->measure(T, image2_px2_.data() + row * points_->stride(),
                       depth2_.data() + row * points_->stride());
      const std::size_t support = explained_by(row, support_px());
      if (support > most) most = support, best = T;
    }
    image2_px2_.resize(row * points_->stride());
    depth2_.resize(row * points_->stride());
    return best;
  }

  // ---- the rest: points that are not removed
  void restore_all() {
    in_rest_.assign(points_->stride(), 0);
    std::fill_n(in_rest_.begin(), points_->size(), 1.0F);
    rest_size_ = points_->size();
  }
  const std::vector<int>& rest() {
    rest_features_.clear();
    for (std::size_t k = 0; k < points_->size(); ++k)
      if (in_rest_[k] != 0) rest_features_.push_back(points_->features()[k]);
    return rest_features_;
  }
  /// 1 for a point of the rest that motion h explains with this noise, else 0, from the k-th on.
  Pack explained(std::size_t h, float per_s2, std::size_t k) const {
    const std::size_t at = h * points_->stride() + k;
    const Pack chi2 = Pack::load(image2_px2_.data() + at) * per_s2 + Pack::load(depth2_.data() + at);
    return Pack::load(in_rest_.data() + k) * above(static_cast<float>(rigid_.options().inlier_chi2), chi2);
  }
  std::size_t explained_by(std::size_t h, double sigma_px) const {
    const auto per_s2 = static_cast<float>(1 / (sigma_px * sigma_px));
    Pack points = 0;
    for (std::size_t k = 0; k < in_rest_.size(); k += Pack::kWidth) points += explained(h, per_s2, k);
    return static_cast<std::size_t>(points.sum());
  }
  void drop_explained(std::size_t h, double sigma_px) {
    const auto per_s2 = static_cast<float>(1 / (sigma_px * sigma_px));
    Pack points = 0;
    for (std::size_t k = 0; k < in_rest_.size(); k += Pack::kWidth) {
      const Pack left = Pack::load(in_rest_.data() + k) - explained(h, per_s2, k);
      left.store(in_rest_.data() + k);
      points += left;
    }
    rest_size_ = static_cast<std::size_t>(points.sum());
  }

  RigidMotionEstimator rigid_;
  const RigidBackgroundScene* scene_ = nullptr;  ///< of the last search()
  BackgroundPoints* points_ = nullptr;
  std::vector<MotionProposal> proposals_;
  std::vector<float> image2_px2_, depth2_;  ///< proposals x stride
  NeighbourNoise neighbour_noise_;
  RigidMisses misses_;
  std::vector<float> in_rest_;  ///< 1 or 0 per point
  std::size_t rest_size_ = 0;
  std::vector<int> unmoved_, rest_features_;
  std::vector<char> peeled_;  ///< per proposal
  double match_noise_px_ = kFirstNoise_px, noise_px_ = kFirstNoise_px;
};

}  // namespace detail
}  // namespace dynfilter
