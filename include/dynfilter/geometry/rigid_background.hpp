// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/motion_selection.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <dynfilter/geometry/rigid_misses.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace dynfilter {

/// What a background motion is estimated from. One entry per feature in every span but `seeds`.
struct RigidBackgroundScene {
  Camera camera;
  Span<const cv::Point3f> reference_m, current_m;  ///< in the camera frames; z not finite: none
  Span<const cv::Point2f> pixels;                  ///< where the features are now
  Span<const float> static_belief;                 ///< [0, 1] from earlier frames; 0.5: none
  Span<const float> mobility;                      ///< [0, 1] moved lately; empty: nobody did
  Span<const int> seeds;                           ///< features that may be used, ascending
  std::optional<Pose> expected;                    ///< T_current_reference, if the camera goes on as it went
  std::optional<Pose> predicted;                   ///< T_current_reference, as the host says
  double noise_ratio = 1.5;  ///< whole error of a static match over the noise that neighbours do not share
};

/// One rigid motion that some of the points follow.
struct MotionProposal {
  enum class From { Expected, Predicted, Support };
  From from = From::Support;
  RigidMotion motion;
  double sigma_px = 0;  ///< it was fitted with this noise
  double area = 0;      ///< share of the visible surface that it explains best
  double order = 0.5;   ///< share of the neighbouring points of other motions that lie nearer
  double score = 0;     ///< log-probability of being the background, up to a constant
};

/// The motion of the background between two frames, when most points may lie on movers.
///
/// 1. The noise of this frame: a motion is fitted to all points with a shrinking reach (graduated), weakly
///    tied to depth. Neighbours' differences give the noise of the matches (neighbour_noise.hpp), the median
///    miss in depth says how far the depth camera's model can be trusted in this frame: colour and depth are
///    not taken at the same time.
/// 2. Motions are proposed: the graduated one, what the camera did before (refined at three widths and from
///    wide to narrow), the host's, and by search: the points of the best motion so far are peeled off, and
///    RANSAC looks among the rest; first among the far points while nothing is expected.
/// 3. The set of motions with the shortest description is kept (motion_selection.hpp); each point belongs to
///    the motion that explains it best. The n points of a patch count as n / (1 + (n - 1) rho) independent
///    ones (Kish, Survey Sampling, 1965, section 5.4), where rho is the share of a match's error variance
///    that neighbours have in common.
/// 4. The background is the motion with the largest
///      log(area) - log(1 + d^2) + order,
///    area: share of the visible surface [m^2], as a piece of surface is equally likely to move wherever it
///    is, weighted by what was static before; d: distance of its points in the image from the expected motion
///    in units of the usual distance; order: share of neighbours on other motions that are in front. A motion
///    that explains less than 4 % of the points is never the background: then there is no motion. The
///    exponentials of these scores, normalised, are the confidence.
///
/// Features that moved lately do not take part where the expected motion is refined. Works on at most four
/// points per cell of a 16 x 12 grid, the far ones. Owns its scratch. Not for several threads at once. About
/// 0.3 ms for 1000 features.
class RigidBackgroundEstimator {
 public:
  static constexpr float kMobile = 0.5F;  ///< a mobility from which on a point counts as having moved

  RigidBackgroundEstimator() : rigid_(rigid_options()) {}

  /// `ok` is false when no motion explains enough. Never throws on odd data.
  RigidMotion estimate(const RigidBackgroundScene& scene) {
    scene_ = &scene;
    const RigidMotion motion = estimate_of_scene();
    scene_ = nullptr;
    return motion;
  }

  const std::vector<MotionProposal>& proposals() const { return proposals_; }
  std::size_t chosen() const { return chosen_; }
  /// Probability that the chosen motion is the background's, given that one of the selected ones is.
  double confidence() const { return confidence_; }
  /// Points that were looked at.
  std::size_t points() const { return points_.size(); }
  /// Noise of this frame's matches that neighbours do not share [px per axis].
  double match_noise_px() const { return match_noise_px_; }
  /// Error of this frame's depths in units of the sensor's model, at least 1.
  double depth_factor() const { return misses_.depth_factor(); }
  /// Forgets how smoothly the camera moves.
  void reset() {
    usual_miss_px_ = kUnknownMiss_px;
    confidence_ = 1;
  }

