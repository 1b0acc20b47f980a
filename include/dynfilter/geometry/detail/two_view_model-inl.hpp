// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/two_view_model.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/geometry/epipolar_distance.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE const char* to_string(TwoViewKind kind) {
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

DYNFILTER_INLINE const char* to_string(TwoViewReason reason) {
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

DYNFILTER_INLINE double distance_px(const TwoViewModel& model, cv::Point2f reference, cv::Point2f current) {
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

DYNFILTER_INLINE TwoViewVerdict judge(const TwoViewModel& model, cv::Point2f reference, cv::Point2f current,
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
