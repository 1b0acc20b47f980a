// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/pose.hpp>

#include <cmath>
#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE bool is_rigid(const Pose& T_a_b, double tolerance) {
  for (const double value : T_a_b.rotation)
    if (!std::isfinite(value)) return false;
  for (const double value : T_a_b.translation_m)
    if (!std::isfinite(value)) return false;
  const Eigen::Matrix3d R = T_a_b.R(), off = R * R.transpose() - Eigen::Matrix3d::Identity();
  return off.cwiseAbs().maxCoeff() <= tolerance && R.col(0).cross(R.col(1)).dot(R.col(2)) > 0;
}

}  // namespace dynfilter
