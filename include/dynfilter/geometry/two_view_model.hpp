// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <dynfilter/geometry/epipolar.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {

struct TwoViewOptions {
  double max_distance_px = 1.0;   ///< a seed agrees with F up to this Sampson distance, about 2 noise sigmas
  int min_seeds = 20;             ///< fewer usable seeds: None
  double min_spread_px = 4.0;     ///< seeds within this standard deviation of a line: None
  double min_inlier_share = 0.3;  ///< of the seeds, for any model
  double min_plane_share = 0.5;   ///< of F's support: from here on a homography is a rival of F
  double min_parallax_share = 0.2;  ///< of the seeds: fewer points off H are movers, see TwoViewDecision
  double confidence = 0.99;         ///< of having drawn one sample without outliers
  int max_iterations = 1500;        ///< of the sampling for F
  std::uint64_t seed = 1;
};

/// Which model the static scene obeys between two images.
enum class TwoViewKind {
  None,         ///< cannot say: abstain
  Fundamental,  ///< enough baseline and relief: epipolar lines
  Homography,   ///< one plane, or a baseline too small to be seen beside it: points
  Rotation      ///< no baseline: the camera turned, or stood still
};

/// Why that kind was chosen.
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

/// A two-view model with the figures that led to it. Plain numbers, pixels of the undistorted images.
struct TwoViewModel {
  TwoViewKind kind = TwoViewKind::None;
  TwoViewReason reason = TwoViewReason::TooFewSeeds;
  Matrix9 F{};  ///< p2^T F p1 = 0; all zero if there is none
  Matrix9 H{};  ///< p2 ~ H p1; all zero if there is none
  /// Homography and Rotation: how far a static point may lie from H p1 along its line F p1 [px]. Zero where
  /// no parallax was found.
  double allowance_px = 0;
  /// Points off H but on F cannot be told from static parallax: `judge` says CannotSay.
  bool ambiguous = false;
  double sigma_px = 0;          ///< noise per coordinate and image, from the seeds that agree
  int seeds = 0;                ///< usable ones
  int inliers = 0;              ///< seeds that agree with the model (of `kind`)
  int fundamental_inliers = 0;  ///< seeds that agree with the best F, for the record
  int homography_inliers = 0;   ///< seeds that agree with the best H; 0 if none came near F's support
  double anisotropy = 0;  ///< variance along over across the epipolar lines of what H leaves; 0: not asked
  int iterations = 0;     ///< samples drawn for F
};

enum class TwoViewVerdict { CannotSay, Consistent, Inconsistent };

/// Distance [px] of a match from the model in the current image. Fundamental: to the epipolar line (RTS-SLAM
/// eq. 4). Homography and Rotation: to H p1, less `allowance_px` along the epipolar line, scaled by sqrt(3.84
/// / 5.99) = 0.80, so that the same threshold passes the same share of static points although two coordinates
/// can miss instead of one. NaN if the kind is None or a point is not finite.
inline double distance_px(const TwoViewModel& model, cv::Point2f reference, cv::Point2f current) {
  constexpr double kTwoCoordinates = 0.80067;
  if (model.kind == TwoViewKind::None || !std::isfinite(reference.x + reference.y + current.x + current.y)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (model.kind == TwoViewKind::Fundamental) return epipolar_distance_px(model.F, reference, current);
  const cv::Point2d q = transfer(model.H, reference);
  const double dx = current.x - q.x, dy = current.y - q.y;
  if (!(model.allowance_px > 0)) return kTwoCoordinates * std::hypot(dx, dy);
  const Matrix9& F = model.F;
  const double X = F[0] * reference.x + F[1] * reference.y + F[2];
  const double Y = F[3] * reference.x + F[4] * reference.y + F[5];
  const double norm = std::hypot(X, Y);
  const double across = norm > 0 ? (X * dx + Y * dy) / norm : 0,
               along = norm > 0 ? (X * dy - Y * dx) / norm : 0;
  return kTwoCoordinates * std::hypot(across, std::max(0.0, std::abs(along) - model.allowance_px));
}

/// The model's opinion on a match at a threshold on `distance_px`.
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
