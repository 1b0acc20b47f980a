// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/rigid_motion.hpp>

#include <Eigen/Geometry>
#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/geometry/rigid_least_squares.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <limits>

namespace dynfilter {

namespace detail {

/// Implementation of RigidMotionEstimator.
class RigidMotionSearch {
 public:
  explicit RigidMotionSearch(const RigidMotionOptions& options) : options_(options) {}

  RigidMotion estimate(const Camera& camera, Span<const cv::Point3f> reference,
                       Span<const cv::Point3f> current, Span<const int> seeds,
                       const std::optional<Pose>& prior) {
    RigidMotion result;
    points_.pack(camera, noise(), reference, current, seeds);
    result.points = static_cast<int>(points_.count);
    if (points_.count < 3 || result.points < options_.min_inliers) return result;
    result.note = RigidMotionNote::Degenerate;
    search(prior, result);
    if (!has_best_) return result;
    result.note = RigidMotionNote::NoConsensus;
    refine(best_, options_.refine_iterations, kAll);
    finish(result);
    return result;
  }

  RigidMotion refine(const Camera& camera, Span<const cv::Point3f> reference, Span<const cv::Point3f> current,
                     Span<const int> seeds, const Pose& start) {
    RigidMotion result;
    points_.pack(camera, noise(), reference, current, seeds);
    result.points = static_cast<int>(points_.count);
    if (points_.count < 3 || result.points < options_.min_inliers) return result;
    best_ = {start.R(), start.t()};
    result.note = RigidMotionNote::NoConsensus;
    refine(best_, options_.refine_iterations, kAll);
    finish(result);
    return result;
  }

 private:
  using Hypothesis = RigidTransform;

  RigidNoise noise() const { return {options_.pixel_sigma_px, options_.depth_noise}; }

  void search(const std::optional<Pose>& prior, RigidMotion& result) {
    SampleGenerator rng(options_.seed);
    has_best_ = false;
    best_score_ = 0;
    double advantage = 1;
    if (prior && all_finite(prior->rotation.data(), 9) && all_finite(prior->translation_m.data(), 3)) {
      Hypothesis candidate{prior->R(), prior->t()};
      // Narrow, because a wider reach favours a majority of movers.
      refine(candidate, 3, kLocalSize);
      consider(candidate, 1);
      advantage = has_best_ ? 1 / options_.prior_advantage : 1;
      result.from_prior = has_best_;
    }
    const auto try_sample = [&](int /*k*/) {
      Hypothesis candidate;
      if (!draw(rng, candidate) || !consider(candidate, advantage)) return -1.0;
      advantage = 1;
      result.from_prior = false;
      for (int round = 0; round < 2; ++round) {
        refine(candidate, 1, kLocalSize);
        consider(candidate, 1);
      }
      return best_share();
    };
    result.iterations = robust_search({3, options_.confidence, options_.max_iterations},
                                      has_best_ ? best_share() : 0, try_sample);
  }

  double best_share() const {
    return points_.inliers(best_, static_cast<float>(options_.inlier_chi2)) /
           static_cast<double>(points_.count);
  }

  /// Accepts the hypothesis if its score is `advantage` times the best one.
  bool consider(const Hypothesis& candidate, double advantage) {
    const float limit = static_cast<float>(options_.inlier_chi2);
    const double floor = best_score_ * advantage;
    const double score = points_.score(candidate, limit, floor);
    if (score <= 0 || score <= floor) return false;
    has_best_ = true;
    best_ = candidate;
    best_score_ = score;
    return true;
  }

  bool draw(SampleGenerator& rng, Hypothesis& candidate) const {
    std::uint32_t pick[3];
    sample_distinct(rng, static_cast<std::uint32_t>(points_.count), pick, 3);
    return points_.solve_triple(pick, candidate);
  }

  static constexpr std::size_t kLocalSize = 128;  ///< points used by a local optimisation
  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

  void refine(Hypothesis& hypothesis, int iterations, std::size_t count) {
    refine_rigid(points_, options_.loss_scale, iterations, options_.refine_until_sigmas, count, hypothesis,
                 normal_);
  }

  void finish(RigidMotion& result) const {
    if (!all_finite(best_.R.data(), 9) || !all_finite(best_.t.data(), 3)) return;
    result.T_current_reference = Pose::from(best_.R, best_.t);
    result.inliers = points_.inliers(best_, static_cast<float>(options_.inlier_chi2));
    result.sigma0 = normal_.weight_sum > 2 ? std::sqrt(normal_.cost / (3 * normal_.weight_sum - 6)) : 0;
    if (!invert_positive_definite(normal_.matrix.data(), result.covariance.data(), 6)) {
      result.note = RigidMotionNote::Degenerate;
      return;
    }
    result.ok = result.inliers >= options_.min_inliers &&
                result.inliers >= options_.min_inlier_share * static_cast<double>(points_.count);
    if (result.ok) result.note = RigidMotionNote::Ok;
  }

  const RigidMotionOptions& options_;
  RigidPoints points_;
  RigidNormal normal_;
  Hypothesis best_;
  double best_score_ = 0;
  bool has_best_ = false;
};

}  // namespace detail

DYNFILTER_INLINE RigidMotionEstimator::RigidMotionEstimator(const RigidMotionOptions& options)
    : options_(std::make_unique<RigidMotionOptions>(options)),
      search_(std::make_unique<detail::RigidMotionSearch>(*options_)) {}
DYNFILTER_INLINE RigidMotionEstimator::RigidMotionEstimator(RigidMotionEstimator&&) noexcept = default;
DYNFILTER_INLINE RigidMotionEstimator& RigidMotionEstimator::operator=(RigidMotionEstimator&&) noexcept =
    default;
DYNFILTER_INLINE RigidMotionEstimator::~RigidMotionEstimator() = default;
DYNFILTER_INLINE RigidMotion RigidMotionEstimator::estimate(const Camera& camera,
                                                            Span<const cv::Point3f> reference,
                                                            Span<const cv::Point3f> current,
                                                            Span<const int> seeds,
                                                            const std::optional<Pose>& prior) {
  return search_->estimate(camera, reference, current, seeds, prior);
}
DYNFILTER_INLINE RigidMotion RigidMotionEstimator::refine(const Camera& camera,
                                                          Span<const cv::Point3f> reference,
                                                          Span<const cv::Point3f> current,
                                                          Span<const int> seeds, const Pose& start) {
  return search_->refine(camera, reference, current, seeds, start);
}

}  // namespace dynfilter
