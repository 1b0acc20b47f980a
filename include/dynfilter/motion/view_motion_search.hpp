// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/geometry/small_matrix.hpp>
#include <dynfilter/motion/view_motion.hpp>
#include <dynfilter/motion/view_motion_fit.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace dynfilter {

/// What a prior says of the camera's turn over the pairs' gap.
struct ViewTurn {
  std::array<double, 3> rotation_rad{};  ///< as of ViewMotion
  double sigma_rad = 0;                  ///< of each axis
};

/// Limits of the search.
struct ViewMotionOptions {
  double max_distance_px = 1.0;       ///< of an inlier to its epipolar line
  int iterations = 100;               ///< samples of six points, at most
  int min_pairs = 12, min_cells = 5;  ///< with fewer points, or on fewer cells, there is no motion
  /// A turn alone is taken where it has this share of the support, unless more than `parallax_share` of what
  /// it explains flows as parallax does.
  double rotation_share = 0.7, parallax_share = 0.4;
  /// A camera is still if this share of the votes does not flow. Far points alone are fewer, and a car ahead
  /// is one of many cells.
  double rest_share = 0.2;
};

/// The camera's motion from the flow of points of which many may move. The motion whose inliers **cover most
/// of the image** wins, not the one with most inliers. Each of the image's cells has one vote, which its
/// points share. A car with 80 % of the points on a third of the image loses. RANSAC over cells, Gauss-Newton
/// on samples of six points from different cells, Torr and Zisserman's truncated quadratic as support. The
/// last frame's motion is one more hypothesis. Points must flow as in front of both cameras. Where a rotation
/// is supported as well, there is no baseline. Cost: about 0.5 ms for 1000 points. Deterministic; `pairs` in
/// another order may give another motion within the noise, so bring them in an order of their own.
class ViewMotionEstimator {
 public:
  using Options = ViewMotionOptions;

  explicit ViewMotionEstimator(const Options& options = Options()) : options_(options) {}

