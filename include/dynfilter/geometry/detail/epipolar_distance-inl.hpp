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