 private:
  static constexpr int kColumns = 16, kRows = 12;
  static constexpr std::size_t kPerCell = 4, kMinSettled = 30;
  static constexpr double kWide_px = 0.8, kSupport_px = 0.25, kFit_px = 0.3, kNarrow_px = 0.05;  ///< at least
  static constexpr double kFirstNoise_px = 0.3;  ///< where there are too few neighbours to measure it
  static constexpr double kMinShare = 0.04;      ///< of the points: what the background must explain
  static constexpr float kExplained = 0.1F;      ///< a fit from which on a point is explained: 3 fit widths
  static constexpr double kGraduated_px[] = {12, 5, 2, 1};  ///< noise assumed by one fit after the other
  static constexpr double kLooseDepth = RigidMisses::kMostDepthFactor;  ///< depth factor of these fits
  static constexpr float kNeighbourReach_px = 40;                       ///< a cell of the grid
  static constexpr double kSupportWidth = 0.7;  ///< of the noise: RANSAC finds the sharper points
  static constexpr float kPrice_nats = 15;      ///< of six parameters; fitted, see the filter's card
  static constexpr float kFirstPrice_nats =
      8;  ///< before anything was followed, that several things move is likely
  static constexpr double kFarShare = 0.4;          ///< of the points: those at the back
  static constexpr int kFarSearch = 150;            ///< samples among the far points
  static constexpr int kSearch = 100;               ///< samples among what the motions so far leave
  static constexpr int kFirstMotions = 3;           ///< per width, while nothing is expected
  static constexpr int kMostSearches = 4;           ///< more movers than that share a motion
  static constexpr std::size_t kFewestPoints = 12;  ///< fewer are not searched
  static constexpr double kLeastCorrelation = 0.1;  ///< of the errors within a patch
  static constexpr double kDistinct = 2;            ///< of the noise: motions that differ by more
  static constexpr double kNeighbour_px = 50;       ///< whose depths are compared
  static constexpr float kDepthStep = 1.08F;        ///< farther by this factor lies behind
  static constexpr double kUnknownMiss_px = 3;      ///< before anything is known of the camera's smoothness
  static constexpr double kLeastRefined_px = 0.1;   ///< narrower, a fit loses good points
  static constexpr double kLeastMiss_px = 0.15;
  static constexpr double kDepthCap_m = 4;  ///< farther, depths are too poor to tell motions apart

  struct Candidate {
    float depth_m;  ///< beside the index, so that sorting does not look it up
    int index;
  };

  RigidMotion estimate_of_scene() {
    proposals_.clear();
    chosen_ = 0;
    sample_evenly();
    measure_noise();
    propose_known();
    propose_by_support();
    if (proposals_.empty()) return {};
    measure_misses();
    select();
    assign();
    if (!explains_enough(choose())) return {};
    const RigidMotion motion = refine_background(chosen_);
    if (motion.ok && scene_->expected) learn_smoothness(motion.T_current_reference);
    return motion;
  }

  static RigidMotionOptions rigid_options() {
    RigidMotionOptions options;
    options.min_inlier_share = 0.02;
    options.refine_iterations = 5;
    return options;
  }

  std::size_t cell_of(int i) const {
    const auto place = [](double x, double size, int cells) {
      const double at = x / size * cells;
      return static_cast<std::size_t>(at > 0 ? std::min(at, cells - 1.0) : 0);  // 0 for NaN, too
    };
    const cv::Point2f& p = scene_->pixels[static_cast<std::size_t>(i)];
    return place(p.y, 2 * scene_->camera.cy_px, kRows) * kColumns +
           place(p.x, 2 * scene_->camera.cx_px, kColumns);
  }
  float depth(int i) const { return scene_->current_m[static_cast<std::size_t>(i)].z; }

