// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/motion/detail/background_points.hpp>
#include <dynfilter/motion/detail/motion_proposals.hpp>
#include <dynfilter/motion/detail/motion_selection.hpp>
#include <dynfilter/motion/detail/row_twist_fit.hpp>
#include <dynfilter/motion/prior_evidence.hpp>
#include <dynfilter/motion/row_twist.hpp>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace dynfilter {

/// The motion of the background between two frames, when most points may lie on movers.
///
/// 1. Motions are proposed for at most four points per cell of a 16 x 12 grid, and the noise of the frame is
///    measured (detail/motion_proposals.hpp).
/// 2. The motions that are needed are selected, and each point is given to the one that explains it best
///    (motion_selection.hpp). The n points of a patch count as n / (1 + (n - 1) rho) independent ones (Kish,
///    Survey Sampling, 1965, section 5.4). rho is the share of a match's error variance that neighbours have
///    in common.
/// 3. The background is the motion with the largest score: by its share of the visible surface, its distance
///    from the expected motion, its depth order, its share of the points, and a prior (the filter's card).
///    A motion that explains less than 4 % of the points is never the background. If none explains more,
///    there is no motion. The exponentials of the scores, normalised, give the confidence.
///
/// Owns its scratch. Not for several threads at once. Cost: O(seeds) to sample the points. The rest does not
/// grow with the features.
class RigidBackgroundEstimator {
 public:
  /// `ok` is false if no motion explains enough points. Unusual data never throws.
  RigidMotion estimate(const RigidBackgroundScene& scene) {
    straight_ = scene;
    scene_ = &straight_;
    const RigidMotion motion = estimate_of_scene();
    scene_ = nullptr;
    return motion;
  }

  /// All that were compared in the last frame.
  const std::vector<MotionProposal>& proposals() const { return search_.all(); }
  /// Index of the background's motion among the proposals.
  std::size_t chosen() const { return chosen_; }
  /// Probability that the chosen motion is the background's, given that one of the selected ones is.
  double confidence() const { return confidence_; }
  /// The probability that the background has another motion than the chosen one, and a feature follows it.
  /// Its points in the reference and in this frame [m].
  double rest_by_rivals(const Camera& camera, const cv::Point3f& reference_m,
                        const cv::Point3f& current_m) const {
    const Eigen::Vector3d then(reference_m.x, reference_m.y, reference_m.z);
    const Eigen::Vector2d now(current_m.x / current_m.z, current_m.y / current_m.z);
    double odds = 0;
    for (const Rival& rival : rivals_) {
      const Eigen::Vector3d still = rival.T_current_reference.R() * then + rival.T_current_reference.t();
      const double error = camera.fx_px * (still.hnormalized() - now).norm() / fit_px();
      if (1 / (1 + error * error) >= kExplained) odds += rival.odds;
    }
    return odds * confidence_;
  }
  /// Points that the estimate is based on.
  std::size_t points() const { return points_.size(); }
  /// Noise of this frame's matches that neighbours do not share [px per axis].
  double match_noise_px() const { return search_.match_noise_px(); }
  /// Error of this frame's depths in units of the sensor's noise model, at least 1.
  double depth_factor() const { return search_.depth_factor(); }
  /// Of the current frame against the reference: the motion holds for points that it has straightened.
  const RowTwist& row_twist() const { return twist_; }
  /// Squared distance of the chosen motion from the prior (prior_evidence.hpp); 0 without one.
  double prior_distance2() const { return prior_distance2_.empty() ? 0 : prior_distance2_[chosen_slot_]; }
  /// Whether a motion may be the chosen one's, seen by rows that are read one after the other.
  bool rows_may_part() const { return rows_may_part_; }
  /// Forgets how smoothly the camera moves.
  void reset() {
    usual_miss_px_ = kUnknownMiss_px;
    confidence_ = 1;
    rivals_.clear();
    readout_ = {};
  }