  /// From the pairs that may carry it (`seeds`). `last`: of the frame before, or of this one (`fresh`) over
  /// another gap: then fewer samples will do. What turns unlike `turn` needs up to twice the support.
  std::optional<ViewMotion> estimate(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds,
                                     const ImageCells<double>& cells, double focal_px,
                                     const std::optional<ViewMotion>& last, bool fresh = false,
                                     const std::optional<ViewTurn>& turn = std::nullopt) {
    if (static_cast<int>(seeds.size()) < options_.min_pairs) return std::nullopt;
    fill_cells(pairs, seeds, cells);
    if (static_cast<int>(occupied_.size()) < options_.min_cells) return std::nullopt;
    if (is_still(pairs)) return ViewMotion{{}, {}, focal_px};
    rng_ = SampleGenerator(kSeed);
    best_support_ = -1;
    turn_ = turn;
    if (turn) {
      ViewMotion turned = last.value_or(ViewMotion{{}, {0, 0, 1}, focal_px});
      turned.rotation_rad = turn->rotation_rad;
      attempt(pairs, turned);
      attempt(pairs, refined(turned, pairs, seeds, weights_, {1.0, 8}));
    }
    if (last) {
      attempt(pairs, *last);
      attempt(pairs, refined(*last, pairs, seeds, weights_, {1.0, 8}));
    }
    const int least = last ? kLeastSamples : options_.iterations;
    const int most = last && fresh ? kLeastSamples : options_.iterations;
    robust_search({kSample, kConfidence, most, least}, best_support_ / votes_, [&](int k) {
      try_sample(pairs, seeds, focal_px, last, k);
      return best_support_ / votes_;
    });
    polish(pairs, seeds);
    try_twin(pairs, seeds);
    return without_needless_baseline(pairs, seeds, focal_px);
  }
  /// Squared distance of a motion's turn from the prior's, in deviations of both.
  static double turn_distance2(const ViewTurn& turn, const ViewMotion& motion, double noise_px) {
    double miss2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double miss = motion.rotation_rad[k] - turn.rotation_rad[k];
      miss2 += miss * miss;
    }
    const double noise_rad = noise_px / motion.focal_px;
    return miss2 / (noise_rad * noise_rad + turn.sigma_rad * turn.sigma_rad);
  }

 private:
  static constexpr int kSample = 6, kScoredPerCell = 4, kLeastSamples = 10;
  static constexpr double kRest_px = 0.2;            ///< flow of a still image: noise of sub-pixel matching
  static constexpr double kLeastParallax_px = 0.02;  ///< where there is no noise to measure
  static constexpr double kConfidence = 0.99;        ///< probability that one sample was of inliers only
  static constexpr double kHopeless = 0.5;  ///< share of the support needed; the fit to all will not reach it
  static constexpr double kRounding = 1e-9;
  static constexpr std::uint64_t kSeed = 0x6d6f6e6f;

  void fill_cells(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds,
                  const ImageCells<double>& cells) {
    in_cell_.build(static_cast<std::size_t>(cells.count()), seeds.size(), [&](std::size_t k) {
      const ViewPair& p = pairs[static_cast<std::size_t>(seeds[k])];
      return static_cast<CellLists::Key>(cells.of(p.x, p.y));
    });
    const auto seed = [&](std::int32_t k) { return seeds[static_cast<std::size_t>(k)]; };
    occupied_.clear();
    scored_.clear();
    weights_.assign(pairs.size(), 0);
    score_weights_.assign(pairs.size(), 0);
    votes_ = 0;
    for (std::size_t c = 0; c < in_cell_.size(); ++c) {
      const Span<const std::int32_t> members = in_cell_[c];
      if (members.empty()) continue;
      occupied_.push_back(static_cast<int>(c));
      const std::size_t n = members.size(), scored = std::min<std::size_t>(n, kScoredPerCell);
      for (const std::int32_t k : members) weights_[static_cast<std::size_t>(seed(k))] = share(n);
      for (std::size_t k = 0; k < scored; ++k) {
        scored_.push_back(seed(members[k * n / scored]));
        score_weights_[static_cast<std::size_t>(scored_.back())] = share(scored);
        votes_ += share(scored);
      }
    }
  }
  /// A cell with one point has half a vote: it may be an outlier.
  static double share(std::size_t points) {
    return 1.0 / static_cast<double>(std::max<std::size_t>(2, points));
  }

  ViewMotion refined(const ViewMotion& start, const std::vector<ViewPair>& pairs,
                     const std::vector<int>& which, const std::vector<double>& weights,
                     const ViewMotionFit::Options& options) {
    fit_.select(pairs, which, weights);
    return fit_.refine(start, options);
  }

  /// Keeps the motion, with the sign of its direction, if it is supported better.
  void attempt(const std::vector<ViewPair>& pairs, ViewMotion motion) {
    const ViewFlowModel model(motion);
    const double inverse = 1 / (options_.max_distance_px * options_.max_distance_px);
    const double factor = agreement(motion);
    double forward = 0, backward = 0, left = votes_;
    for (const int index : scored_) {
      const auto i = static_cast<std::size_t>(index);
      const ViewFlow flow = model(pairs[i]);
      const double ahead = motion.has_baseline() ? std::min(0.0, flow.along_px) : flow.along_px,
                   back = motion.has_baseline() ? std::max(0.0, flow.along_px) : flow.along_px;
      const double across2 = flow.across_px * flow.across_px;
      forward += score_weights_[i] * std::max(0.0, 1 - (across2 + ahead * ahead) * inverse);
      backward += score_weights_[i] * std::max(0.0, 1 - (across2 + back * back) * inverse);
      left -= score_weights_[i];
      if (factor * (std::max(forward, backward) + left) < best_support_ - kRounding)
        return;  // cannot win any more
    }
    if (!(factor * std::max(forward, backward) > best_support_)) return;
    best_support_ = factor * std::max(forward, backward);
    if (backward > forward)
      for (double& c : motion.direction) c = -c;
    best_ = motion;
  }

  /// Factor of the support of a motion: 1 where it turns as the prior says, else down to kOtherTurn.
  double agreement(const ViewMotion& motion) const {
    if (!turn_) return 1;
    const double distance2 = turn_distance2(*turn_, motion, options_.max_distance_px);
    return kOtherTurn + (1 - kOtherTurn) * portable::exp(-distance2 / 2);
  }
  static constexpr double kOtherTurn = 0.5;

  void try_sample(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds, double focal_px,
                  const std::optional<ViewMotion>& last, int attempt_number) {
    const auto cells = static_cast<std::uint32_t>(occupied_.size());
    sample_.clear();
    used_.clear();
    for (int tries = 0; tries < 50 && static_cast<int>(sample_.size()) < kSample; ++tries) {
      const int cell = occupied_[rng_.below(cells)];
      const Span<const std::int32_t> members = in_cell_[static_cast<std::size_t>(cell)];
      const std::int32_t member = members[rng_.below(static_cast<std::uint32_t>(members.size()))];
      const int i = seeds[static_cast<std::size_t>(member)];
      const bool cell_used = cells > 8 && std::find(used_.begin(), used_.end(), cell) != used_.end();
      if (cell_used || std::find(sample_.begin(), sample_.end(), i) != sample_.end()) continue;
      sample_.push_back(i);
      used_.push_back(cell);
    }
    if (static_cast<int>(sample_.size()) < kSample) return;
    ViewMotion start = last && attempt_number % 2 == 1 ? *last : start_motion(focal_px);
    if (!start.has_baseline()) start = start_motion(focal_px);
    attempt(pairs, refined(start, pairs, sample_, {}, {0, 6}));
  }

  /// Forwards twice as often as to either side, up or down.
  ViewMotion start_motion(double focal_px) {
    static constexpr std::array<double, 3> kStarts[5] = {
        {0, 0, 1}, {0.96, 0, 0.29}, {0, 0.96, 0.29}, {-0.96, 0, 0.29}, {0, 0, 1}};
    ViewMotion motion;
    motion.focal_px = focal_px;
    if (turn_) motion.rotation_rad = turn_->rotation_rad;
    motion.direction = kStarts[rng_.below(5)];
    detail::normalise(motion.direction);
    return motion;
  }

  void polish(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds) {
    for (const bool fine : {false, true}) {
      const ViewFlowModel model(best_);
      const double limit = (fine ? 2 : 3) * options_.max_distance_px;
      inliers_.clear();
      for (const int i : seeds)
        if (std::abs(model(pairs[static_cast<std::size_t>(i)]).across_px) < limit) inliers_.push_back(i);
      if (inliers_.size() < 8) return;
      attempt(pairs, refined(best_, pairs, inliers_, weights_, {fine ? 0.3 : 1.0, 6}));
    }
  }

  /// The flow of a plane has two explanations: direction and normal change places (Longuet-Higgins, "The
  /// visual ambiguity of a moving plane", 1984). One of them often puts a part of the plane behind the
  /// camera. Keeps the other one if it is supported better.
  void try_twin(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds) {
    const std::optional<std::array<double, 3>> normal = plane_normal(pairs);
    if (!normal) return;
    const std::array<double, 3>&n = *normal, &c = best_.direction;
    const double support = best_support_;
    ViewMotion twin = best_;
    twin.rotation_rad[0] += n[1] * c[2] - n[2] * c[1];
    twin.rotation_rad[1] += n[2] * c[0] - n[0] * c[2];
    twin.rotation_rad[2] += n[0] * c[1] - n[1] * c[0];
    twin.direction = n;
    detail::normalise(twin.direction);
    attempt(pairs, refined(twin, pairs, scored_, score_weights_, {1.0, 8}));
    if (best_support_ > support) polish(pairs, seeds);
  }

  /// Of the plane through the points that support best_, in steps of the camera: inverse_depth = normal .
  /// ray.
  std::optional<std::array<double, 3>> plane_normal(const std::vector<ViewPair>& pairs) const {
    if (!best_.has_baseline()) return std::nullopt;
    const ViewFlowModel model(best_);
    double products[9] = {}, normal[3] = {};
    for (const int index : scored_) {
      const auto i = static_cast<std::size_t>(index);
      const ViewFlow flow = model(pairs[i]);
      if (!(std::abs(flow.across_px) < options_.max_distance_px)) continue;
      const double ray[3] = {pairs[i].reference_x / best_.focal_px, pairs[i].reference_y / best_.focal_px, 1};
      for (std::size_t r = 0; r < 3; ++r) {
        normal[r] += score_weights_[i] * flow.inverse_depth * ray[r];
        for (std::size_t c = 0; c < 3; ++c) products[3 * r + c] += score_weights_[i] * ray[r] * ray[c];
      }
    }
    if (!detail::solve_positive_definite(products, normal, 3)) return std::nullopt;
    if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0) return std::nullopt;
    return std::array<double, 3>{normal[0], normal[1], normal[2]};
  }

  ViewMotion without_needless_baseline(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds,
                                       double focal_px) {
    const double support = best_support_;
    const ViewMotion with_baseline = best_;
    ViewMotion rotation;
    rotation.focal_px = focal_px;
    rotation.rotation_rad = best_.rotation_rad;
    rotation.direction = {};
    best_support_ = -1;
    attempt(pairs, refined(rotation, pairs, scored_, score_weights_, {1.0, 8}));
    if (best_support_ < kHopeless * options_.rotation_share * support) return with_baseline;
    best_support_ = -1;
    attempt(pairs, rotation);
    attempt(pairs, refined(rotation, pairs, seeds, weights_, {1.0, 8}));
    attempt(pairs, refined(best_, pairs, seeds, weights_, {0.3, 6}));
    const bool turn_will_do = best_support_ >= options_.rotation_share * support &&
                              parallax_share(pairs, with_baseline) < options_.parallax_share;
    return turn_will_do ? best_ : with_baseline;
  }

  /// Nothing flows but what moves itself.
  bool is_still(const std::vector<ViewPair>& pairs) const {
    double at_rest = 0;
    for (const int index : scored_) {
      const auto i = static_cast<std::size_t>(index);
      if (portable::hypot(pairs[i].x - pairs[i].reference_x, pairs[i].y - pairs[i].reference_y) < kRest_px)
        at_rest += score_weights_[i];
    }
    return at_rest > options_.rest_share * votes_;
  }

  /// Share of what the rotation in best_ explains that flows as parallax does, by more than twice the noise.
  /// The noise is that of the distances to the epipolar lines and seldom flows so.
  double parallax_share(const std::vector<ViewPair>& pairs, const ViewMotion& with_baseline) {
    const ViewFlowModel turn(best_), baseline(with_baseline);
    flows_.clear(), distances_.clear();
    for (const int i : scored_) {
      const ViewPair& p = pairs[static_cast<std::size_t>(i)];
      if (!(turn(p).length_px() < options_.max_distance_px)) continue;
      const ViewFlow flow = baseline(p);
      flows_.push_back({flow.along_px, score_weights_[static_cast<std::size_t>(i)]});
      distances_.push_back(std::abs(flow.across_px));
    }
    if (flows_.empty()) return 0;
    const auto half = distances_.begin() + static_cast<std::ptrdiff_t>(distances_.size() / 2);
    std::nth_element(distances_.begin(), half, distances_.end());
    const double limit = std::max(kLeastParallax_px, 2 * 1.4826 * *half);
    double sum = 0, parallax = 0;
    for (const auto& [along, weight] : flows_) {
      sum += weight;
      if (along > limit) parallax += weight;
    }
    return parallax / sum;
  }

  Options options_;
  ViewMotionFit fit_;
  SampleGenerator rng_{kSeed};
  ViewMotion best_;
  double best_support_ = -1, votes_ = 0;
  std::optional<ViewTurn> turn_;
  CellLists in_cell_;  ///< seeds
  std::vector<int> occupied_, scored_, sample_, used_, inliers_;
  std::vector<double> weights_, score_weights_, distances_;
  std::vector<std::pair<double, double>> flows_;  ///< along, weight
};

}  // namespace dynfilter
