// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <utility>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>
#include "io/cloud_picture.hpp"

namespace dynfilter::command {

/// A pinhole camera with a pose.
struct MapView {
  Camera camera;
  cv::Size size;
  Pose T_world_camera;
};

namespace detail {

inline const cv::Scalar kMapPaper(28, 28, 28), kMapInk(235, 235, 235);

/// Median distance along the optical axis of the points in view [m]; 1 without any.
inline double median_depth_m(const mapping::MapCloud& cloud, const MapView& view) {
  const Pose T = inverse(view.T_world_camera);
  const Eigen::Matrix3d R = T.R();
  const Eigen::Vector3d t = T.t();
  std::vector<double> depths;
  for (const cv::Point3f& p : cloud.points_m) {
    const Eigen::Vector3d q = R * Eigen::Vector3d(p.x, p.y, p.z) + t;
    if (!(q.z() > 0.05)) continue;
    const double u = view.camera.fx_px * q.x() / q.z() + view.camera.cx_px,
                 v = view.camera.fy_px * q.y() / q.z() + view.camera.cy_px;
    if (u >= 0 && v >= 0 && u < view.size.width && v < view.size.height) depths.push_back(q.z());
  }
  if (depths.empty()) return 1;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

/// The largest of 1, 2 or 5 times a power of ten that is not above `most`.
inline double round_length(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)));
  return most >= 5 * power ? 5 * power : most >= 2 * power ? 2 * power : power;
}

inline void write(cv::Mat& picture, const std::string& text, cv::Point at, double size = 0.45) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kMapPaper, 3, cv::LINE_AA);
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kMapInk, 1, cv::LINE_AA);
}

/// Draws a scale bar of a round length and the world's axes into the lower left corner.
inline void draw_scale_and_axes(const mapping::MapCloud& cloud, const MapView& view, cv::Mat& picture) {
  const double depth_m = median_depth_m(cloud, view);
  const double length_m = round_length(view.size.width / 5.0 * depth_m / view.camera.fx_px);
  const int length_px = std::max(1, cvRound(view.camera.fx_px * length_m / depth_m));
  const cv::Point bar(16, picture.rows - 16);
  for (const auto& [colour, width] : {std::pair(kMapPaper, 5), std::pair(kMapInk, 2)}) {
    cv::line(picture, bar, bar + cv::Point(length_px, 0), colour, width, cv::LINE_AA);
    for (const int x : {0, length_px})
      cv::line(picture, bar + cv::Point(x, -5), bar + cv::Point(x, 5), colour, width, cv::LINE_AA);
  }
  write(picture, fmt::format("{:g} m (at {:.1f} m from the viewer)", length_m, depth_m),
        bar + cv::Point(0, -12));

  constexpr double kAxis_px = 42;
  const cv::Point origin(66, picture.rows - 118);
  const Eigen::Matrix3d R = inverse(view.T_world_camera).R();
  const cv::Scalar colours[] = {{60, 60, 255}, {60, 220, 60}, {255, 140, 60}};
  std::vector<int> order{0, 1, 2};  // axes that point away from the viewer first
  std::sort(order.begin(), order.end(), [&](int a, int b) { return R(2, a) > R(2, b); });
  for (const int axis : order) {
    const cv::Point tip(origin.x + cvRound(kAxis_px * R(0, axis)), origin.y + cvRound(kAxis_px * R(1, axis)));
    cv::line(picture, origin, tip, kMapPaper, 5, cv::LINE_AA);
    cv::arrowedLine(picture, origin, tip, colours[axis], 2, cv::LINE_AA, 0, 0.2);
    const cv::Point beside(origin.x + cvRound(1.3 * (tip.x - origin.x)) - 4,
                           origin.y + cvRound(1.3 * (tip.y - origin.y)) + 4);
    write(picture, std::string(1, static_cast<char>('x' + axis)), beside);
  }
}

}  // namespace detail

/// Draws two views of a map side by side under a title, each with a caption, a scale and the world's axes.
/// `first`: a camera that observed the map.
inline cv::Mat draw_map(const mapping::MapCloud& cloud, double leaf_m, const MapView& first,
                        const std::string& title) {
  const mapping::Overview above = mapping::overview_of(cloud, first.camera, first.size, first.T_world_camera);
  const MapView from_above{first.camera, first.size, above.T_world_camera};
  cv::Mat left = mapping::render_cloud(above.cloud, leaf_m, first.camera, first.size, above.T_world_camera),
          right = mapping::render_cloud(cloud, leaf_m, first.camera, first.size, first.T_world_camera), both;
  detail::draw_scale_and_axes(above.cloud, from_above, left);
  detail::draw_scale_and_axes(cloud, first, right);
  const bool whole = above.cloud.size() == cloud.size();
  detail::write(left, whole ? "from behind and above" : "from behind and above, without the ceiling",
                {12, 20}, 0.5);
  detail::write(right, "from the first camera", {12, 20}, 0.5);
  cv::hconcat(left, right, both);
  constexpr int kTitle_px = 30;
  cv::Mat page(both.rows + kTitle_px, both.cols, CV_8UC3, detail::kMapPaper);
  both.copyTo(page(cv::Rect(0, kTitle_px, both.cols, both.rows)));
  detail::write(page, title, {12, 20}, 0.5);
  return page;
}

}  // namespace dynfilter::command
