// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/geometry/depth_noise.hpp>

namespace dynfilter {

/// Residual of a rigid motion q = R p_reference + t at a point c of the current frame,
/// in standard deviations.
/// ImageDepth (used by the odometry):
///   (fx (qx/qz - cx/cz), fy (qy/qz - cy/cz)) / pixel sigma, (qz - cz) / sigma_z.
/// Point: (q - c) / sigma per axis, with lateral sigma = c.z pixel_sigma / f.
/// sigma_z^2 is the sum of both depths' variances.
enum class RigidResidualKind { ImageDepth, Point };

/// Robust losses of a point's squared normalised residual s with scale c.
/// They are defined like ceres::HuberLoss(c), CauchyLoss(c) and TukeyLoss(c).
/// Sources: Huber 1964; Black and Anandan 1996; Beaton and Tukey 1974.
enum class RobustLoss { None, Huber, Cauchy, Tukey };

/// Options of RigidMotionEstimator.
struct RigidMotionOptions {
  RigidResidualKind residual = RigidResidualKind::ImageDepth;
  RobustLoss loss = RobustLoss::Tukey;
  double pixel_sigma_px = 1.0;  ///< noise of the flow or match between the frames, per axis
  DepthNoise depth_noise{};     ///< noise of both depths
  double inlier_chi2 = 11.345;  ///< inlier bound: 99 % quantile for 3 degrees of freedom
  double loss_scale = 3.5;      ///< scale of the robust loss, in standard deviations
  double confidence = 0.99;     ///< probability that at least one sample has no outlier
  int max_iterations = 300;     ///< of random sampling
  int refine_iterations = 10;   ///< at most; stops when the step is below 1e-9
  /// A step of the refinement shorter than this many of its own standard deviations is the last. With a
  /// robust loss the optimum may be a few such steps away.
  double refine_until_sigmas = 0;
  int min_inliers = 6;            ///< fewer inliers: no motion
  double min_inlier_share = 0.2;  ///< share of the seeds with depth; fewer inliers: no motion
  /// Scores occupied image cells (8x8) instead of points.
  /// A cell contributes the square root of its number of points.
  /// A compact mover with most features then does not win against the background around it.
  bool spread_score = false;
  /// The prior pose wins unless another hypothesis has 1 / prior_advantage times its score.
  double prior_advantage = 0.35;
  std::uint64_t seed = 1;
};

}  // namespace dynfilter