  /// A dense mover does not outvote what is around it, and the work stays the same with more features.
  void sample_evenly() {
    for (auto& cell : cells_) cell.clear();
    for (const int i : scene_->seeds) {
      const auto k = static_cast<std::size_t>(i);
      if (k < scene_->pixels.size() && usable(scene_->reference_m[k]) && usable(scene_->current_m[k]) &&
          PointGrid::usable(scene_->pixels[k]))
        cells_[cell_of(i)].push_back({depth(i), i});
    }
    const auto farther_first = [&](const Candidate& a, const Candidate& b) { return farther(a, b); };
    candidates_.clear();
    for (auto& cell : cells_) {
      if (cell.size() > kPerCell) {
        std::partial_sort(cell.begin(), cell.begin() + kPerCell, cell.end(), farther_first);
        cell.resize(kPerCell);
      }
      candidates_.insert(candidates_.end(), cell.begin(), cell.end());
    }
    // By place, not by index: the order of the features must not matter.
    std::sort(candidates_.begin(), candidates_.end(), farther_first);
    points_.clear();
    for (const Candidate& candidate : candidates_) points_.push_back(candidate.index);
  }
  static bool usable(const cv::Point3f& p) {
    return valid_depth(p.z) && std::isfinite(p.x) && std::isfinite(p.y);
  }
  bool farther(const Candidate& a, const Candidate& b) const {
    if (a.depth_m != b.depth_m) return a.depth_m > b.depth_m;
    const auto key = [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      const cv::Point2f& now = scene_->pixels[k];
      const cv::Point3f& then = scene_->reference_m[k];
      return std::make_tuple(now.y, now.x, then.z, then.y, then.x, i);
    };
    return key(a.index) < key(b.index);
  }

  // ---- the noise of this frame
  void measure_noise() {
    graduated_ = fit_gradually();
    const Pose start = graduated_.ok ? graduated_.T_current_reference : scene_->expected.value_or(Pose());
    misses_.measure(scene_->camera, start, {scene_->reference_m, scene_->current_m, scene_->pixels}, points_);
    rigid_.options().depth_noise = DepthNoise().scaled(depth_factor());
    match_noise_px_ = neighbour_noise_.scale(misses_.misses(), kNeighbourReach_px).value_or(kFirstNoise_px);
    noise_px_ = std::max(kNarrow_px, scene_->noise_ratio * match_noise_px_);
  }
  /// A fit to all points whose reach shrinks: it follows most of them, wherever it begins.
  RigidMotion fit_gradually() {
    RigidMotion motion;
    Pose start = scene_->expected.value_or(Pose());
    rigid_.options().depth_noise = DepthNoise().scaled(kLooseDepth);
    for (const double sigma_px : kGraduated_px) {
      rigid_.options().pixel_sigma_px = sigma_px;
      const RigidMotion finer =
          rigid_.refine(scene_->camera, scene_->reference_m, scene_->current_m, points_, start);
      if (!finer.ok) break;
      motion = finer;
      start = finer.T_current_reference;
    }
    return motion;
  }
  /// At first sight a motion between the background's and a mover's may explain both within the noise.
  double peel_px() const {
    return std::max(kLeastRefined_px, scene_->expected ? noise_px_ : 0.5 * match_noise_px_);
  }
  double support_px() const { return std::max(kSupport_px, kSupportWidth * match_noise_px_); }
  double wide_px() const { return std::max(kWide_px, 3 * noise_px_); }
  double fit_px() const { return std::max(kFit_px, 2 * noise_px_); }

  void propose_known() {
    if (graduated_.ok)
      propose(MotionProposal::From::Support, points_, std::max(kSupport_px, 2 * noise_px_),
              graduated_.T_current_reference);
    if (scene_->predicted) propose(MotionProposal::From::Predicted, points_, support_px(), scene_->predicted);
    if (!scene_->expected) return;
    const double narrow_px = std::max(kNarrow_px, 0.8 * noise_px_);
    bool found = false;
    for (const double sigma_px : {narrow_px, 2.5 * narrow_px, wide_px()})
      found = propose(MotionProposal::From::Expected, settled(), sigma_px, scene_->expected);
    // From the wide one narrower in every step: where the camera's motion changed.
    for (const double sigma_px : {2.5 * narrow_px, narrow_px})
      found = found && propose(MotionProposal::From::Expected, settled(), sigma_px,
                               proposals_.back().motion.T_current_reference);
  }