 private:
  using Points = detail::BackgroundPoints;
  /// A selected motion that is not the chosen one.
  struct Rival {
    Pose T_current_reference;
    double odds;  ///< of being the background's, over the chosen one's
  };
  static constexpr double kFit_px = 0.45;           ///< least width of a fit
  static constexpr double kFitSigmas = 3;           ///< of a match: the width of a fit
  static constexpr float kExplained = 0.1F;         ///< fit from which on a point is explained: 3 fit widths
  static constexpr double kPrice = 0.5;             ///< of a motion, in independent points; see the card
  static constexpr double kFirstPrice = 0.7;        ///< in the first frame, where nothing is expected
  static constexpr double kLeastCorrelation = 0.1;  ///< of the errors within a patch
  static constexpr double kDistinct = 2;            ///< of the noise: motions that may be ordered by depth
  static constexpr double kNeighbour_px = 50;       ///< distance of points whose depths are compared
  static constexpr float kDepthStep = 1.08F;        ///< a point farther by this factor is behind
  static constexpr double kUnknownMiss_px = 3;      ///< usual distance from the expected motion, at first
  static constexpr double kLeastMiss_px = 0.15;
  static constexpr double kMostMiss_px = 20;  ///< a point's distance between motions, cut off
  static constexpr double kShare = 0.1;       ///< weight of how many points a motion explains
  static constexpr double kSharpness = 2.5;   ///< of the choice: as sure as it is right, see the card
  static constexpr double kDepthCap_m = 4;    ///< farther, depths are too inexact to tell motions apart

  RigidMotion estimate_of_scene() {
    chosen_ = 0;
    prior_distance2_.clear();
    points_.sample(*scene_);
    RigidMotion most = search_.follow_most(*scene_, points_);
    const Rows rows = fit_rows(most);
    twist_ = rows.believed ? rows.fit.twist : RowTwist();
    if (rows.believed) {
      most.T_current_reference = rows.fit.T;
      straighten();
      search_.measure_noise(most);
    }
    search_.search(most);
    if (proposals().empty()) return {};
    select();
    choose();
    if (!explains_enough(chosen_slot_)) return {};
    rows_may_part_ = !rows.believed && differs_by_rows(scene_->camera.fy_px * rows.sigma_rad);
    const RigidMotion motion = refine_background();
    if (motion.ok && scene_->expected) learn_smoothness(motion.T_current_reference);
    if (motion.ok && rows.fit.ok && scene_->last_turn_radps) learn_readout(rows);
    return motion;
  }

  // ---- rows that are times
  struct Rows {
    double change_radps = 0, sigma_rad = 0;  ///< of the rate of turn against the last step; of the twist
    detail::RowTwistFit fit;                 ///< not `ok`: rows as good as at once
    bool believed = false;                   ///< no mover was fitted
  };
  static constexpr double kLeastTwist_px = 0.1;  ///< from the upper to the lower edge: nothing shows less
  static constexpr double kTwistShare = 0.9;     ///< of the points, while it is not known that rows are times
  static constexpr double kLearnShare = 0.7;     ///< of the points: fewer have no say in the readout

