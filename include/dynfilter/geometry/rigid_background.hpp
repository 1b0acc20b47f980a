// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
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
  double noise_px = 0.12;                          ///< of the correspondences, per axis
};

/// One rigid motion that some of the points follow.
struct MotionProposal {
  enum class From { Expected, Predicted, Support };
  From from = From::Support;
  RigidMotion motion;
  double sigma_px = 0;  ///< it was fitted with this noise
  double area = 0;      ///< share of the image whose points it explains best
  double order = 0.5;   ///< share of the neighbouring points of other motions that lie nearer
  double score = 0;     ///< log-probability of being the background, up to a constant
};

/// The motion of the background between two frames, when most points may lie on movers.
///
/// Several motions are proposed: from what the camera did before (refined at three widths), from the host,
/// and from support (RANSAC on all points, then on the rest; where nothing is expected yet on the far points
/// first, where movers are few; and on, with more samples, where nobody explains 15 % of the points, as in a
/// blurred frame). A small set of them that explains all points is kept (greedy with pruning),
/// so that a compromise between background and mover, which explains everything a little, loses against the
/// pair that explains everything well; each point belongs to the motion that explains it best. The background
/// is then chosen not by head count but by
///   log(area) - log(1 + d^2) + 2.5 (order - 1/2),
/// with area the share of image cells (square roots of what they hold, weighted by depth and by what was
/// static before; a motion that explains less than 4 % of the points is chosen only if none explains more), d
/// the distance in the image from the expected motion in units of how far off it usually is, and order the
/// share of neighbours on other motions that lie in front: movers hide the background, the background hides
/// movers less often. What moved lately is left out where the expected motion is refined: movers that slow
/// down and set off again would drag it along otherwise.
///
/// Works on at most four points per cell of a 16 x 12 grid, the far ones. Owns its scratch. Not for several
/// threads at once. About 0.2 ms for 1000 features.
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
  /// Points that were looked at.
  std::size_t points() const { return points_.size(); }
  /// Forgets how smoothly the camera moves.
  void reset() { usual_miss_px_ = kUnknownMiss_px; }

 private:
  static constexpr int kColumns = 16, kRows = 12;
  static constexpr std::size_t kPerCell = 4, kMinSettled = 30;
  static constexpr double kWide_px = 0.8, kSupport_px = 0.25;
  static constexpr double kFit_px = 0.3;        ///< a fit is worth 1 / (1 + (miss / this)^2)
  static constexpr double kMinGain = 0.04;      ///< of the points: what a motion must explain to be kept
  static constexpr float kExplained = 0.1F;     ///< a fit from which on a point is explained: 3 kFit_px
  static constexpr double kFarShare = 0.4;      ///< of the points: those at the back
  static constexpr int kFirstSearch = 150;      ///< samples; of what is expected to be left, or far
  static constexpr int kSearch = 75;            ///< of the searches from the beginning, which come on top
  static constexpr double kPoorShare = 0.15;    ///< of the points: when the best motion explains less ...
  static constexpr int kPatientSearch = 600;    ///< ... the search goes on with so many samples
  static constexpr double kSettled = 0.7;       ///< explained by the expected motion: no search
  static constexpr double kOrderWeight = 2.5;   ///< of who hides whom against who covers more
  static constexpr double kNeighbour_px = 50;   ///< whose depths are compared
  static constexpr float kDepthStep = 1.08F;    ///< farther by this factor lies behind
  static constexpr double kUnknownMiss_px = 3;  ///< before anything is known of the camera's smoothness
  static constexpr double kLeastMiss_px = 0.15, kDepthCap_m = 4;

  struct Candidate {
    float depth_m;  ///< beside the index, so that sorting does not look it up
    int index;
  };

  RigidMotion estimate_of_scene() {
    proposals_.clear();
    chosen_ = 0;
    sample_evenly();
    propose_known();
    propose_by_support();
    if (proposals_.empty()) return {};
    measure_fits();
    if (most_explained() < kPoorShare * static_cast<double>(points_.size())) search_patiently();
    select();
    assign();
    const RigidMotion motion = refine_background(choose());
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
    return has_depth(p.z) && std::isfinite(p.x) && std::isfinite(p.y);
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

  void propose_known() {
    if (scene_->predicted) propose(MotionProposal::From::Predicted, points_, kSupport_px, scene_->predicted);
    if (!scene_->expected) return;
    for (const double sigma_px : {scene_->noise_px, 2.5 * scene_->noise_px, kWide_px})
      propose(MotionProposal::From::Expected, settled(), sigma_px, scene_->expected);
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

  /// What the expected motion leaves, or the far points; and then all from the beginning, narrow and wide.
  void propose_by_support() {
    rigid_.options().max_iterations = kFirstSearch;
    rest_ = points_;
    if (scene_->expected && !proposals_.empty()) {
      drop_explained(narrow_expected().motion);
      if (static_cast<double>(rest_.size()) < (1 - kSettled) * static_cast<double>(points_.size())) return;
      if (10 * rest_.size() > points_.size())
        propose(MotionProposal::From::Support, rest_, kSupport_px, std::nullopt);
    }
    if (!scene_->expected) propose_from_afar();
    rigid_.options().max_iterations = kSearch;
    for (const double sigma_px : {kSupport_px, kWide_px}) {
      rest_ = points_;
      for (int k = 0; k < 3 && rest_.size() >= 12 && 10 * rest_.size() > points_.size(); ++k) {
        if (!propose(MotionProposal::From::Support, rest_, sigma_px, std::nullopt)) break;
        drop_explained(proposals_.back().motion);
      }
    }
  }

  /// `points_` begins with the farthest. Among all of them a small background is drawn too rarely when movers
  /// fill the view from the first frame on; and a motion between theirs and its own has more support. Their
  /// depth is poor, so not where it is known what the camera does: a sloppy fit would win by lying behind.
  void propose_from_afar() {
    const auto far = static_cast<std::ptrdiff_t>(kFarShare * static_cast<double>(points_.size()));
    rest_.assign(points_.begin(), points_.begin() + far);
    if (rest_.size() >= 12) propose(MotionProposal::From::Support, rest_, kSupport_px, std::nullopt);
  }

  /// Proposed first of the expected ones; without it, whatever comes first.
  const MotionProposal& narrow_expected() const {
    for (const MotionProposal& p : proposals_)
      if (p.from == MotionProposal::From::Expected) return p;
    return proposals_.front();
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

  /// visit(k, chi2 at a noise of `sigma_px`) for the k-th of `points`.
  template <class Visit>
  void for_misses(const std::vector<int>& points, const Pose& T, double sigma_px, const Visit& visit) const {
    const Eigen::Matrix3f R = T.R().cast<float>();
    const Eigen::Vector3f t = T.t().cast<float>();
    const auto fx = static_cast<float>(scene_->camera.fx_px / sigma_px),
               fy = static_cast<float>(scene_->camera.fy_px / sigma_px);
    const DepthNoise noise;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const cv::Point3f &p = scene_->reference_m[static_cast<std::size_t>(points[k])],
                        &c = scene_->current_m[static_cast<std::size_t>(points[k])];
      const Eigen::Vector3f q = R * Eigen::Vector3f(p.x, p.y, p.z) + t;
      const float u = fx * (q.x() / q.z() - c.x / c.z), v = fy * (q.y() / q.z() - c.y / c.z);
      const auto s1 = static_cast<float>(noise.sigma_m(c.z)), s2 = static_cast<float>(noise.sigma_m(p.z));
      const float w2 = (q.z() - c.z) * (q.z() - c.z) / (s1 * s1 + s2 * s2);
      visit(k, q.z() > 0 ? u * u + v * v + w2 : 1e9F);
    }
  }

  void drop_explained(const RigidMotion& motion) {
    std::size_t left = 0;
    scratch_ = rest_;
    for_misses(scratch_, motion.T_current_reference, rigid_.options().pixel_sigma_px,
               [&](std::size_t k, float chi2) {
                 if (!(chi2 < static_cast<float>(rigid_.options().inlier_chi2))) rest_[left++] = scratch_[k];
               });
    rest_.resize(left);
  }

  // ---- which motions are needed
  const float* fits_of(std::size_t h) const { return fit_.data() + h * points_.size(); }

  void measure_fits() {
    fit_.resize(proposals_.size() * points_.size());
    float* row = fit_.data();
    for (const MotionProposal& p : proposals_) {
      for_misses(points_, p.motion.T_current_reference, kFit_px,
                 [&](std::size_t k, float chi2) { row[k] = 1 / (1 + chi2); });
      row += points_.size();
    }
  }

  int most_explained() const {
    std::ptrdiff_t most = 0;
    for (std::size_t h = 0; h < proposals_.size(); ++h)
      most = std::max(most, std::count_if(fits_of(h), fits_of(h) + points_.size(),
                                          [](float fit) { return fit >= kExplained; }));
    return static_cast<int>(most);
  }
  /// A blurred frame: few points can be explained at all, and three of them are drawn together too rarely.
  void search_patiently() {
    rigid_.options().max_iterations = kPatientSearch;
    for (const double sigma_px : {kSupport_px, kWide_px})
      propose(MotionProposal::From::Support, points_, sigma_px, std::nullopt);
    measure_fits();
  }

  float gain(std::size_t h) const {
    float sum = 0;
    const float* row = fits_of(h);
    for (std::size_t k = 0; k < points_.size(); ++k) sum += std::max(0.0F, row[k] - best_fit_[k]);
    return sum;
  }
  void explain(std::size_t h) {
    const float* row = fits_of(h);
    for (std::size_t k = 0; k < points_.size(); ++k) best_fit_[k] = std::max(best_fit_[k], row[k]);
  }

  /// The narrow expected motion always takes part: few static points may be left of a crowded view.
  void select() {
    selected_.clear();
    best_fit_.assign(points_.size(), 0);
    for (std::size_t h = 0; h < proposals_.size() && selected_.empty(); ++h)
      if (proposals_[h].from == MotionProposal::From::Expected) take(h);
    const std::size_t fixed = selected_.size();
    const float least = static_cast<float>(kMinGain) * static_cast<float>(points_.size());
    while (selected_.size() < proposals_.size()) {
      std::size_t best = 0;
      float most = -1;
      for (std::size_t h = 0; h < proposals_.size(); ++h)
        if (const float more = gain(h); more > most) most = more, best = h;
      if (most < least && !selected_.empty()) break;
      take(best);
    }
    while (selected_.size() > std::max<std::size_t>(1, fixed) && prune(fixed, least)) {
    }
  }
  void take(std::size_t h) {
    selected_.push_back(h);
    explain(h);
  }
  /// Drops the motion that is missed least, if it is missed too little.
  bool prune(std::size_t fixed, float least) {
    std::size_t worst = selected_.size();
    for (std::size_t s = fixed; s < selected_.size(); ++s) {
      best_fit_.assign(points_.size(), 0);
      for (std::size_t other = 0; other < selected_.size(); ++other)
        if (other != s) explain(selected_[other]);
      if (const float missed = gain(selected_[s]); missed < least) least = missed, worst = s;
    }
    if (worst == selected_.size()) return false;
    selected_.erase(selected_.begin() + static_cast<std::ptrdiff_t>(worst));
    return true;
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
      p.score = std::log(p.area + 1e-6) + kOrderWeight * (p.order - 0.5);
      if (scene_->expected) {
        const double d = distance_px(p.motion.T_current_reference, *scene_->expected) /
                         std::max(kLeastMiss_px, 2 * usual_miss_px_);
        p.score -= std::log1p(d * d);
      }
    }
    const auto rank = [&](std::size_t h) { return std::make_pair(explains_enough(h), proposals_[h].score); };
    chosen_ = *std::max_element(selected_.begin(), selected_.end(),
                                [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
    return chosen_;
  }
  /// A handful of points is not the background, as near to what was expected as it may move; nor is what owns
  /// many points, all of them badly, because nobody explains them.
  bool explains_enough(std::size_t h) const {
    int explained = 0;
    for (std::size_t k = 0; k < points_.size(); ++k)
      if (owner_[k] == h && fits_of(h)[k] >= kExplained) ++explained;
    return explained >= kMinGain * static_cast<double>(points_.size());
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
  double weight(int i) const {
    return static_cast<double>(scene_->static_belief[static_cast<std::size_t>(i)]) *
           std::min(kDepthCap_m, static_cast<double>(depth(i)));
  }

  void measure_orders() {
    if (selected_.size() < 2) return;
    places_.clear();
    for (const int i : points_) places_.push_back(scene_->pixels[static_cast<std::size_t>(i)]);
    grid_.build(Span<const cv::Point2f>(places_), static_cast<float>(kNeighbour_px));
    std::vector<int>&behind = behind_, &front = front_;
    behind.assign(proposals_.size(), 1);
    front.assign(proposals_.size(), 1);
    for (std::size_t k = 0; k < points_.size(); ++k)
      grid_.around(places_[k], static_cast<float>(kNeighbour_px), [&](std::int32_t j) {
        const auto other = static_cast<std::size_t>(j);
        if (owner_[other] == owner_[k] ||
            norm(places_[other].x - places_[k].x, places_[other].y - places_[k].y) > kNeighbour_px)
          return;
        behind[owner_[k]] += depth(points_[k]) > kDepthStep * depth(points_[other]) ? 1 : 0;
        front[owner_[k]] += depth(points_[other]) > kDepthStep * depth(points_[k]) ? 1 : 0;
      });
    for (const std::size_t h : selected_)
      proposals_[h].order = static_cast<double>(behind[h]) / (behind[h] + front[h]);
  }

  static double norm(double x, double y) { return std::sqrt(x * x + y * y); }  // std::hypot is slow

  /// How far two motions are apart in the image, on average [px], at most 20.
  double distance_px(const Pose& A, const Pose& B) const {
    const Eigen::Matrix3d Ra = A.R(), Rb = B.R();
    double sum = 0;
    int n = 0;
    for (std::size_t k = 0; k < points_.size(); k += 4) {
      const cv::Point3f& p = scene_->reference_m[static_cast<std::size_t>(points_[k])];
      const Eigen::Vector3d v(p.x, p.y, p.z), a = Ra * v + A.t(), b = Rb * v + B.t();
      const double miss =
          scene_->camera.fx_px * norm(a.x() / a.z() - b.x() / b.z(), a.y() / a.z() - b.y() / b.z());
      sum += miss < 20 ? miss : 20;
      ++n;
    }
    return n > 0 ? sum / n : 0;
  }

  void learn_smoothness(const Pose& T) {
    constexpr double kRate = 0.2, kMost_px = 6;
    usual_miss_px_ += kRate * (std::min(kMost_px, distance_px(T, *scene_->expected)) - usual_miss_px_);
  }

  /// On the points that it explains best, as narrowly as it was found.
  RigidMotion refine_background(std::size_t h) {
    rest_.clear();
    for (std::size_t k = 0; k < points_.size(); ++k)
      if (owner_[k] == h) rest_.push_back(points_[k]);
    rigid_.options().pixel_sigma_px = proposals_[h].sigma_px;
    const RigidMotion motion = rigid_.refine(scene_->camera, scene_->reference_m, scene_->current_m, rest_,
                                             proposals_[h].motion.T_current_reference);
    return motion.ok ? motion : proposals_[h].motion;
  }

  RigidMotionEstimator rigid_;
  const RigidBackgroundScene* scene_ = nullptr;  ///< during estimate() only
  std::array<std::vector<Candidate>, kColumns * kRows> cells_;
  std::vector<Candidate> candidates_;
  std::vector<int> points_, settled_, rest_, scratch_, behind_, front_;
  std::vector<MotionProposal> proposals_;
  std::vector<float> fit_, best_fit_;  ///< proposals x points; points
  std::vector<std::size_t> selected_, owner_;
  std::vector<cv::Point2f> places_;
  PointGrid grid_;
  std::size_t chosen_ = 0;
  double usual_miss_px_ = kUnknownMiss_px;
};

}  // namespace dynfilter