  /// The points that did not move lately; all, if these are too few.
  const std::vector<int>& settled() {
    settled_.clear();
    for (const int i : points_) {
      const auto k = static_cast<std::size_t>(i);
      if (k >= scene_->mobility.size() || scene_->mobility[k] < kMobile) settled_.push_back(i);
    }
    return settled_.size() >= kMinSettled ? settled_ : points_;
  }

  void propose_by_support() {
    if (!scene_->expected) {
      propose_from_afar();
      for (const double sigma_px : {support_px(), wide_px()}) propose_from_nothing(sigma_px);
    }
    propose_among_the_rest();
  }

  /// The best motion of all points, then that of the points which it does not explain, ...
  void propose_from_nothing(double sigma_px) {
    rigid_.options().max_iterations = kSearch;
    rest_ = points_;
    for (int k = 0; k < kFirstMotions && enough(rest_.size()); ++k) {
      if (!propose(MotionProposal::From::Support, rest_, sigma_px, std::nullopt)) return;
      drop_explained(proposals_.back().motion, sigma_px);
    }
  }

  /// Among what the motions proposed so far leave, one after the other; in the end once more widely.
  void propose_among_the_rest() {
    rigid_.options().max_iterations = kSearch;
    rest_ = points_;
    peeled_.assign(proposals_.size(), 0);
    for (int searches = 0; searches < kMostSearches; ++searches) {
      const std::size_t before = rest_.size();
      while (peel_best()) {
      }
      if (!enough(rest_.size())) return;
      if (searches > 0 && rest_.size() == before) break;  // the last search found nothing
      if (!propose(MotionProposal::From::Support, rest_, support_px(), std::nullopt)) break;
      propose(MotionProposal::From::Support, rest_, peel_px(), proposals_.back().motion.T_current_reference);
      peeled_.resize(proposals_.size(), 0);
    }
    propose(MotionProposal::From::Support, rest_, wide_px(), std::nullopt);
  }
  bool enough(std::size_t points) const {
    return points >= kFewestPoints &&
           static_cast<double>(points) >= kMinShare * static_cast<double>(points_.size());
  }
  bool peel_best() {
    std::size_t most = 0, best = 0;
    for (std::size_t h = 0; h < proposals_.size(); ++h) {
      if (peeled_[h] != 0) continue;
      const std::size_t points = explained_by(proposals_[h].motion);
      if (points > most) most = points, best = h;
    }
    if (!enough(most)) return false;
    peeled_[best] = 1;
    drop_explained(proposals_[best].motion, peel_px());
    return true;
  }

  /// `points_` begins with the farthest. Among all of them a small background is drawn too rarely when movers
  /// fill the view from the first frame on; and a motion between theirs and its own has more support. Their
  /// depth is poor, so not where it is known what the camera does: a sloppy fit would win by lying behind.
  void propose_from_afar() {
    const auto far = static_cast<std::ptrdiff_t>(kFarShare * static_cast<double>(points_.size()));
    rest_.assign(points_.begin(), points_.begin() + far);
    rigid_.options().max_iterations = kFarSearch;
    if (rest_.size() >= kFewestPoints)
      propose(MotionProposal::From::Support, rest_, support_px(), std::nullopt);
  }

  bool propose(MotionProposal::From from, const std::vector<int>& seeds, double sigma_px,
               const std::optional<Pose>& start) {
    rigid_.options().pixel_sigma_px = sigma_px;
    MotionProposal proposal;
    proposal.from = from;
    proposal.sigma_px = sigma_px;
    proposal.motion =
        start ? rigid_.refine(scene_->camera, scene_->reference_m, scene_->current_m, seeds, *start)
              : rigid_.estimate(scene_->camera, scene_->reference_m, scene_->current_m, seeds);
    if (proposal.motion.ok) proposals_.push_back(proposal);
    return proposal.motion.ok;
  }

