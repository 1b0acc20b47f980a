// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/motion/row_twist.hpp>
#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

namespace detail {
class RigidBackgroundSearch;
}

/// What a background motion is estimated from. One entry per feature in every span but `seeds`.
struct RigidBackgroundScene {
  static constexpr float kMobile = 0.5F;  ///< mobility from which on a point counts as having moved

  Camera camera;
  Span<const cv::Point3f> reference_m, current_m;  ///< in the camera frames; z not finite: no point
  Span<const cv::Point2f> pixels;                  ///< current positions of the features
  Span<const float> static_belief;                 ///< [0, 1] from earlier frames; 0.5: unknown
  Span<const float> mobility;                      ///< [0, 1] moved recently; empty: none did
  Span<const int> seeds;                           ///< features that may be used, ascending
  std::optional<Pose> expected;                    ///< T_current_reference of a camera with constant velocity
  double elapsed_s = 0;                            ///< since the reference; 0: not known
  std::optional<Eigen::Vector3d> last_turn_radps;  ///< rate of turn of T_current_reference in the last step
  std::optional<Pose> predicted;                   ///< T_current_reference of the host
  std::optional<MotionPrior> prior;                ///< from sensors beside the camera
  double prior_wrong = 0;                          ///< probability; from 0.5 on it is compared only
  DepthNoise depth_noise{};                        ///< of the sensor
  /// Whole error of a static match over the noise that neighbours do not share.
  double noise_ratio = 1.5;
};

/// One rigid motion that some of the points follow.
struct MotionProposal {
  /// Where the proposal comes from.
  enum class From { Expected, Predicted, Support };
  From from = From::Support;
  RigidMotion motion;
  double sigma_px = 0;  ///< noise that it was fitted with
  double area = 0;      ///< share of the visible surface that it explains best
  double order = 0.5;   ///< share of the neighbouring points of other motions that are nearer
  double score = 0;     ///< log-probability of being the background, up to a constant
};

/// The motion of the background between two frames, when most points may lie on movers.
///
/// 1. Motions are proposed for at most four points per cell of a 16 x 12 grid, and the noise of the frame is
///    measured (detail/motion_proposals.hpp).
/// 2. The set of motions with the shortest description is selected (motion_selection.hpp). Each point belongs
///    to the motion that explains it best. The n points of a patch count as n / (1 + (n - 1) rho) independent
///    ones (Kish, Survey Sampling, 1965, section 5.4). rho is the share of a match's error variance that
///    neighbours have in common.
/// 3. The background is the motion with the largest
///      log(area) - log(1 + d^2) + order + 0.1 log(n / (1 - n)) (0.5 + d^2) / (1 + d^2).
///    area: share of the visible surface [m^2], weighted by what was static before.
///    d: distance of its points in the image from the expected motion, in units of the usual distance.
///    order: share of the neighbours on other motions that are in front.
///    n: share of the points that it explains. A few points decide little, and less where they surprise.
///    A prior adds log((1 - w) exp(-d_p^2 / 2) + w), with d_p of prior_evidence.hpp and w that it is wrong.
///    A motion that explains less than 4 % of the points is never the background. If none explains more,
///    there is no motion. The exponentials of the scores, normalised, give the confidence.
///
/// Owns its scratch. Not for several threads at once. Cost: O(seeds) to sample the points. The rest does not
/// grow with the features.
class RigidBackgroundEstimator {
 public:
  static constexpr float kMobile = RigidBackgroundScene::kMobile;

  RigidBackgroundEstimator();
  RigidBackgroundEstimator(RigidBackgroundEstimator&&) noexcept;
  RigidBackgroundEstimator& operator=(RigidBackgroundEstimator&&) noexcept;
  ~RigidBackgroundEstimator();

  /// `ok` is false if no motion explains enough points. Unusual data never throws.
  RigidMotion estimate(const RigidBackgroundScene& scene);

  const std::vector<MotionProposal>& proposals() const;  ///< all that were compared in the last frame
  /// Index of the background's motion among the proposals.
  std::size_t chosen() const;
  /// Probability that the chosen motion is the background's, given that one of the selected ones is.
  double confidence() const;
  /// Points that the estimate is based on.
  std::size_t points() const;
  /// Noise of this frame's matches that neighbours do not share [px per axis].
  double match_noise_px() const;
  /// Error of this frame's depths in units of the sensor's noise model, at least 1.
  double depth_factor() const;
  /// Of the current frame against the reference: the motion holds for points that it has straightened.
  const RowTwist& row_twist() const;
  /// Squared distance of the chosen motion from the prior (prior_evidence.hpp); 0 without one.
  double prior_distance2() const;
  /// Forgets how smoothly the camera moves.
  void reset();

 private:
  std::unique_ptr<detail::RigidBackgroundSearch> search_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/motion/detail/rigid_background-inl.hpp>
#endif
