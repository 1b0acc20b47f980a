// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Viewing rays of all pixels, (x, y, 1) per unit of depth. Stored as a row and a column for a pinhole
/// camera, and as a table with distortion. Computed once per camera and image size.
class PixelRays {
 public:
  /// Cheap if nothing changed. Rays are NaN where the distortion has no inverse.
  void set(const Camera& camera, cv::Size size);
  cv::Size size() const { return size_; }
  /// Whether each row has its own x, which a distorted image needs.
  bool is_table() const { return camera_.distorted(); }
  /// The x of a row's pixels, per unit of depth.
  const float* x_row(int y) const { return x_.data() + (is_table() ? row(y) : 0); }
  const float* y_row(int y) const { return y_.data() + row(y); }       ///< row of the table
  float y_of(int y) const { return y_[static_cast<std::size_t>(y)]; }  ///< without distortion

 private:
  std::size_t row(int y) const { return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width); }
  void fill_table();

  Camera camera_;
  cv::Size size_;
  std::vector<float> x_, y_;
};

/// Points in the camera frame [m] (x right, y down, z forward), one per pixel, as three arrays.
/// A pixel without usable depth has x = y = z = 0.
struct DepthPoints {
  cv::Size size;
  std::vector<float> x, y, z;
};

/// Depths outside this range are not used.
struct DepthRange {
  float min_m = 0.1F, max_m = 10;
};

namespace detail {

/// Depths [m] of `n` pixels, 0 without depth. Comparisons with NaN are false.
template <class T>
DYNFILTER_AS_CALLER inline void read_depths(const T* depth, int n, float unit_m, DepthRange range, float* z) {
  for (int i = 0; i < n; ++i) {
    const float v = static_cast<float>(depth[i]) * unit_m;
    z[i] = static_cast<int>(v >= range.min_m) & static_cast<int>(v <= range.max_m) ? v : 0.0F;
  }
}

/// Depths of `n` pixels of row y from column x0. `depth`: CV_16UC1 or CV_32FC1.
DYNFILTER_AS_CALLER inline void read_depths(const cv::Mat& depth, int y, int x0, int n, float unit_m,
                                            DepthRange range, float* z) {
  if (depth.type() == CV_16UC1)
    read_depths(depth.ptr<std::uint16_t>(y) + x0, n, unit_m, range, z);
  else
    read_depths(depth.ptr<float>(y) + x0, n, unit_m, range, z);
}

/// Points of these pixels.
DYNFILTER_AS_CALLER inline void read_points(const cv::Mat& depth, float unit_m, DepthRange range,
                                            const PixelRays& rays, int y, int x0, int n, float* __restrict px,
                                            float* __restrict py, float* __restrict pz) {
  read_depths(depth, y, x0, n, unit_m, range, pz);
  const float* rx = rays.x_row(y) + x0;
  if (rays.is_table()) {
    const float* ry = rays.y_row(y) + x0;
    for (int i = 0; i < n; ++i) {
      pz[i] = rx[i] == rx[i] ? pz[i] : 0.0F;
      px[i] = rx[i] == rx[i] ? pz[i] * rx[i] : 0.0F;
      py[i] = ry[i] == ry[i] ? pz[i] * ry[i] : 0.0F;
    }
    return;
  }
  const float ry = rays.y_of(y);
  for (int i = 0; i < n; ++i) px[i] = pz[i] * rx[i], py[i] = pz[i] * ry;
}

}  // namespace detail

inline void PixelRays::set(const Camera& camera, cv::Size size) {
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

/// Back-projects a depth image with `rays` of the same size: x = (u - cx) z / fx.
/// `depth`: CV_16UC1 or CV_32FC1 in units of `unit_m`. Returns false, without points, for any other type.
/// Cost: linear in the pixels. Nothing is allocated after the first image of a size.
inline bool back_project_depth(const cv::Mat& depth, double unit_m, const PixelRays& rays, DepthRange range,
                               DepthPoints& out) {
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
