// SPDX-License-Identifier: MIT
#include "render/skeleton.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dynfilter::render {

Eigen::Isometry3d frame_at(const Eigen::Vector3d& origin, const Eigen::Matrix3d& rotation) {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = rotation;
  frame.translation() = origin;
  return frame;
}

Eigen::Isometry3d bone(const Eigen::Vector3d& origin, const Eigen::Vector3d& end,
                       const Eigen::Vector3d& ahead) {
  const Eigen::Vector3d z = (origin - end).normalized();
  Eigen::Vector3d x = ahead.cross(z);
  if (x.norm() < 1e-6) x = z.unitOrthogonal();
  x.normalize();
  Eigen::Matrix3d rotation;
  rotation << x, z.cross(x), z;
  return frame_at(origin, rotation);
}

Eigen::Vector3d middle_joint(const Eigen::Vector3d& root, Eigen::Vector3d& target, double first,
                             double second, const Eigen::Vector3d& bend) {
  Eigen::Vector3d axis = target - root;
  const double wanted = axis.norm();
  const double reach = std::min(std::max(wanted, 0.15 * (first + second)), 0.998 * (first + second));
  axis = wanted > 1e-9 ? Eigen::Vector3d(axis / wanted) : Eigen::Vector3d(0, 0, -1);
  target = root + reach * axis;
  const double along = (reach * reach + first * first - second * second) / (2 * reach);
  Eigen::Vector3d side = bend - bend.dot(axis) * axis;
  side = side.norm() > 1e-6 ? Eigen::Vector3d(side.normalized()) : axis.unitOrthogonal();
  return root + along * axis + std::sqrt(std::max(0.0, first * first - along * along)) * side;
}

BodyPose solve_pose(const BodyShape& shape, const BodyTargets& to) {
  BodyPose pose;
  pose[kPelvis] = to.pelvis;
  pose[kChest] = to.pelvis * frame_at({0, 0, shape.waist()}, to.chest_in_pelvis);
  pose[kHead] = pose[kChest] * frame_at({0, 0.01 * shape.scale, shape.neck_up()}, to.head_in_chest);
  const Eigen::Vector3d chest_ahead = pose[kChest].linear().col(1);
  for (std::size_t side = 0; side < 2; ++side) {
    const double sign = side == 0 ? -1 : 1;
    const Eigen::Vector3d shoulder =
        pose[kChest] * Eigen::Vector3d(sign * shape.shoulder_half(), 0, shape.shoulder_up());
    Eigen::Vector3d wrist = to.wrist[side];
    const Eigen::Vector3d elbow =
        middle_joint(shoulder, wrist, shape.upper_arm(), shape.forearm(), to.elbow_bend[side]);
    pose[kLeftUpperArm + side] = bone(shoulder, elbow, chest_ahead);
    pose[kLeftForearm + side] = bone(elbow, wrist, chest_ahead + 0.3 * (wrist - elbow));
    pose[kLeftHand + side] = frame_at(
        wrist, pose[kLeftForearm + side].linear() * turn(to.hand_curl_rad, Eigen::Vector3d::UnitX()));
    const Eigen::Vector3d hip = to.pelvis * Eigen::Vector3d(sign * shape.hip_half(), 0, 0);
    Eigen::Vector3d ankle = to.ankle[side];
    const Eigen::Vector3d knee = middle_joint(hip, ankle, shape.thigh(), shape.shin(), to.knee_bend[side]);
    pose[kLeftThigh + side] = bone(hip, knee, to.knee_bend[side] + 0.01 * (hip - knee));
    pose[kLeftShin + side] = bone(knee, ankle, to.knee_bend[side]);
    pose[kLeftFoot + side] = frame_at(ankle, to.foot[side]);
  }
  return pose;
}

}  // namespace dynfilter::render
