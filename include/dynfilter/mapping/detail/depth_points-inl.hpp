// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/mapping/depth_points.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/geometry/undistort.hpp>

namespace dynfilter::mapping {

DYNFILTER_INLINE void PixelRays::set(const Camera& camera, cv::Size size) {
  if (camera == camera_ && size == size_) return;
  camera_ = camera;
  size_ = size;
  const std::size_t width = static_cast<std::size_t>(size.width),
                    height = static_cast<std::size_t>(size.height);
  const std::size_t table = camera.distorted() ? width * height : 0;
  x_.resize(table > 0 ? table : width);
  y_.resize(table > 0 ? table : height);
  if (table > 0) return fill_table();
  for (std::size_t x = 0; x < width; ++x)
    x_[x] = static_cast<float>((static_cast<double>(x) - camera.cx_px) / camera.fx_px);
  for (std::size_t y = 0; y < height; ++y)
    y_[y] = static_cast<float>((static_cast<double>(y) - camera.cy_px) / camera.fy_px);
}

inline void PixelRays::fill_table() {
  std::size_t i = 0;
  for (int y = 0; y < size_.height; ++y)
    for (int x = 0; x < size_.width; ++x, ++i) {
      const cv::Point2d n = dynfilter::detail::undistort_normalised(
          camera_.distortion, (x - camera_.cx_px) / camera_.fx_px, (y - camera_.cy_px) / camera_.fy_px);
      x_[i] = static_cast<float>(n.x);
      y_[i] = static_cast<float>(n.y);
    }
}

DYNFILTER_INLINE bool back_project_depth(const cv::Mat& depth, double unit_m, const PixelRays& rays,
                                         DepthRange range, DepthPoints& out) {
  const bool known = depth.type() == CV_16UC1 || depth.type() == CV_32FC1;
  out.size = known && depth.size() == rays.size() ? depth.size() : cv::Size();
  const std::size_t n = static_cast<std::size_t>(out.size.area());
  out.x.resize(n), out.y.resize(n), out.z.resize(n);
  const auto unit = static_cast<float>(unit_m);
  dynfilter::detail::call_widest([&](auto) DYNFILTER_AS_CALLER {
    for (int y = 0; y < out.size.height; ++y) {
      const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(out.size.width);
      detail::read_points(depth, unit, range, rays, y, 0, out.size.width, &out.x[i], &out.y[i], &out.z[i]);
    }
  });
  return n > 0;
}

}  // namespace dynfilter::mapping
