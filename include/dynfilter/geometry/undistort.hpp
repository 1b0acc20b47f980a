// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {

/// In single precision, in the same frame of reference.
inline cv::Point3f to_point(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/// A rigid motion T_b_a in single precision, for loops over points: p_b = R p_a + t.
struct PointMotion {
  float R[3][3], t[3];

  /// Of T_b_a.
  explicit PointMotion(const Pose& T) {
    for (std::size_t k = 0; k < 9; ++k) R[k / 3][k % 3] = static_cast<float>(T.rotation[k]);
    for (std::size_t k = 0; k < 3; ++k) t[k] = static_cast<float>(T.translation_m[k]);
  }
  /// A direction of frame a in frame b.
  cv::Point3f turn(const cv::Point3f& a) const {
    const auto row = [&](const float* r) { return r[0] * a.x + (r[1] * a.y + r[2] * a.z); };
    return {row(R[0]), row(R[1]), row(R[2])};
  }
  /// A point of frame a in frame b.
  cv::Point3f operator()(const cv::Point3f& a) const {
    const cv::Point3f b = turn(a);
    return {b.x + t[0], b.y + t[1], b.z + t[2]};
  }
};

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

namespace detail {

struct Distorted {
  double x, y;                 ///< distorted normalised coordinates
  double dx_dx, dx_dy, dy_dy;  ///< Jacobian; it is symmetric: dy_dx = dx_dy
};

inline Distorted distort_normalised(const std::array<double, 5>& k, double x, double y) {
  const double k1 = k[0], k2 = k[1], p1 = k[2], p2 = k[3], k3 = k[4];
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3));  // d radial / d r2, times 2
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
          radial + slope * x * x + 2 * p1 * y + 6 * p2 * x, slope * x * y + 2 * p1 * x + 2 * p2 * y,
          radial + slope * y * y + 6 * p1 * y + 2 * p2 * x};
}

/// Newton's method with a fixed number of steps.
/// It converges quadratically: six steps reach 1e-9, OpenCV's fixed-point iteration needs dozens.
inline cv::Point2d undistort_normalised(const std::array<double, 5>& k, double xd, double yd) {
  constexpr int kSteps = 4;
  double x = xd, y = yd;
  for (int i = 0; i < kSteps; ++i) {
    const Distorted d = distort_normalised(k, x, y);
    const double det = d.dx_dx * d.dy_dy - d.dx_dy * d.dx_dy;
    const double ex = xd - d.x, ey = yd - d.y;
    x += (d.dy_dy * ex - d.dx_dy * ey) / det;
    y += (d.dx_dx * ey - d.dx_dy * ex) / det;
  }
  const Distorted d = distort_normalised(k, x, y);
  const bool converged = std::abs(d.x - xd) + std::abs(d.y - yd) < 1e-6;  // about 1/2000 px
  const double nan = std::numeric_limits<double>::quiet_NaN();
  return converged ? cv::Point2d(x, y) : cv::Point2d(nan, nan);
}

}  // namespace detail
/// Maps a pixel of the distorted image to a pixel of an ideal camera with the same intrinsics.
/// NaN for NaN input and where the distortion polynomial has no inverse, far outside the image.
inline cv::Point2f undistort_point(const Camera& camera, cv::Point2f distorted_px) {
  if (!camera.distorted()) return distorted_px;
  const cv::Point2d n =
      detail::undistort_normalised(camera.distortion, (distorted_px.x - camera.cx_px) / camera.fx_px,
                                   (distorted_px.y - camera.cy_px) / camera.fy_px);
  return {static_cast<float>(n.x * camera.fx_px + camera.cx_px),
          static_cast<float>(n.y * camera.fy_px + camera.cy_px)};
}

/// The inverse of `undistort_point`: maps an ideal pixel to the distorted image.
inline cv::Point2f distort_point(const Camera& camera, cv::Point2f ideal_px) {
  if (!camera.distorted()) return ideal_px;
  const detail::Distorted d =
      detail::distort_normalised(camera.distortion, (ideal_px.x - camera.cx_px) / camera.fx_px,
                                 (ideal_px.y - camera.cy_px) / camera.fy_px);
  return {static_cast<float>(d.x * camera.fx_px + camera.cx_px),
          static_cast<float>(d.y * camera.fy_px + camera.cy_px)};
}

/// `out[i] = undistort_point(in[i])`. Both have the same size, and `out` may be `in`.
/// Copies if the camera has no distortion.
inline void undistort_points(const Camera& camera, Span<const cv::Point2f> in, Span<cv::Point2f> out) {
  for (std::size_t i = 0; i < in.size(); ++i) out[i] = undistort_point(camera, in[i]);
}

/// Point in the camera frame [m] (x right, y down, z forward) from an undistorted pixel and its depth z [m].
/// All NaN if the depth is NaN, infinite, zero or negative.
inline cv::Point3f back_project(const Camera& camera, cv::Point2f undistorted_px, float depth_m) {
  if (!valid_depth(depth_m)) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    return {nan, nan, nan};
  }
  const double z = depth_m;
  return {static_cast<float>((undistorted_px.x - camera.cx_px) / camera.fx_px * z),
          static_cast<float>((undistorted_px.y - camera.cy_px) / camera.fy_px * z), depth_m};
}

/// Back-projects many pixels to the camera frame [m]. All arrays have the same size.
inline void back_project(const Camera& camera, Span<const cv::Point2f> undistorted_px,
                         Span<const float> depth_m, Span<cv::Point3f> out) {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = back_project(camera, undistorted_px[i], depth_m[i]);
}

}  // namespace dynfilter