  /// visit(k, squared miss in the image [px^2], squared miss in depth [sigma^2]) for the k-th of `points`.
  template <class Visit>
  void for_misses(const std::vector<int>& points, const Pose& T, const Visit& visit) const {
    const Eigen::Matrix3f R = T.R().cast<float>();
    const Eigen::Vector3f t = T.t().cast<float>();
    const auto fx = static_cast<float>(scene_->camera.fx_px), fy = static_cast<float>(scene_->camera.fy_px);
    const DepthNoise noise = DepthNoise().scaled(depth_factor());
    for (std::size_t k = 0; k < points.size(); ++k) {
      const cv::Point3f &p = scene_->reference_m[static_cast<std::size_t>(points[k])],
                        &c = scene_->current_m[static_cast<std::size_t>(points[k])];
      const Eigen::Vector3f q = R * Eigen::Vector3f(p.x, p.y, p.z) + t;
      const float u = fx * (q.x() / q.z() - c.x / c.z), v = fy * (q.y() / q.z() - c.y / c.z);
      const auto s1 = static_cast<float>(noise.sigma_m(c.z)), s2 = static_cast<float>(noise.sigma_m(p.z));
      const float w2 = (q.z() - c.z) * (q.z() - c.z) / (s1 * s1 + s2 * s2);
      visit(k, q.z() > 0 ? u * u + v * v : kBehind, w2);
    }
  }
  static constexpr float kBehind = 1e9F;

  /// visit(k) for the k-th of rest_ if the motion explains it with this noise.
  template <class Visit>
  void for_explained(const RigidMotion& motion, double sigma_px, const Visit& visit) const {
    const auto limit = static_cast<float>(rigid_.options().inlier_chi2);
    const auto per_s2 = static_cast<float>(1 / (sigma_px * sigma_px));
    for_misses(rest_, motion.T_current_reference, [&](std::size_t k, float image2, float depth2) {
      if (image2 * per_s2 + depth2 < limit) visit(k);
    });
  }
  std::size_t explained_by(const RigidMotion& motion) const {
    std::size_t points = 0;
    for_explained(motion, peel_px(), [&](std::size_t) { ++points; });
    return points;
  }
  void drop_explained(const RigidMotion& motion, double sigma_px) {
    for_explained(motion, sigma_px, [&](std::size_t k) { rest_[k] = kDropped; });
    rest_.erase(std::remove(rest_.begin(), rest_.end(), kDropped), rest_.end());
  }
  static constexpr int kDropped = -1;

  // ---- which motions are needed
  const float* fits_of(std::size_t h) const { return fit_.data() + h * points_.size(); }

  void measure_misses() {
    image2_px2_.resize(proposals_.size() * points_.size());
    depth2_.resize(image2_px2_.size());
    for (std::size_t h = 0; h < proposals_.size(); ++h)
      for_misses(points_, proposals_[h].motion.T_current_reference,
                 [&](std::size_t k, float image2, float depth2) {
                   image2_px2_[h * points_.size() + k] = image2;
                   depth2_[h * points_.size() + k] = depth2;
                 });
  }
  void measure_fits() {
    fit_.resize(image2_px2_.size());
    const auto per_fit2 = static_cast<float>(1 / (fit_px() * fit_px()));
    for (std::size_t k = 0; k < fit_.size(); ++k)
      fit_[k] = 1 / (1 + (image2_px2_[k] * per_fit2 + depth2_[k]));
  }

  void select() {
    weigh_points();
    prices_.assign(proposals_.size(), scene_->expected ? kPrice_nats : kFirstPrice_nats);
    selected_ = selection_.select(
        {proposals_.size(), points_.size(), image2_px2_, depth2_, weights_, prices_, noise_px_});
    noise_px_ = selection_.noise_px();
    measure_fits();
  }
  /// Points of two by two cells share a part of their errors: Kish's effective number of them counts. In the
  /// first frame nothing is known of that part, so it is taken for all.
  void weigh_points() {
    const auto patch = [&](int i) {
      const std::size_t cell = cell_of(i);
      return cell / kColumns / 2 * (kColumns / 2) + cell % kColumns / 2;
    };
    std::array<int, kColumns * kRows / 4> held{};
    for (const int i : points_) ++held[patch(i)];
    const double whole2 = scene_->noise_ratio * scene_->noise_ratio;
    const double correlation = scene_->expected ? std::max(kLeastCorrelation, 1 - 1 / whole2) : 1;
    weights_.clear();
    for (const int i : points_)
      weights_.push_back(static_cast<float>(1 / (1 + (held[patch(i)] - 1) * correlation)));
  }