  /// A twist can bend a motion until it explains movers, too. So it is believed where the camera's rows are
  /// known to be times. While nothing is known of them, it must explain nearly all points.
  Rows fit_rows(const RigidMotion& most) const {
    Rows rows;
    if (!most.ok || !(scene_->elapsed_s > 0)) return rows;
    Eigen::Vector3d change = rotation_vector(most.T_current_reference.R()) / scene_->elapsed_s;
    if (scene_->last_turn_radps) change -= *scene_->last_turn_radps;
    rows.change_radps = change.norm();
    rows.sigma_rad = readout_.sigma_rad(rows.change_radps);
    if (scene_->camera.fy_px * rows.sigma_rad < kLeastTwist_px) return rows;
    rows.fit = detail::RowTwistFit::of(points_, scene_->camera, most.T_current_reference, rows.sigma_rad,
                                       search_.noise_px());
    rows.believed =
        rows.fit.ok && (readout_.rolls() || (readout_.may_roll() && rows.fit.share >= kTwistShare));
    return rows;
  }
  /// Puts the current points where one instant would show them.
  void straighten() {
    straight_m_.assign(scene_->current_m.begin(), scene_->current_m.end());
    for (const int i : points_.features()) {
      const auto k = static_cast<std::size_t>(i);
      cv::Point3f& c = straight_m_[k];
      const double s = RowTwist::row(scene_->camera, scene_->pixels[k].y);
      c = to_point(twist_.straighten({c.x, c.y, c.z}, s));
    }
    straight_.current_m = straight_m_;
    points_.follow(straight_);
  }
  /// Whether the noise tells a motion from the chosen one, but a twist of this length does not.
  bool differs_by_rows(double twist_px) const {
    for (std::size_t slot = 0; slot < selected_.size(); ++slot)
      if (explains_enough(slot) && distinct(slot, chosen_slot_) && distance_px(slot, chosen_slot_) < twist_px)
        return true;
    return false;
  }
  void learn_readout(const Rows& rows) {
    if (rows.fit.share < kLearnShare) return;
    readout_.learn(rows.change_radps, rows.sigma_rad, rows.fit.twist.a_rad, rows.fit.variance_rad2);
  }

  // ---- which motions are needed
  void select() {
    weigh_points();
    noise_px_ = search_.noise_px();
    selected_ =
        selection_.select({proposals().size(), points_.stride(), search_.image2_px2(), search_.depth2(),
                           weights_, scene_->expected ? kPrice : kFirstPrice, fit_px()});
    explained_.assign(selected_.size(), 0);
    for (std::size_t k = 0; k < points(); ++k)
      if (is_explained(k)) ++explained_[owner(k)];
  }
  /// Points of two by two cells share a part of their errors: Kish's effective number of them counts. In the
  /// first frame nothing is known of that part, so it is taken for all.
  void weigh_points() {
    const auto patch = [&](std::size_t k) {
      const std::size_t cell = points_.cell(k);
      return cell / Points::kColumns / 2 * (Points::kColumns / 2) + cell % Points::kColumns / 2;
    };
    std::array<int, Points::kCells / 4> held{};
    for (std::size_t k = 0; k < points(); ++k) ++held[patch(k)];
    const double whole2 = scene_->noise_ratio * scene_->noise_ratio;
    const double correlation = scene_->expected ? std::max(kLeastCorrelation, 1 - 1 / whole2) : 1;
    weights_.assign(points_.stride(), 0);
    for (std::size_t k = 0; k < points(); ++k)
      weights_[k] = static_cast<float>(1 / (1 + (held[patch(k)] - 1) * correlation));
  }

  double fit_px() const { return std::max(kFit_px, kFitSigmas * noise_px_); }
  /// The slot of a point, an index into selected_.
  std::size_t owner(std::size_t k) const { return selection_.owner(k); }
  bool is_explained(std::size_t k) const { return selection_.fit(k) >= kExplained; }
  /// Neither a few points are the background, however near to the expected motion, nor points of which the
  /// motion explains none well.
  bool explains_enough(std::size_t slot) const {
    return explained_[slot] >= detail::MotionProposals::kMinShare * static_cast<double>(points());
  }
  MotionProposal& proposal(std::size_t slot) { return search_.all()[selected_[slot]]; }
  const Pose& motion_of(std::size_t slot) const {
    return proposals()[selected_[slot]].motion.T_current_reference;
  }

