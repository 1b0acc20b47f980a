// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::mapping {

/// A picture of a cloud from a camera: every point is a square as large as `leaf_m` appears there, the
/// nearest one counts. CV_8UC3 on dark grey. Distortion is neglected.
inline cv::Mat render_cloud(const MapCloud& cloud, double leaf_m, const Camera& camera, cv::Size size,
                            const Pose& T_world_camera) {
  cv::Mat picture(size, CV_8UC3, cv::Scalar(40, 40, 40)), depth(size, CV_32FC1, cv::Scalar(1e9));
  const Pose T = inverse(T_world_camera);
  const Eigen::Matrix3d R = T.R();
  const Eigen::Vector3d t = T.t();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const cv::Point3f& p = cloud.points_m[i];
    const Eigen::Vector3d q = R * Eigen::Vector3d(p.x, p.y, p.z) + t;
    if (!(q.z() > 0.05)) continue;
    const double u = camera.fx_px * q.x() / q.z() + camera.cx_px,
                 v = camera.fy_px * q.y() / q.z() + camera.cy_px;
    const double half = std::clamp(0.6 * leaf_m * camera.fx_px / q.z(), 0.5, 20.0);
    if (!(u > -half && v > -half && u < size.width + half && v < size.height + half)) continue;
    const cv::Rect splat = cv::Rect(cv::Point(cvRound(u - half), cvRound(v - half)),
                                    cv::Point(cvRound(u + half) + 1, cvRound(v + half) + 1)) &
                           cv::Rect(cv::Point(), size);
    const auto z = static_cast<float>(q.z());
    for (int y = splat.y; y < splat.y + splat.height; ++y)
      for (int x = splat.x; x < splat.x + splat.width; ++x) {
        if (depth.at<float>(y, x) <= z) continue;
        depth.at<float>(y, x) = z;
        picture.at<cv::Vec3b>(y, x) = cloud.colours.empty() ? cv::Vec3b(200, 200, 200) : cloud.colours[i];
      }
  }
  return picture;
}

/// An oblique overview: from behind and above the first camera, far enough to hold the middle 96 % of the
/// cloud per axis. `T_world_first`: its y axis points down in the scene.
inline Pose overview_pose(const MapCloud& cloud, const Pose& T_world_first, const Camera& camera,
                          cv::Size size) {
  if (cloud.size() == 0) return T_world_first;
  const Pose T = inverse(T_world_first);
  const Eigen::Matrix3d R = T.R();
  std::vector<double> axes[3];
  for (const cv::Point3f& p : cloud.points_m) {
    const Eigen::Vector3d q = R * Eigen::Vector3d(p.x, p.y, p.z) + T.t();
    for (int a = 0; a < 3; ++a) axes[a].push_back(q(a));
  }
  Eigen::Vector3d low, high;
  for (int a = 0; a < 3; ++a) {
    const auto n = static_cast<std::ptrdiff_t>(axes[a].size());
    std::nth_element(axes[a].begin(), axes[a].begin() + n / 50, axes[a].end());
    low(a) = axes[a][static_cast<std::size_t>(n / 50)];
    std::nth_element(axes[a].begin(), axes[a].begin() + n - 1 - n / 50, axes[a].end());
    high(a) = axes[a][static_cast<std::size_t>(n - 1 - n / 50)];
  }
  constexpr double kDown = 0.6;  // radians
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(-kDown, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const double radius = 0.5 * (high - low).norm();
  const double half_view = std::min(size.width / camera.fx_px, size.height / camera.fy_px) / 2;
  const Eigen::Vector3d centre = 0.5 * (low + high);
  const Eigen::Vector3d eye = centre - turn.col(2) * (0.85 * radius / std::sin(std::atan(half_view)));
  return T_world_first * Pose::from(turn, eye);
}

}  // namespace dynfilter::mapping
