// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/geometry/epipolar_distance.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

/// Options of TwoViewEstimator.
struct TwoViewOptions {
  /// Largest Sampson distance of a seed that agrees with F, about 2 sigma.
  double max_distance_px = 1.0;
  int min_seeds = 20;             ///< fewer usable seeds: None
  double min_spread_px = 4.0;     ///< seeds within this standard deviation of a line: None
  double min_inlier_share = 0.3;  ///< of the seeds, for any model
  double min_plane_share = 0.5;   ///< share of F's support from which a homography competes with F
  /// Share of the seeds; fewer points off H are movers, see TwoViewDecision.
  double min_parallax_share = 0.2;
  double confidence = 0.99;   ///< probability that at least one sample has no outlier
  int max_iterations = 1500;  ///< of sampling for F
  std::uint64_t seed = 1;
};

/// Model of the static scene between two images.
enum class TwoViewKind {
  None,         ///< undecided: abstain
  Fundamental,  ///< enough baseline and relief: epipolar lines
  Homography,   ///< one plane, or a baseline too small to be visible beside it: points
  Rotation      ///< no baseline: the camera rotates or is static
};

/// Reason for the kind.
enum class TwoViewReason {
  TooFewSeeds,
  CollinearSeeds,
  NoConsensus,
  General,
  PlaneAndParallax,
  CalibratedParallax,
  WeakParallax,
  Plane,
  PureRotation,
  NoMotion,
};

const char* to_string(TwoViewKind kind);

const char* to_string(TwoViewReason reason);

/// A two-view model and the figures behind it. Plain numbers, in pixels of the undistorted images.
struct TwoViewModel {
  TwoViewKind kind = TwoViewKind::None;
  TwoViewReason reason = TwoViewReason::TooFewSeeds;
  Matrix9 F{};  ///< p2^T F p1 = 0; all zero: no F
  Matrix9 H{};  ///< p2 ~ H p1; all zero: no H
  /// Homography and Rotation: largest distance [px] of a static point from H p1, along its line F p1. Zero if
  /// no parallax is found.
  double allowance_px = 0;
  /// True if points off H but on F may be static parallax.
  /// `judge` then returns CannotSay for them.
  bool ambiguous = false;
  double sigma_px = 0;          ///< noise per coordinate and image, from the inliers
  int seeds = 0;                ///< usable ones
  int inliers = 0;              ///< seeds that agree with the model (of `kind`)
  int fundamental_inliers = 0;  ///< seeds that agree with the best F
  /// Seeds that agree with the best H; 0 if none is close to F's support.
  int homography_inliers = 0;
  /// Variance of H's residuals along over across the epipolar lines; 0: not measured.
  double anisotropy = 0;
  int iterations = 0;  ///< samples drawn for F
};

enum class TwoViewVerdict { CannotSay, Consistent, Inconsistent };

/// Distance [px] of a match from the model in the current image.
/// Fundamental: distance from the epipolar line (RTS-SLAM, eq. 4).
/// Homography and Rotation: distance from H p1, less `allowance_px` along the epipolar line, times sqrt(3.84
/// / 5.99) = 0.80.
/// This factor accounts for two coordinates of error instead of one, so that the same threshold passes the
/// same share of static points.
/// NaN if the kind is None or a point is not finite.
double distance_px(const TwoViewModel& model, cv::Point2f reference, cv::Point2f current);

/// The model's verdict on a match for a threshold on `distance_px`.
TwoViewVerdict judge(const TwoViewModel& model, cv::Point2f reference, cv::Point2f current,
                     double max_distance_px);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/geometry/detail/two_view_model-inl.hpp>
#endif
