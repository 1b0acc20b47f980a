// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace dynfilter::synth {

/// Rigid parts of a person. In its own frame, a limb extends from its upper joint along -z.
/// x is the person's right, y is forward.
enum BodyPart {
  kPelvis,
  kChest,
  kHead,
  kLeftUpperArm,
  kRightUpperArm,
  kLeftForearm,
  kRightForearm,
  kLeftHand,
  kRightHand,
  kLeftThigh,
  kRightThigh,
  kLeftShin,
  kRightShin,
  kLeftFoot,
  kRightFoot,
  kBodyPartCount
};

using BodyPose = std::array<Eigen::Isometry3d, kBodyPartCount>;  // world <- part

/// Lengths of a person 1.75 m tall, times `scale`.
struct BodyShape {
  double scale = 1;
  double thigh() const { return 0.43 * scale; }
  double shin() const { return 0.42 * scale; }
  double ankle_height() const { return 0.08 * scale; }
  double hip_height() const { return 0.92 * scale; }
  double hip_half() const { return 0.095 * scale; }
  double waist() const { return 0.10 * scale; }         // above the hips
  double shoulder_up() const { return 0.395 * scale; }  // above the waist
  double shoulder_half() const { return 0.182 * scale; }
  double neck_up() const { return 0.47 * scale; }  // above the waist
  double upper_arm() const { return 0.29 * scale; }
  double forearm() const { return 0.26 * scale; }
};

inline Eigen::Isometry3d frame_at(const Eigen::Vector3d& origin, const Eigen::Matrix3d& rotation) {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = rotation;
  frame.translation() = origin;
  return frame;
}

inline Eigen::Matrix3d turn(double angle_rad, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

/// Frame of a bone from `origin` towards `end`, with its y axis as close to `ahead` as possible.
inline Eigen::Isometry3d bone(const Eigen::Vector3d& origin, const Eigen::Vector3d& end,
                              const Eigen::Vector3d& ahead) {
  const Eigen::Vector3d z = (origin - end).normalized();
  Eigen::Vector3d x = ahead.cross(z);
  if (x.norm() < 1e-6) x = z.unitOrthogonal();
  x.normalize();
  Eigen::Matrix3d rotation;
  rotation << x, z.cross(x), z;
  return frame_at(origin, rotation);
}

/// Middle joint of a two-bone chain from root towards target, bent towards `bend`.
inline Eigen::Vector3d middle_joint(const Eigen::Vector3d& root, Eigen::Vector3d& target, double first,
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

/// Pose of the trunk and targets of hands and feet in the world. Index 0 is left, 1 is right.
struct BodyTargets {
  Eigen::Isometry3d pelvis = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d chest_in_pelvis = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d head_in_chest = Eigen::Matrix3d::Identity();
  Eigen::Vector3d wrist[2], ankle[2];
  Eigen::Matrix3d foot[2];
  Eigen::Vector3d elbow_bend[2], knee_bend[2];
  double hand_curl_rad = 0.2;
};

inline BodyPose solve_pose(const BodyShape& shape, const BodyTargets& to) {
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

}  // namespace dynfilter::synth
