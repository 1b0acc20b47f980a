// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/camera.hpp>
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

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/testing/detail/exact_scene_camera-inl.hpp>
#endif
