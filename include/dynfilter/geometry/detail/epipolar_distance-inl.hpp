// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/epipolar_distance.hpp>

#include <Eigen/LU>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/pose.hpp>

namespace dynfilter {
namespace detail {

DYNFILTER_INLINE Eigen::Matrix3d camera_matrix(const Camera& camera) {
  Eigen::Matrix3d K;
  K << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1;
  return K;
}

}  // namespace detail
}  // namespace dynfilter

namespace dynfilter {

DYNFILTER_INLINE Matrix9 fundamental_from_pose(const Camera& camera, const Pose& T_current_reference) {
  const Eigen::Matrix3d K_inv = detail::camera_matrix(camera).inverse();
  const Eigen::Matrix3d E =
      detail::times(detail::cross_matrix(T_current_reference.t()), T_current_reference.R());
  const Eigen::Matrix3d F = detail::times(K_inv.transpose(), detail::times(E, K_inv));
  const double norm = F.norm();
  return detail::to_array(norm > 0 ? Eigen::Matrix3d(F / norm) : F);
}

}  // namespace dynfilter
