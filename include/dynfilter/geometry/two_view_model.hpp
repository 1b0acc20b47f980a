// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/geometry/epipolar_distance.hpp>
#include <limits>
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

/// A two-view model and the figures behind it. Plain numbers, in pixels of the undistorted images.
struct TwoViewModel {
  TwoViewKind kind = TwoViewKind::None;
  TwoViewReason reason = TwoViewReason::TooFewSeeds;
  Matrix9 F{};  ///< p2^T F p1 = 0; all zero: no F
  Matrix9 H{};  ///< p2 ~ H p1; all zero: no H
  /// Homography and Rotation: largest distance [px] of a static point from H p1, along its line F p1. Zero if
  /// no parallax is found.
  double allowance_px = 0;
  /// True if points off H but on F may be static parallax. `judge` then returns CannotSay for them.
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

/// What the model says of one match.
enum class TwoViewVerdict { CannotSay, Consistent, Inconsistent };

inline const char* to_string(TwoViewKind kind) {
  switch (kind) {
    case TwoViewKind::None:
      return "none";
    case TwoViewKind::Fundamental:
      return "fundamental";
    case TwoViewKind::Homography:
      return "homography";
    case TwoViewKind::Rotation:
      return "rotation";
  }
  return "";
}

inline const char* to_string(TwoViewReason reason) {
  switch (reason) {
    case TwoViewReason::TooFewSeeds:
      return "too few seeds";
    case TwoViewReason::CollinearSeeds:
      return "the seeds lie on a line";
    case TwoViewReason::NoConsensus:
      return "no model explains enough seeds";
    case TwoViewReason::General:
      return "no homography explains half of what F explains";
    case TwoViewReason::PlaneAndParallax:
      return "a dominant plane whose own residuals point at the epipole";
    case TwoViewReason::CalibratedParallax:
      return "a dominant plane; its motion explains points off it";
    case TwoViewReason::WeakParallax:
      return "a homography up to parallax near the noise";
    case TwoViewReason::Plane:
      return "a plane";
    case TwoViewReason::PureRotation:
      return "no baseline: the camera only turned";
    case TwoViewReason::NoMotion:
      return "no baseline: the camera stood still";
  }
  return "";
}

/// Distance [px] of a match from the model in the current image. Fundamental: distance from the epipolar line
/// (RTS-SLAM, eq. 4). Homography and Rotation: distance from H p1, less `allowance_px` along the epipolar
/// line, times sqrt(3.84 / 5.99) = 0.80. This factor accounts for two coordinates of error instead of one, so
/// that the same threshold passes the same share of static points. NaN if the kind is None or a point is not
/// finite.
inline double distance_px(const TwoViewModel& model, cv::Point2f reference, cv::Point2f current) {
  constexpr double kTwoCoordinates = 0.80067;
  if (model.kind == TwoViewKind::None || !std::isfinite(reference.x + reference.y + current.x + current.y)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (model.kind == TwoViewKind::Fundamental) return epipolar_distance_px(model.F, reference, current);
  const cv::Point2d q = transfer(model.H, reference);
  const double dx = current.x - q.x, dy = current.y - q.y;
  if (!(model.allowance_px > 0)) return kTwoCoordinates * portable::hypot(dx, dy);
  const auto line = detail::epipolar_terms(model.F, reference, current);
  const double norm = portable::hypot(line.X, line.Y);
  const double across = norm > 0 ? (line.X * dx + line.Y * dy) / norm : 0,
               along = norm > 0 ? (line.X * dy - line.Y * dx) / norm : 0;
  return kTwoCoordinates * portable::hypot(across, std::max(0.0, std::abs(along) - model.allowance_px));
}

/// The model's verdict on a match for a threshold on `distance_px`.
inline TwoViewVerdict judge(const TwoViewModel& model, cv::Point2f reference, cv::Point2f current,
                            double max_distance_px) {
  const double d = distance_px(model, reference, current);
  if (std::isnan(d)) return TwoViewVerdict::CannotSay;
  if (d <= max_distance_px) return TwoViewVerdict::Consistent;
  if (model.ambiguous && epipolar_distance_px(model.F, reference, current) <= max_distance_px) {
    return TwoViewVerdict::CannotSay;
  }
  return TwoViewVerdict::Inconsistent;
}

}  // namespace dynfilter
