// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/two_view.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/geometry/detail/two_view_decision.hpp>
#include <dynfilter/geometry/detail/two_view_points.hpp>
#include <dynfilter/geometry/detail/two_view_refine.hpp>
#include <dynfilter/geometry/detail/two_view_solvers.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <vector>

namespace dynfilter {

namespace detail {

/// Implementation of TwoViewEstimator.
class TwoViewSearch {
 public:
  explicit TwoViewSearch(const TwoViewOptions& options) : options_(options) {}

  TwoViewModel estimate(Span<const cv::Point2f> reference, Span<const cv::Point2f> current,
                        Span<const int> seeds, const Camera* camera) {
    TwoViewModel model;
    points_.pack(reference, current, seeds);
    model.seeds = static_cast<int>(points_.count());
    if (points_.count() < 8 || model.seeds < options_.min_seeds) return model;
    model.reason = TwoViewReason::CollinearSeeds;
    if (points_.minor_axis_px() < options_.min_spread_px) return model;
    const double tau = options_.max_distance_px * points_.scale();
    tau2_ = tau * tau;
    search_fundamental(model);
    search_homography();
    detail::TwoViewDecision decision(points_, options_, tau2_, camera, scratch_);
    decision.decide(has_F_ ? &F_ : nullptr, has_H_ ? &H_ : nullptr, model);
    return model;
  }

 private:
  static constexpr int kLocalRuns = 25;  ///< optimisations allowed for samples near the best
  static constexpr double kNearBest = 1.03, kNoBetter = -1;
  static constexpr std::size_t kLocalSize = 320;  ///< matches used by a local optimisation

  /// All cuts after a sample; the narrow ones after an optimisation.
  static Span<const double> cuts(std::size_t from = 0) {
    return {detail::kWideToNarrow.data() + from, detail::kWideToNarrow.size() - from};
  }

  void search_fundamental(TwoViewModel& model) {
    SampleGenerator rng(options_.seed);
    has_F_ = false;
    local_runs_ = 0;
    const double count = static_cast<double>(points_.count());
    F_cost_ = sample_cost_ = count * (1 - 0.5 * options_.min_inlier_share);
    const auto try_sample_of_seven = [&](int i) {
      std::uint32_t pick[7];
      points_.sample(rng, i % 2 == 0, 7, pick);
      Eigen::Vector2d p1[7], p2[7];
      for (int k = 0; k < 7; ++k) p1[k] = points_.reference(pick[k]), p2[k] = points_.current(pick[k]);
      Eigen::Matrix3d candidates[4];
      const int n = detail::solve_seven(p1, p2, candidates);
      bool better = false;
      for (int c = 0; c < n; ++c)
        better |= detail::oriented(candidates[c], p1, p2) && try_candidate(candidates[c]);
      return better ? points_.inliers(detail::FundamentalError(F_), tau2_) / count : kNoBetter;
    };
    model.iterations =
        robust_search({7, options_.confidence, options_.max_iterations}, 0, try_sample_of_seven);
    if (has_F_) polish();
  }

  /// A sample competes with other samples only.
  /// A sample near the best sample is optimised (Chum, Matas and Kittler, DAGM 2003).
  /// This holds even if an optimised F already has a better score. True if the best F changes.
  bool try_candidate(const Eigen::Matrix3d& sample) {
    const double bound = local_runs_ < kLocalRuns ? kNearBest * sample_cost_ : sample_cost_;
    const double cost = points_.cost(detail::FundamentalError(sample), tau2_, bound);
    if (!(cost < bound)) return false;
    sample_cost_ = std::min(sample_cost_, cost);
    ++local_runs_;
    Eigen::Matrix3d F = sample;
    detail::refine_fundamental(points_, tau2_, cuts(), {kLocalSize}, F);
    const bool changed = consider(sample);
    return consider(F) || changed;
  }

  void polish() {
    for (int round = 0; round < 5; ++round) {
      Eigen::Matrix3d F = F_;
      detail::refine_fundamental(points_, tau2_, cuts(2), {}, F);
      const double before = F_cost_;
      if (!consider(F) || F_cost_ > 0.998 * before) break;
    }
  }

