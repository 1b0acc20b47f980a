// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/span.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {
namespace detail {

struct Distorted {
  double x, y;                 ///< distorted normalised coordinates
  double dx_dx, dx_dy, dy_dy;  ///< Jacobian; it is symmetric: dy_dx = dx_dy
};

Distorted distort_normalised(const std::array<double, 5>& k, double x, double y);

/// Newton's method with a fixed number of steps.
/// It converges quadratically: six steps reach 1e-9, OpenCV's fixed-point iteration needs dozens.
cv::Point2d undistort_normalised(const std::array<double, 5>& k, double xd, double yd);

}  // namespace detail

/// Maps a pixel of the distorted image to a pixel of an ideal camera with the same intrinsics.
/// NaN for NaN input and where the distortion polynomial has no inverse, far outside the image.
cv::Point2f undistort_point(const Camera& camera, cv::Point2f distorted_px);

/// The inverse of `undistort_point`: maps an ideal pixel to the distorted image.
cv::Point2f distort_point(const Camera& camera, cv::Point2f ideal_px);

/// `out[i] = undistort_point(in[i])`. Both have the same size, and `out` may be `in`.
/// Copies if the camera has no distortion.
void undistort_points(const Camera& camera, Span<const cv::Point2f> in, Span<cv::Point2f> out);

/// Point in the camera frame [m] (x right, y down, z forward) from an undistorted pixel and its depth z [m].
/// All NaN if the depth is NaN, infinite, zero or negative.
cv::Point3f back_project(const Camera& camera, cv::Point2f undistorted_px, float depth_m);

/// Back-projects many pixels. All arrays have the same size.
void back_project(const Camera& camera, Span<const cv::Point2f> undistorted_px, Span<const float> depth_m,
                  Span<cv::Point3f> out);

/// Undistorted pixel of a point in the camera frame [m]. NaN behind the camera.
inline cv::Point2f project(const Camera& camera, const cv::Point3f& point_m) {
  if (!(point_m.z > 0)) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    return {nan, nan};
  }
  const double inv_z = 1.0 / point_m.z;
  return {static_cast<float>(point_m.x * inv_z * camera.fx_px + camera.cx_px),
          static_cast<float>(point_m.y * inv_z * camera.fy_px + camera.cy_px)};
}

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/geometry/detail/undistort-inl.hpp>
#endif
