// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/motion/rigid_background_scene.hpp>
#include <dynfilter/motion/row_twist.hpp>
#include <memory>
#include <vector>

namespace dynfilter {

namespace detail {
class RigidBackgroundSearch;
}

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
  /// Forgets how smoothly the camera moves.
  void reset();

 private:
  std::unique_ptr<detail::RigidBackgroundSearch> search_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/motion/detail/rigid_background-inl.hpp>
#endif
