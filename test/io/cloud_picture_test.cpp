// SPDX-License-Identifier: MIT
#include "io/cloud_picture.hpp"

#include "doctest/doctest.h"

namespace cloud_picture_test {

using namespace dynfilter;
using namespace dynfilter::mapping;

namespace {

/// A room of 4 x 2.6 x 4 m around the origin, y down: floor, ceiling and three walls, a point every 8 cm.
MapCloud room() {
  MapCloud cloud;
  const auto add = [&](double x, double y, double z) {
    cloud.points_m.emplace_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
  };
  for (double a = -2; a <= 2; a += 0.08)
    for (double b = -2; b <= 2; b += 0.08) {
      add(a, 1.3, b), add(a, -1.3, b);
      add(a, 0.65 * b, 2), add(-2, 0.65 * a, b), add(2, 0.65 * a, b);
    }
  return cloud;
}

Pose tilted(double tilt_deg, double roll_deg) {
  constexpr double kDeg = 3.14159265358979323846 / 180;
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(roll_deg * kDeg, Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(-tilt_deg * kDeg, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  return Pose::from(R, Eigen::Vector3d(0.1, 0, -0.5));
}

Camera camera_160() {
  Camera camera;
  camera.fx_px = camera.fy_px = 130, camera.cx_px = 79.5, camera.cy_px = 59.5;
  return camera;
}

}  // namespace

TEST_CASE("a tilted camera is levelled by what lies flat in the cloud") {
  for (const auto& [tilt_deg, roll_deg] : {std::pair(0.0, 0.0), {25.0, 0.0}, {-12.5, 0.0}, {31.0, 4.0}}) {
    const auto& shown = tilt_deg;  // clang 14 captures no structured binding
    CAPTURE(shown);
    const Pose level = level_pose(room(), tilted(tilt_deg, roll_deg));
    CHECK(level.R().col(1).dot(Eigen::Vector3d::UnitY()) > std::cos(0.025));
    CHECK((level.t() - Eigen::Vector3d(0.1, 0, -0.5)).norm() < 1e-12);
  }
}

TEST_CASE("the overview holds the room but for its ceiling") {
  const MapCloud cloud = room(), low = without_ceiling(cloud, Pose());
  float highest = 9;
  for (const cv::Point3f& p : low.points_m) highest = std::min(highest, p.y);
  CHECK(highest >= -0.5F);
  CHECK(low.size() > cloud.size() / 2);
  CHECK(low.size() < cloud.size() * 4 / 5);

  const Pose above = overview_pose(low, Pose(), camera_160(), {160, 120});
  const Pose T = inverse(above);
  int outside = 0, left = 160, right = 0;
  for (const cv::Point3f& p : low.points_m) {
    const Eigen::Vector3d q = T.R() * Eigen::Vector3d(p.x, p.y, p.z) + T.t();
    REQUIRE(q.z() > 0);
    const double u = 130 * q.x() / q.z() + 79.5, v = 130 * q.y() / q.z() + 59.5;
    outside += u < 0 || v < 0 || u >= 160 || v >= 120;
    left = std::min(left, static_cast<int>(u)), right = std::max(right, static_cast<int>(u));
  }
  CHECK(outside == 0);
  CHECK(right - left > 100);  // and fills the picture
  CHECK(overview_pose(MapCloud(), Pose(), camera_160(), {160, 120}).t().norm() == 0);
  CHECK(level_pose(MapCloud(), Pose()).t().norm() == 0);
}

}  // namespace cloud_picture_test