  // ---- which of them is the background
  void choose() {
    measure_distances();
    measure_areas();
    measure_orders();
    for (std::size_t slot = 0; slot < selected_.size(); ++slot) {
      MotionProposal& p = proposal(slot);
      p.score = portable::log(p.area + 1e-6) + p.order;
      if (scene_->expected) {
        const double d = distance_px(slot, slot, motion_of(slot), *scene_->expected) /
                         std::max(kLeastMiss_px, 2 * usual_miss_px_);
        const double share = (explained_[slot] + 0.5) / (static_cast<double>(points()) + 1);
        p.score += kShare * portable::log_odds(share) - portable::log1p(d * d);
        p.score *= kSharpness;
      }
    }
    if (scene_->prior) weigh_prior();
    chosen_slot_ = 0;
    for (std::size_t slot = 1; slot < selected_.size(); ++slot)
      if (rank(chosen_slot_) < rank(slot)) chosen_slot_ = slot;
    chosen_ = selected_[chosen_slot_];
    measure_confidence();
  }
  /// Over the points that each motion explains.
  void weigh_prior() {
    const double noise_px = std::max(kLeastMiss_px, noise_px_);
    prior_distance2_.assign(selected_.size(), 0);
    for (std::size_t slot = 0; slot < selected_.size(); ++slot) {
      PriorEvidence evidence(*scene_->prior, scene_->camera);
      for (std::size_t k = 0; k < points(); ++k)
        if (owner(k) == slot && is_explained(k)) evidence.add(points_.current_m(k));
      prior_distance2_[slot] = evidence.distance2(motion_of(slot), noise_px);
      if (search_.uses_prior())
        proposal(slot).score += PriorEvidence::log_likelihood(prior_distance2_[slot], scene_->prior_wrong);
    }
  }
  std::pair<bool, double> rank(std::size_t slot) { return {explains_enough(slot), proposal(slot).score}; }
  /// Motions within a fit of the choice agree with it.
  void measure_confidence() {
    rivals_.clear();
    double against = 0;
    for (std::size_t slot = 0; slot < selected_.size(); ++slot)
      if (explains_enough(slot) && distances_px_[slot * selected_.size() + chosen_slot_] > fit_px()) {
        const double odds = portable::exp(proposal(slot).score - proposal(chosen_slot_).score);
        rivals_.push_back({motion_of(slot), odds});
        against += odds;
      }
    confidence_ = 1 / (1 + against);
  }

  void measure_areas() {
    areas_.assign(selected_.size(), {});
    std::array<double, Points::kCells> all{};
    for (std::size_t k = 0; k < points(); ++k) {
      const double w = weight(k);
      all[points_.cell(k)] += w;
      areas_[owner(k)][points_.cell(k)] += w * static_cast<double>(selection_.fit(k));
    }
    const double total = area_of(all);
    for (std::size_t slot = 0; slot < selected_.size(); ++slot)
      proposal(slot).area = total > 0 ? area_of(areas_[slot]) / total : 0;
  }
  /// The square root of a cell's sum is its surface, which grows with the square of the depth.
  static double area_of(const std::array<double, Points::kCells>& cells) {
    double area = 0;
    for (const double w : cells) area += std::sqrt(w);
    return area;
  }
  double weight(std::size_t k) const {
    const double z_m = std::min(kDepthCap_m, static_cast<double>(points_.depth_m(k)));
    const double surface_m2 = z_m * z_m * (1 - static_cast<double>(points_.mobility(k)));
    return surface_m2 * surface_m2;
  }

  /// Points come farthest first: of a pair, only the first can be behind.
  void measure_orders() {
    if (selected_.size() < 2) return;
    pixels_.clear();
    for (std::size_t k = 0; k < points(); ++k) pixels_.push_back(points_.pixel(k));
    grid_.build(Span<const cv::Point2f>(pixels_), static_cast<float>(kNeighbour_px));
    behind_.assign(selected_.size(), 1);
    front_.assign(selected_.size(), 1);
    for (std::size_t k = 0; k < points(); ++k)
      grid_.around(pixels_[k], static_cast<float>(kNeighbour_px), [&](std::int32_t j) {
        const auto other = static_cast<std::size_t>(j);
        if (other <= k || !distinct(owner(k), owner(other)) ||
            !(points_.depth_m(k) > kDepthStep * points_.depth_m(other)) || !are_neighbours(k, other))
          return;
        ++behind_[owner(k)];
        ++front_[owner(other)];
      });
    for (std::size_t slot = 0; slot < selected_.size(); ++slot)
      proposal(slot).order = static_cast<double>(behind_[slot]) / (behind_[slot] + front_[slot]);
  }
  bool are_neighbours(std::size_t a, std::size_t b) const {
    const cv::Point2f apart = pixels_[a] - pixels_[b];
    const double x = apart.x, y = apart.y;
    return x * x + y * y <= kNeighbour_px * kNeighbour_px;
  }