  bool consider(const Eigen::Matrix3d& F) {
    const double cost = points_.cost(detail::FundamentalError(F), tau2_, F_cost_);
    if (!(cost < F_cost_)) return false;
    F_ = F, F_cost_ = cost, has_F_ = true;
    return true;
  }

  /// Four-point samples from the matches that F explains, or from all seeds without F.
  /// Homographies below `min_plane_share` of F's support are not searched for.
  /// In a general scene the search therefore ends early.
  void search_homography() {
    has_H_ = false;
    members_.clear();
    auto keep = [&](std::size_t i, float e) {
      if (e <= tau2_) members_.push_back(static_cast<std::uint32_t>(i));
    };
    if (has_F_) points_.visit(detail::FundamentalError(F_), keep);
    if (members_.size() < 8) {
      members_.resize(points_.count());
      for (std::uint32_t i = 0; i < members_.size(); ++i) members_[i] = i;
    }
    SampleGenerator rng(options_.seed + 1);
    const double members = static_cast<double>(members_.size()), count = static_cast<double>(points_.count());
    H_cost_ = count - 0.5 * options_.min_plane_share * members;
    double share = options_.min_plane_share;  // never more samples than for this
    const auto try_sample_of_four = [&](int /*k*/) {
      std::uint32_t pick[4];
      sample_distinct(rng, static_cast<std::uint32_t>(members_.size()), pick, 4);
      Eigen::Vector2d p1[4], p2[4];
      for (int k = 0; k < 4; ++k) {
        p1[k] = points_.reference(members_[pick[k]]), p2[k] = points_.current(members_[pick[k]]);
      }
      Eigen::Matrix3d H;
      if (!detail::solve_four(p1, p2, H) || !consider_homography(H)) return kNoBetter;
      detail::refine_homography(points_, 4 * tau2_, 2, {kLocalSize}, H);
      consider_homography(H);
      share = std::max(share, points_.inliers(detail::HomographyError(H_), tau2_) / members);
      return share;
    };
    robust_search({4, options_.confidence, options_.max_iterations}, share, try_sample_of_four);
    if (!has_H_) return;
    Eigen::Matrix3d H = H_;
    detail::refine_homography(points_, 2 * tau2_, 3, {}, H);
    consider_homography(H);
  }

  bool consider_homography(const Eigen::Matrix3d& H) {
    const double cost = points_.cost(detail::HomographyError(H), tau2_, H_cost_);
    if (!(cost < H_cost_)) return false;
    H_ = H, H_cost_ = cost, has_H_ = true;
    return true;
  }

  const TwoViewOptions& options_;
  detail::TwoViewPoints points_;
  std::vector<float> scratch_;
  std::vector<std::uint32_t> members_;
  Eigen::Matrix3d F_, H_;
  double tau2_ = 0, sample_cost_ = 0, F_cost_ = 0, H_cost_ = 0;
  int local_runs_ = 0;
  bool has_F_ = false, has_H_ = false;
};

}  // namespace detail

DYNFILTER_INLINE TwoViewEstimator::TwoViewEstimator(const TwoViewOptions& options)
    : options_(std::make_unique<TwoViewOptions>(options)),
      search_(std::make_unique<detail::TwoViewSearch>(*options_)) {}
DYNFILTER_INLINE TwoViewEstimator::TwoViewEstimator(TwoViewEstimator&&) noexcept = default;
DYNFILTER_INLINE TwoViewEstimator& TwoViewEstimator::operator=(TwoViewEstimator&&) noexcept = default;
DYNFILTER_INLINE TwoViewEstimator::~TwoViewEstimator() = default;
DYNFILTER_INLINE TwoViewModel TwoViewEstimator::estimate(Span<const cv::Point2f> reference,
                                                         Span<const cv::Point2f> current,
                                                         Span<const int> seeds, const Camera* camera) {
  return search_->estimate(reference, current, seeds, camera);
}

}  // namespace dynfilter
