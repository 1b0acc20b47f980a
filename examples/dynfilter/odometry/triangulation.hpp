// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <optional>

#include "projection.hpp"

namespace dynfilter::odometry {

/// A pixel of a camera, with the noise of its octave.
struct ViewOfPoint {
  Eigen::Isometry3d T_camera_world;
  Eigen::Vector2d px;
  double sigma_px = 1;
};

/// The point that two views see, by the linear method (Hartley and Zisserman, sec. 12.2).
inline Eigen::Vector3d triangulate(const Pinhole& camera, const ViewOfPoint& a, const ViewOfPoint& b) {
  Eigen::Matrix4d A;
  int row = 0;
  for (const ViewOfPoint* view : {&a, &b}) {
    const double x = (view->px.x() - camera.cx_px) / camera.fx_px,
                 y = (view->px.y() - camera.cy_px) / camera.fy_px;
    const Eigen::Matrix4d T = view->T_camera_world.matrix();
    A.row(row++) = x * T.row(2) - T.row(0);
    A.row(row++) = y * T.row(2) - T.row(1);
  }
  const Eigen::Vector4d p = Eigen::JacobiSVD<Eigen::Matrix4d>(A, Eigen::ComputeFullV).matrixV().col(3);
  return p.head<3>() / p.w();
}

/// Cosine of the angle between the rays from both cameras to a point.
inline double cos_parallax(const Eigen::Vector3d& world_m, const ViewOfPoint& a, const ViewOfPoint& b) {
  const Eigen::Vector3d ray_a = world_m - a.T_camera_world.inverse().translation(),
                        ray_b = world_m - b.T_camera_world.inverse().translation();
  return ray_a.normalized().dot(ray_b.normalized());
}

/// True if the point is in front of the camera and its pixel agrees (95 % quantile of chi-square).
inline bool agrees(const Pinhole& camera, const Eigen::Vector3d& world_m, const ViewOfPoint& view) {
  constexpr double kChi2 = 5.991;
  const Eigen::Vector3d p = view.T_camera_world * world_m;
  if (!(p.z() > 0)) return false;
  return (camera.project(p).head<2>() - view.px).squaredNorm() <= kChi2 * view.sigma_px * view.sigma_px;
}

/// A triangulated point that both views confirm; nullopt for less parallax than `max_cosine` means.
inline std::optional<Eigen::Vector3d> confirmed_point(const Pinhole& camera, const ViewOfPoint& a,
                                                      const ViewOfPoint& b, double max_cosine) {
  const Eigen::Vector3d p = triangulate(camera, a, b);
  if (!p.allFinite() || !agrees(camera, p, a) || !agrees(camera, p, b)) return std::nullopt;
  if (!(cos_parallax(p, a, b) < max_cosine)) return std::nullopt;
  return p;
}

}  // namespace dynfilter::odometry
