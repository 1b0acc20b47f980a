// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/motion/free_space.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>

namespace dynfilter {

DYNFILTER_INLINE NearestDepth::NearestDepth(const cv::Mat& depth, double unit_m)
    : depth_(depth), unit_m_(static_cast<float>(unit_m)) {
  if (depth.type() != CV_32FC1 && depth.type() != CV_16UC1) depth_ = cv::Mat();
}

DYNFILTER_INLINE std::optional<float> NearestDepth::around(const cv::Point2f& px, int radius_px,
                                                           float beyond_m) const {
  const auto inside = [&](float at, int size) {
    return at >= static_cast<float>(radius_px) && at <= static_cast<float>(size - 1 - radius_px);
  };
  if (depth_.empty() || !inside(px.x, depth_.cols) || !inside(px.y, depth_.rows)) return std::nullopt;
  const cv::Point centre(cvRound(px.x), cvRound(px.y));
  return depth_.type() == CV_32FC1 ? of_window<float>(centre, radius_px, beyond_m)
                                   : of_window<std::uint16_t>(centre, radius_px, beyond_m);
}

template <class T>
std::optional<float> NearestDepth::of_window(const cv::Point& centre, int radius_px, float beyond_m) const {
  float nearest_m = std::numeric_limits<float>::infinity();
  int known = 0;
  const auto free_row = [&](int y) {
    const T* row = depth_.ptr<T>(y) + centre.x;
    for (int dx = -radius_px; dx <= radius_px; ++dx) {
      const float z_m = static_cast<float>(row[dx]) * unit_m_;
      if (!valid_depth(z_m)) continue;
      if (z_m <= beyond_m) return false;
      nearest_m = std::min(nearest_m, z_m);
      ++known;
    }
    return true;
  };
  if (!free_row(centre.y)) return std::nullopt;
  for (int dy = 1; dy <= radius_px; ++dy)
    if (!free_row(centre.y - dy) || !free_row(centre.y + dy)) return std::nullopt;
  const int side = 2 * radius_px + 1;
  if (known < kLeastKnown * side * side) return std::nullopt;
  return nearest_m;
}

DYNFILTER_INLINE double FreeSpaceView::odds(const cv::Point3f& point_m) const {
  if (!valid_depth(point_m.z)) return 0;
  const Eigen::Vector3d far = R_ * Eigen::Vector3d(point_m.x, point_m.y, point_m.z), p = far + t_;
  if (!(p.z() > 0) || !(far.z() > 0)) return 0;
  const cv::Point2f px = pixel(p);
  const double here_m = model_.depth_noise.sigma_m(point_m.z);
  const cv::Point2f parallax_px = px - pixel(far);
  const double along_px = portable::hypot(parallax_px.x, parallax_px.y) * here_m / point_m.z;
  const double radius_px = kReach * portable::hypot(model_.sigma_px, along_px) + kSilhouette_px;
  if (!(radius_px <= kMostRadius_px)) return 0;
  const auto there_m = depth_.around(px, static_cast<int>(std::ceil(radius_px)), static_cast<float>(p.z()));
  return there_m ? std::max(0.0, odds_of(*there_m - p.z(), here_m, *there_m)) : 0;
}

inline cv::Point2f FreeSpaceView::pixel(const Eigen::Vector3d& p) const {
  return distort_point(camera_, project(camera_, {static_cast<float>(p.x()), static_cast<float>(p.y()),
                                                  static_cast<float>(p.z())}));
}

inline double FreeSpaceView::odds_of(double behind_m, double here_m, double there_m) const {
  const double sigma_m = portable::hypot(here_m, model_.depth_noise.sigma_m(there_m)), t = behind_m / sigma_m;
  const double error = kPeak * portable::power(1 + t * t / kNu, -(kNu + 1) / 2) / sigma_m;
  return portable::log(kThrough / (kRange_m * error + kGross)) + prior_;
}

}  // namespace dynfilter
