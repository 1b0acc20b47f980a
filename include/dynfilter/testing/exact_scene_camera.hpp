// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/camera.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/core/types.hpp>

namespace dynfilter::testing {

/// Undistorted pixel of a point in the camera's frame; NaN behind it.
cv::Point2d project(const Camera& camera, const Eigen::Vector3d& point_m);

/// Distorted pixel of an undistorted one (OpenCV's radial-tangential model).
cv::Point2d distort(const Camera& camera, const cv::Point2d& px);

/// Direction of an undistorted pixel, with z = 1.
inline Eigen::Vector3d ray(const Camera& camera, const cv::Point2d& px) {
  return {(px.x - camera.cx_px) / camera.fx_px, (px.y - camera.cy_px) / camera.fy_px, 1};
}

/// True if the pixel is between the outermost pixel centres of the image. False for NaN.
inline bool in_image(const Camera& camera, const cv::Point2d& px) {
  return px.x >= 0 && px.y >= 0 && px.x <= camera.width_px - 1 && px.y <= camera.height_px - 1;
}

}  // namespace dynfilter::testing

namespace dynfilter::testing {

inline cv::Point2d project(const Camera& camera, const Eigen::Vector3d& point_m) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  if (!(point_m.z() > 1e-6)) return {kNan, kNan};
  return {camera.fx_px * point_m.x() / point_m.z() + camera.cx_px,
          camera.fy_px * point_m.y() / point_m.z() + camera.cy_px};
}

inline cv::Point2d distort(const Camera& camera, const cv::Point2d& px) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double x = (px.x - camera.cx_px) / camera.fx_px, y = (px.y - camera.cy_px) / camera.fy_px;
  const double r2 = x * x + y * y, radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {camera.fx_px * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + camera.cx_px,
          camera.fy_px * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + camera.cy_px};
}

}  // namespace dynfilter::testing