  /// Each point belongs to the selected motion that explains it best.
  void assign() {
    owner_.assign(points_.size(), selected_.front());
    for (std::size_t k = 0; k < points_.size(); ++k)
      for (const std::size_t h : selected_)
        if (fits_of(h)[k] > fits_of(owner_[k])[k]) owner_[k] = h;
  }

  // ---- which of them is the background
  std::size_t choose() {
    measure_areas();
    measure_orders();
    for (const std::size_t h : selected_) {
      MotionProposal& p = proposals_[h];
      p.score = std::log(p.area + 1e-6) + p.order;
      if (scene_->expected) {
        const double d = distance_px(h, h, p.motion.T_current_reference, *scene_->expected) /
                         std::max(kLeastMiss_px, 2 * usual_miss_px_);
        p.score -= std::log1p(d * d);
      }
    }
    const auto rank = [&](std::size_t h) { return std::make_pair(explains_enough(h), proposals_[h].score); };
    chosen_ = *std::max_element(selected_.begin(), selected_.end(),
                                [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
    measure_confidence();
    return chosen_;
  }
  /// Motions that the noise cannot tell from the chosen one do not speak against it.
  void measure_confidence() {
    double against = 0;
    for (const std::size_t h : selected_)
      if (explains_enough(h) && distinct(h, chosen_))
        against += std::exp(proposals_[h].score - proposals_[chosen_].score);
    confidence_ = 1 / (1 + against);
  }
  /// A handful of points is not the background, as near to what was expected as it may move; nor is what owns
  /// many points, all of them badly, because nobody explains them.
  bool explains_enough(std::size_t h) const {
    int explained = 0;
    for (std::size_t k = 0; k < points_.size(); ++k)
      if (owner_[k] == h && fits_of(h)[k] >= kExplained) ++explained;
    return explained >= kMinShare * static_cast<double>(points_.size());
  }

  void measure_areas() {
    std::array<double, kColumns * kRows> all{};
    for (const int i : points_) all[cell_of(i)] += weight(i);
    double total = 0;
    for (const double w : all) total += std::sqrt(w);
    for (const std::size_t h : selected_) {
      std::array<double, kColumns * kRows> own{};
      for (std::size_t k = 0; k < points_.size(); ++k)
        if (owner_[k] == h)
          own[cell_of(points_[k])] += weight(points_[k]) * static_cast<double>(fits_of(h)[k]);
      double area = 0;
      for (const double w : own) area += std::sqrt(w);
      proposals_[h].area = total > 0 ? area / total : 0;
    }
  }
  /// The square root of a cell's sum is its surface, which grows with the square of the depth.
  double weight(int i) const {
    const double z2_m2 = std::pow(std::min(kDepthCap_m, static_cast<double>(depth(i))), 2);
    return static_cast<double>(scene_->static_belief[static_cast<std::size_t>(i)]) * z2_m2 * z2_m2;
  }

  void measure_orders() {
    if (selected_.size() < 2) return;
    tell_apart();
    places_.clear();
    for (const int i : points_) places_.push_back(scene_->pixels[static_cast<std::size_t>(i)]);
    grid_.build(Span<const cv::Point2f>(places_), static_cast<float>(kNeighbour_px));
    std::vector<int>&behind = behind_, &front = front_;
    behind.assign(proposals_.size(), 1);
    front.assign(proposals_.size(), 1);
    for (std::size_t k = 0; k < points_.size(); ++k)
      grid_.around(places_[k], static_cast<float>(kNeighbour_px), [&](std::int32_t j) {
        const auto other = static_cast<std::size_t>(j);
        if (!distinct(owner_[k], owner_[other]) ||
            norm(places_[other].x - places_[k].x, places_[other].y - places_[k].y) > kNeighbour_px)
          return;
        behind[owner_[k]] += depth(points_[k]) > kDepthStep * depth(points_[other]) ? 1 : 0;
        front[owner_[k]] += depth(points_[other]) > kDepthStep * depth(points_[k]) ? 1 : 0;
      });
    for (const std::size_t h : selected_)
      proposals_[h].order = static_cast<double>(behind[h]) / (behind[h] + front[h]);
  }

  /// Which motions differ by more than the noise: points of the others are shared out by chance, and who is
  /// behind whom says nothing.
  void tell_apart() {
    distinct_.assign(proposals_.size() * proposals_.size(), 0);
    for (const std::size_t a : selected_)
      for (const std::size_t b : selected_)
        distinct_[a * proposals_.size() + b] =
            distance_px(a, b, proposals_[a].motion.T_current_reference,
                        proposals_[b].motion.T_current_reference) > kDistinct * noise_px_;
  }

  bool distinct(std::size_t a, std::size_t b) const {
    return selected_.size() > 1 && distinct_[a * proposals_.size() + b] != 0;
  }

  static double norm(double x, double y) { return std::sqrt(x * x + y * y); }  // std::hypot is slow

  /// How far two motions are apart in the image, on average over the points of the proposals a and b [px], at
  /// most 20. Elsewhere a motion is extrapolated: a few far points do not say how near ones would move.
  double distance_px(std::size_t a, std::size_t b, const Pose& A, const Pose& B) const {
    const Eigen::Matrix3d Ra = A.R(), Rb = B.R();
    double sum = 0;
    int n = 0;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      if (owner_[k] != a && owner_[k] != b) continue;
      const cv::Point3f& p = scene_->reference_m[static_cast<std::size_t>(points_[k])];
      const Eigen::Vector3d v(p.x, p.y, p.z), at = Ra * v + A.t(), bt = Rb * v + B.t();
      const double miss =
          scene_->camera.fx_px * norm(at.x() / at.z() - bt.x() / bt.z(), at.y() / at.z() - bt.y() / bt.z());
      sum += miss < 20 ? miss : 20;
      ++n;
    }
    return n > 0 ? sum / n : 0;
  }

  void learn_smoothness(const Pose& T) {
    constexpr double kRate = 0.2, kMost_px = 6;
    usual_miss_px_ +=
        kRate * (std::min(kMost_px, distance_px(chosen_, chosen_, T, *scene_->expected)) - usual_miss_px_);
  }

  /// On the points that it explains best, or a motion that the noise cannot tell from it, as narrowly as the
  /// noise allows.
  RigidMotion refine_background(std::size_t h) {
    rest_.clear();
    for (std::size_t k = 0; k < points_.size(); ++k)
      if (owner_[k] == h || !distinct(owner_[k], h)) rest_.push_back(points_[k]);
    rigid_.options().pixel_sigma_px = std::max(kLeastRefined_px, noise_px_);
    const RigidMotion motion = rigid_.refine(scene_->camera, scene_->reference_m, scene_->current_m, rest_,
                                             proposals_[h].motion.T_current_reference);
    return motion.ok ? motion : proposals_[h].motion;
  }

  RigidMotionEstimator rigid_;
  const RigidBackgroundScene* scene_ = nullptr;  ///< during estimate() only
  std::array<std::vector<Candidate>, kColumns * kRows> cells_;
  std::vector<Candidate> candidates_;
  std::vector<int> points_, settled_, rest_, behind_, front_;
  std::vector<MotionProposal> proposals_;
  RigidMotion graduated_;
  NeighbourNoise neighbour_noise_;
  MotionSelection selection_;
  RigidMisses misses_;
  std::vector<float> image2_px2_, depth2_, fit_;  ///< proposals x points
  std::vector<float> weights_, prices_;
  std::vector<std::size_t> selected_, owner_;
  std::vector<char> distinct_;  ///< proposals x proposals
  std::vector<char> peeled_;    ///< per proposal
  std::vector<cv::Point2f> places_;
  PointGrid grid_;
  std::size_t chosen_ = 0;
  double match_noise_px_ = kFirstNoise_px, noise_px_ = kFirstNoise_px;
  double usual_miss_px_ = kUnknownMiss_px, confidence_ = 1;
};

}  // namespace dynfilter
