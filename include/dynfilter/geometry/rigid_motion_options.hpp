// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/geometry/depth_noise.hpp>

namespace dynfilter {

/// What a rigid motion q = R p_reference + t leaves at a point c of the current frame, in standard
/// deviations. ImageDepth (the odometry's form): (fx (qx/qz - cx/cz), fy (qy/qz - cy/cz)) / pixel sigma, (qz
/// - cz) / sigma_z. Point: (q - c) / sigma per axis, lateral sigma = c.z pixel_sigma / f. sigma_z^2 is the
/// sum of both depths' variances.
enum class RigidResidualKind { ImageDepth, Point };

/// Robust losses of a point's squared normalised residual s, with scale c (Huber 1964; Black and Anandan
/// 1996; Beaton and Tukey 1974), as ceres::HuberLoss(c) and so on define them.
enum class RobustLoss { None, Huber, Cauchy, Tukey };

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

}  // namespace dynfilter
