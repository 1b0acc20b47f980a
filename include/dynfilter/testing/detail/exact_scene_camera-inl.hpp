// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/testing/exact_scene_camera.hpp>

#include <dynfilter/core/inline.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter::testing {

DYNFILTER_INLINE cv::Point2d project(const Camera& camera, const Eigen::Vector3d& point_m) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  if (!(point_m.z() > 1e-6)) return {kNan, kNan};
  return {camera.fx_px * point_m.x() / point_m.z() + camera.cx_px,
          camera.fy_px * point_m.y() / point_m.z() + camera.cy_px};
}

DYNFILTER_INLINE cv::Point2d distort(const Camera& camera, const cv::Point2d& px) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double x = (px.x - camera.cx_px) / camera.fx_px, y = (px.y - camera.cy_px) / camera.fy_px;
  const double r2 = x * x + y * y, radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {camera.fx_px * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + camera.cx_px,
          camera.fy_px * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + camera.cy_px};
}

}  // namespace dynfilter::testing
