// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

namespace dynfilter {

/// Options of RigidMotionEstimator. Residual of a motion q = R p_reference + t at a point c of the current
/// frame, in standard deviations:
///   (fx (qx/qz - cx/cz), fy (qy/qz - cy/cz)) / pixel sigma, (qz - cz) / sigma_z.
/// sigma_z^2 is the sum of both depths' variances.
struct RigidMotionOptions {
  double pixel_sigma_px = 1.0;  ///< noise of the flow or match between the frames, per axis
  DepthNoise depth_noise{};     ///< noise of both depths
  double inlier_chi2 = 11.345;  ///< inlier bound: 99 % quantile for 3 degrees of freedom
  double loss_scale = 3.5;      ///< of Tukey's robust loss (ceres::TukeyLoss), in standard deviations
  double confidence = 0.99;     ///< probability that at least one sample has no outlier
  int max_iterations = 300;     ///< of random sampling
  int refine_iterations = 10;   ///< at most; stops when the step is below 1e-9
  /// A step of the refinement shorter than this many of its own standard deviations is the last. With a
  /// robust loss the optimum may be a few such steps away.
  double refine_until_sigmas = 0;
  int min_inliers = 6;            ///< fewer inliers: no motion
  double min_inlier_share = 0.2;  ///< share of the seeds with depth; fewer inliers: no motion
  /// The prior pose wins unless another hypothesis has 1 / prior_advantage times its score.
  double prior_advantage = 0.35;
  std::uint64_t seed = 1;
};

namespace detail {
class RigidMotionSearch;
}

/// Whether there is a motion, and why not.
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

/// Result of RigidMotionEstimator.
struct RigidMotion {
  bool ok = false;
  RigidMotionNote note = RigidMotionNote::TooFewPoints;
  Pose T_current_reference;  ///< p_current = R p_reference + t
  /// Row-major covariance of a left perturbation (translation [m], rotation [rad]), p = exp(rotation) (R
  /// p_reference + t) + translation. It is the inverse normal matrix under the assumed noise.
  /// Multiply it by max(1, sigma0^2) if the assumed noise may be too small.
  std::array<double, 36> covariance{};
  double sigma0 = 0;        ///< sqrt(sum w chi2 / (sum 3 w - 6)); 1 if the assumed noise is correct
  int points = 0;           ///< seeds with depth in both frames
  int inliers = 0;          ///< inliers among `points`
  int iterations = 0;       ///< samples drawn
  bool from_prior = false;  ///< true if the prior pose won
};

/// Relative rigid motion from 3D-3D correspondences. Seeded RANSAC over triples in closed form, with
/// noise-whitened scores, bail-out and local optimisation (Chum, Matas and Kittler, DAGM 2003). Robust least
/// squares follow (rigid_least_squares.hpp). Reuses its buffers: no allocation after the largest input. Cost:
/// about 20 us + 30 us for 1000 points.
class RigidMotionEstimator {
 public:
  explicit RigidMotionEstimator(const RigidMotionOptions& options = {});
  RigidMotionEstimator(RigidMotionEstimator&&) noexcept;
  RigidMotionEstimator& operator=(RigidMotionEstimator&&) noexcept;
  ~RigidMotionEstimator();

  RigidMotionOptions& options() { return *options_; }
  const RigidMotionOptions& options() const { return *options_; }

  /// Points are in the camera frames [m], z forward. z <= 0 or not finite means no point.
  /// Both spans have the same size. `seeds` are indices into them; indices out of range are ignored.
  /// The camera's focal lengths convert pixel noise to metres. Unusual data never throws.
  RigidMotion estimate(const Camera& camera, Span<const cv::Point3f> reference,
                       Span<const cv::Point3f> current, Span<const int> seeds,
                       const std::optional<Pose>& prior = std::nullopt);

  /// Least squares only, on all seeds with depth; points as above. `start`, a T_current_reference, must be
  /// within the range of the robust loss.
  RigidMotion refine(const Camera& camera, Span<const cv::Point3f> reference, Span<const cv::Point3f> current,
                     Span<const int> seeds, const Pose& start);

 private:
  std::unique_ptr<RigidMotionOptions> options_;
  std::unique_ptr<detail::RigidMotionSearch> search_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/geometry/detail/rigid_motion-inl.hpp>
#endif