  // ---- distances between motions
  /// Mean distance of two motions in the image over the points of the slots a and b [px], at most 20.
  /// Elsewhere a motion is extrapolated: a few far points do not determine how near ones would move.
  double distance_px(std::size_t a, std::size_t b, const Pose& A, const Pose& B) const {
    const Eigen::Matrix3d RA = A.R(), RB = B.R();
    double sum = 0;
    int n = 0;
    for (std::size_t k = 0; k < points(); ++k) {
      if (owner(k) != a && owner(k) != b) continue;
      const Eigen::Vector3d p(points_.reference_m(k).x, points_.reference_m(k).y, points_.reference_m(k).z),
          q = RA * p + A.t(), r = RB * p + B.t();
      sum += std::min(kMostMiss_px, scene_->camera.fx_px * (q.hnormalized() - r.hnormalized()).norm());
      ++n;
    }
    return n > 0 ? sum / n : 0;
  }
  double distance_px(std::size_t a, std::size_t b) const {
    return distance_px(a, b, motion_of(a), motion_of(b));
  }
  void measure_distances() {
    const std::size_t n = selected_.size();
    distances_px_.assign(n * n, 0);
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = a + 1; b < n; ++b)
        distances_px_[a * n + b] = distances_px_[b * n + a] = distance_px(a, b);
  }
  /// Motions that differ by no more than the noise share their points by chance, so their depth order means
  /// nothing.
  bool distinct(std::size_t a, std::size_t b) const {
    return distances_px_[a * selected_.size() + b] > kDistinct * noise_px_;
  }

  void learn_smoothness(const Pose& T) {
    constexpr double kRate = 0.2, kMost_px = 6;
    const double miss_px = distance_px(chosen_slot_, chosen_slot_, T, *scene_->expected);
    usual_miss_px_ += kRate * (std::min(kMost_px, miss_px) - usual_miss_px_);
  }

  /// On the points of the background's motion and of those that the noise cannot distinguish from it, as
  /// narrowly as the noise allows.
  RigidMotion refine_background() {
    features_.clear();
    for (std::size_t k = 0; k < points(); ++k)
      if (owner(k) == chosen_slot_ || !distinct(owner(k), chosen_slot_))
        features_.push_back(points_.features()[k]);
    const double sigma_px = std::max(detail::MotionProposals::kLeastRefined_px, noise_px_);
    const RigidMotion motion = search_.refine(features_, sigma_px, motion_of(chosen_slot_));
    return motion.ok ? motion : proposals()[chosen_].motion;
  }

  const RigidBackgroundScene* scene_ = nullptr;  ///< during estimate() only
  RigidBackgroundScene straight_;                ///< the scene, its points straightened
  std::vector<cv::Point3f> straight_m_;
  RowReadout readout_;
  RowTwist twist_;
  Points points_;
  detail::MotionProposals search_;
  detail::MotionSelection selection_;
  std::vector<float> weights_;                             ///< per point, padded
  std::vector<std::size_t> selected_;                      ///< indices of proposals
  std::vector<double> prior_distance2_;                    ///< per slot, with a prior
  std::vector<int> explained_;                             ///< points per slot
  std::vector<std::array<double, Points::kCells>> areas_;  ///< per slot
  std::vector<Rival> rivals_;
  std::vector<double> distances_px_;  ///< slots x slots
  std::vector<int> behind_, front_;   ///< per slot
  std::vector<cv::Point2f> pixels_;
  std::vector<int> features_;
  PointGrid grid_;
  std::size_t chosen_ = 0, chosen_slot_ = 0;
  double noise_px_ = 0;
  double usual_miss_px_ = kUnknownMiss_px, confidence_ = 1;
  bool rows_may_part_ = false;
};

}  // namespace dynfilter
