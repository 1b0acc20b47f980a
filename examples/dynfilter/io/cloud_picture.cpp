// SPDX-License-Identifier: MIT
#include "io/cloud_picture.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <utility>
#include <vector>

namespace dynfilter::mapping {

cv::Mat render_cloud(const MapCloud& cloud, double leaf_m, const Camera& camera, cv::Size size,
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

Pose level_pose(const MapCloud& cloud, const Pose& T_world_camera) {
  const Pose T = inverse(T_world_camera);
  // One point per 10 cm: key objects are much denser than the rest, and a screen is upright.
  std::vector<std::array<int, 3>> cells;
  for (const cv::Point3f& p : cloud.points_m)
    cells.push_back({cvFloor(10 * p.x), cvFloor(10 * p.y), cvFloor(10 * p.z)});
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  const std::size_t step = cells.size() / 20000 + 1;
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < cells.size(); i += step) {
    const Eigen::Vector3d p(cells[i][0], cells[i][1], cells[i][2]);
    points.push_back(T.R() * (0.1 * p) + T.t());
  }
  constexpr double kDeg = 3.14159265358979323846 / 180;
  double best_score = 0, tilt_deg = 0, roll_deg = 0;
  const auto try_one = [&](double tilt, double roll) {
    const Eigen::Vector3d down = Eigen::AngleAxisd(tilt * kDeg, Eigen::Vector3d::UnitX()) *
                                 Eigen::AngleAxisd(roll * kDeg, Eigen::Vector3d::UnitZ()) *
                                 Eigen::Vector3d::UnitY();
    std::vector<int> pile(256, 0);  // bins of 8 cm
    for (const Eigen::Vector3d& q : points)
      ++pile[static_cast<std::size_t>(std::clamp(down.dot(q) / 0.08 + 128, 0.0, 255.0))];
    double score = 0;
    for (std::size_t i = 1; i + 1 < pile.size(); ++i) score += static_cast<double>(pile[i]) * pile[i];
    if (score > best_score) best_score = score, tilt_deg = tilt, roll_deg = roll;
  };
  for (int tilt = -44; tilt <= 44; tilt += 2) try_one(tilt, 0);
  for (int roll = -10; roll <= 10; ++roll) try_one(tilt_deg, roll);
  const double coarse_deg = tilt_deg;
  for (int half = -4; half <= 4; ++half) try_one(coarse_deg + 0.5 * half, roll_deg);
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(tilt_deg * kDeg, Eigen::Vector3d::UnitX()) *
                                Eigen::AngleAxisd(roll_deg * kDeg, Eigen::Vector3d::UnitZ()))
                                   .toRotationMatrix();
  return T_world_camera * Pose::from(turn, Eigen::Vector3d::Zero());
}

MapCloud without_ceiling(const MapCloud& cloud, const Pose& T_world_level, double above_m) {
  MapCloud low;
  const Eigen::Vector3d down = T_world_level.R().col(1);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const cv::Point3f& p = cloud.points_m[i];
    if (down.dot(Eigen::Vector3d(p.x, p.y, p.z) - T_world_level.t()) < -above_m) continue;
    low.points_m.push_back(p);
    if (!cloud.colours.empty()) low.colours.push_back(cloud.colours[i]);
    if (!cloud.classes.empty()) low.classes.push_back(cloud.classes[i]);
  }
  return low;
}

Pose overview_pose(const MapCloud& cloud, const Pose& T_world_level, const Camera& camera, cv::Size size) {
  if (cloud.size() == 0) return T_world_level;
  const Pose T = inverse(T_world_level);
  std::vector<double> axes[3];
  for (const cv::Point3f& p : cloud.points_m) {
    const Eigen::Vector3d q = T.R() * Eigen::Vector3d(p.x, p.y, p.z) + T.t();
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
  constexpr double kDown = 0.75;  // radians
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(-kDown, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const Eigen::Vector3d centre = 0.5 * (low + high);
  const double x_limit = 0.48 * size.width / camera.fx_px, y_limit = 0.48 * size.height / camera.fy_px;
  double back_m = 0.1;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d c((corner & 1 ? low : high).x(), (corner & 2 ? low : high).y(),
                            (corner & 4 ? low : high).z());
    const Eigen::Vector3d q = turn.transpose() * (c - centre);
    back_m =
        std::max({back_m, std::abs(q.x()) / x_limit - q.z(), std::abs(q.y()) / y_limit - q.z(), 0.3 - q.z()});
  }
  return T_world_level * Pose::from(turn, centre - turn.col(2) * back_m);
}

Overview overview_of(const MapCloud& cloud, const Camera& camera, cv::Size size, const Pose& T_world_first) {
  const Pose level = level_pose(cloud, T_world_first);
  MapCloud low = without_ceiling(cloud, level);
  if (2 * low.size() < cloud.size()) low = cloud;  // a shelf, a staircase: no room with a ceiling
  const Pose pose = overview_pose(low, level, camera, size);
  return {std::move(low), pose};
}

cv::Mat render_overview(const MapCloud& cloud, double leaf_m, const Camera& camera, cv::Size size,
                        const Pose& T_world_first) {
  const Overview above = overview_of(cloud, camera, size, T_world_first);
  return render_cloud(above.cloud, leaf_m, camera, size, above.T_world_camera);
}

}  // namespace dynfilter::mapping
