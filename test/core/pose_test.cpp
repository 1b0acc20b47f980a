// SPDX-License-Identifier: MIT
#include <dynfilter/core/pose.hpp>

#include "doctest/doctest.h"

namespace pose_test {

using dynfilter::Pose;

TEST_CASE("a pose times its inverse is the identity") {
  const Eigen::Matrix3d R(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  const Pose T = Pose::from(R, Eigen::Vector3d(1, -2, 0.5));
  const Pose I = T * dynfilter::inverse(T);
  CHECK((I.R() - Eigen::Matrix3d::Identity()).norm() < 1e-12);
  CHECK(I.t().norm() < 1e-12);
}

TEST_CASE("composition chains frames: T_a_c p_c = T_a_b (T_b_c p_c)") {
  const Pose T_a_b =
      Pose::from(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {1, 0, 0});
  const Pose T_b_c =
      Pose::from(Eigen::AngleAxisd(-1.1, Eigen::Vector3d::UnitX()).toRotationMatrix(), {0, 2, 1});
  const Eigen::Vector3d p_c(0.2, 0.4, -3);
  const Eigen::Vector3d p_b = T_b_c.R() * p_c + T_b_c.t();
  CHECK((T_a_b.isometry() * p_b - (T_a_b * T_b_c).isometry() * p_c).norm() < 1e-12);
}

}  // namespace pose_test
