// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/rigid_motion_options.hpp>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

namespace dynfilter {

namespace detail {
class RigidMotionSearch;
}

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
  /// Row-major covariance of a left perturbation (translation [m], rotation [rad]),
  /// p = exp(rotation) (R p_reference + t) + translation.
  /// It is the inverse normal matrix under the assumed noise.
  /// Multiply it by max(1, sigma0^2) if the assumed noise may be too small.
  std::array<double, 36> covariance{};
  double sigma0 = 0;        ///< sqrt(sum w chi2 / (sum 3 w - 6)); 1 if the assumed noise is correct
  int points = 0;           ///< seeds with depth in both frames
  int inliers = 0;          ///< inliers among `points`
  int iterations = 0;       ///< samples drawn
  bool from_prior = false;  ///< true if the prior pose won
};

/// Relative rigid motion from 3D-3D correspondences.
/// Seeded RANSAC over triples in closed form, with noise-whitened scores, bail-out
/// and local optimisation (Chum, Matas and Kittler, DAGM 2003).
/// Robust least squares follow (rigid_least_squares.hpp).
/// Reuses its buffers: no allocation after the largest input.
/// Cost: about 20 us + 30 us for 1000 points.
class RigidMotionEstimator {
 public:
  explicit RigidMotionEstimator(const RigidMotionOptions& options = {});
  RigidMotionEstimator(RigidMotionEstimator&&) noexcept;
  RigidMotionEstimator& operator=(RigidMotionEstimator&&) noexcept;
  ~RigidMotionEstimator();

  RigidMotionOptions& options() { return *options_; }
  const RigidMotionOptions& options() const { return *options_; }

  /// Points are in the camera frames [m], z forward. z <= 0 or not finite means no point.
  /// Both spans have the same size.
  /// `seeds` are indices into them; indices out of range are ignored.
  /// The camera's focal lengths convert pixel noise to metres.
  /// Unusual data never throws.
  RigidMotion estimate(const Camera& camera, Span<const cv::Point3f> reference,
                       Span<const cv::Point3f> current, Span<const int> seeds,
                       const std::optional<Pose>& prior = std::nullopt);

  /// Least squares only, on all seeds with depth.
  /// The start must be within the range of the robust loss.
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
