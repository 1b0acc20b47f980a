// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/rigid_least_squares.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

struct RigidMotionOptions {
  RigidResidualKind residual = RigidResidualKind::ImageDepth;
  RobustLoss loss = RobustLoss::Tukey;
  double pixel_sigma_px = 1.0;    ///< noise of the flow or match from frame to frame, per axis
  DepthNoise depth_noise{};       ///< of both depths
  double inlier_chi2 = 11.345;    ///< a point agrees below this; 3 degrees of freedom, 99 %
  double loss_scale = 3.5;        ///< of the robust loss, in standard deviations
  double confidence = 0.99;       ///< of having drawn one sample without outliers
  int max_iterations = 300;       ///< of the random sampling
  int refine_iterations = 10;     ///< at most; stops when the step is below 1e-9
  int min_inliers = 6;            ///< fewer: no motion
  double min_inlier_share = 0.2;  ///< of the seeds with depth; fewer: no motion
  /// Count occupied image cells (8x8, damped by the square root of what a cell holds) instead of heads: a
  /// compact mover that holds most features then does not outvote the background around it.
  bool spread_score = false;
  /// The prior pose wins unless another hypothesis has 1/this times its score.
  double prior_advantage = 0.35;
  std::uint64_t seed = 1;
};

enum class RigidMotionNote { Ok, TooFewPoints, Degenerate, NoConsensus };

inline const char* to_string(RigidMotionNote note) {
  switch (note) {
    case RigidMotionNote::Ok:
      return "ok";
    case RigidMotionNote::TooFewPoints:
      return "too few seeds with depth in both frames";
    case RigidMotionNote::Degenerate:
      return "the seeds are collinear or coincide";
    case RigidMotionNote::NoConsensus:
      return "no motion explains enough seeds";
  }
  return "";
}

struct RigidMotion {
  bool ok = false;
  RigidMotionNote note = RigidMotionNote::TooFewPoints;
  Pose T_current_reference;  ///< p_current = R p_reference + t
  /// Row-major covariance of (translation [m], rotation [rad]) of a perturbation from the left,
  /// p = exp(rotation) (R p_reference + t) + translation: the inverse normal matrix under the stated noise.
  /// Multiply by max(1, sigma0^2) if the noise may be understated.
  std::array<double, 36> covariance{};
  double sigma0 = 0;        ///< sqrt(sum w chi2 / (sum 3 w - 6)): 1 when the stated noise is the true one
  int points = 0;           ///< seeds with depth in both frames
  int inliers = 0;          ///< of these
  int iterations = 0;       ///< samples drawn
  bool from_prior = false;  ///< the prior pose won
};

/// Relative rigid motion from 3D-3D correspondences: seeded RANSAC over triples (closed form) with
/// noise-whitened scores, bail-out and local optimisation (Chum, Matas and Kittler, DAGM 2003), then robust
/// least squares (see rigid_least_squares.hpp). Owns its scratch: no allocation once it has seen the largest
/// input. About 20 us + 30 us for 1000 points.
class RigidMotionEstimator {
 public:
  explicit RigidMotionEstimator(const RigidMotionOptions& options = {}) : options_(options) {}

  RigidMotionOptions& options() { return options_; }
  const RigidMotionOptions& options() const { return options_; }

  /// Points in the camera frames [m], z forward; z <= 0 or not finite: none. Both spans have the same size,
  /// `seeds` holds indices into them (out-of-range ones are ignored). The camera's focal lengths turn pixel
  /// noise into metres. Never throws on odd data.
  RigidMotion estimate(const Camera& camera, Span<const cv::Point3f> reference,
                       Span<const cv::Point3f> current, Span<const int> seeds,
                       const std::optional<Pose>& prior = std::nullopt) {
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

  /// Least squares alone, from a start within the reach of the loss, on all seeds with depth.
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
  using Hypothesis = detail::RigidTransform;

  detail::RigidNoise noise() const {
    return {options_.residual, options_.pixel_sigma_px, options_.depth_noise};
  }

  void search(const std::optional<Pose>& prior, RigidMotion& result) {
    Rng rng(options_.seed);
    has_best_ = false;
    best_score_ = 0;
    double advantage = 1;
    int needed = options_.max_iterations;
    if (prior && prior->R().allFinite() && prior->t().allFinite()) {
      Hypothesis candidate{prior->R(), prior->t()};
      refine(candidate, 3, kLocalSize);  // narrow: a wider reach would hand it to a majority of movers
      consider(candidate, 1, needed);
      advantage = has_best_ ? 1 / options_.prior_advantage : 1;
      result.from_prior = has_best_;
    }
    for (result.iterations = 0; result.iterations < needed; ++result.iterations) {
      Hypothesis candidate;
      if (!draw(rng, candidate)) continue;
      if (!consider(candidate, advantage, needed)) continue;
      advantage = 1;
      result.from_prior = false;
      for (int round = 0; round < 2; ++round) {
        refine(candidate, 1, kLocalSize);
        consider(candidate, 1, needed);
      }
    }
  }

  /// Takes the hypothesis if it beats the best one `advantage` times.
  bool consider(const Hypothesis& candidate, double advantage, int& needed) {
    const float limit = static_cast<float>(options_.inlier_chi2);
    const double floor = best_score_ * advantage;
    double score = points_.score(candidate, limit, options_.spread_score ? 0 : floor);
    if (score <= 0) return false;
    if (options_.spread_score) score = points_.spread_score(candidate, limit);
    if (score <= floor) return false;
    has_best_ = true;
    best_ = candidate;
    best_score_ = score;
    const double share = points_.inliers(candidate, limit) / static_cast<double>(points_.count);
    needed = ransac_iterations(share, 3, options_.confidence, options_.max_iterations);
    return true;
  }

  bool draw(Rng& rng, Hypothesis& candidate) const {
    std::uint32_t pick[3];
    sample_distinct(rng, static_cast<std::uint32_t>(points_.count), pick, 3);
    return points_.solve_triple(pick, candidate);
  }

  static constexpr std::size_t kLocalSize = 128;  ///< points that a local optimisation looks at
  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

  void refine(Hypothesis& hypothesis, int iterations, std::size_t count) {
    detail::refine_rigid(points_, options_.loss, options_.loss_scale, iterations, count, hypothesis, normal_);
  }

  void finish(RigidMotion& result) const {
    if (!best_.R.allFinite() || !best_.t.allFinite()) return;
    result.T_current_reference = Pose::from(best_.R, best_.t);
    result.inliers = points_.inliers(best_, static_cast<float>(options_.inlier_chi2));
    result.sigma0 = normal_.weight_sum > 2 ? std::sqrt(normal_.cost / (3 * normal_.weight_sum - 6)) : 0;
    const Eigen::Matrix<double, 6, 6> normal = normal_.matrix();
    if (!detail::invert_positive_definite(normal.data(), result.covariance.data(), 6)) {
      result.note = RigidMotionNote::Degenerate;
      return;
    }
    result.ok = result.inliers >= options_.min_inliers &&
                result.inliers >= options_.min_inlier_share * static_cast<double>(points_.count);
    if (result.ok) result.note = RigidMotionNote::Ok;
  }

  RigidMotionOptions options_;
  detail::RigidPoints points_;
  detail::RigidNormal normal_;
  Hypothesis best_;
  double best_score_ = 0;
  bool has_best_ = false;
};

}  // namespace dynfilter
