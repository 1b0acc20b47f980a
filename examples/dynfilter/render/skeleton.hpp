// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace dynfilter::render {

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

Eigen::Isometry3d frame_at(const Eigen::Vector3d& origin, const Eigen::Matrix3d& rotation);

inline Eigen::Matrix3d turn(double angle_rad, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

/// Frame of a bone from `origin` towards `end`, with its y axis as close to `ahead` as possible.
Eigen::Isometry3d bone(const Eigen::Vector3d& origin, const Eigen::Vector3d& end,
                       const Eigen::Vector3d& ahead);

/// Middle joint of a two-bone chain from root towards target, bent towards `bend`.
Eigen::Vector3d middle_joint(const Eigen::Vector3d& root, Eigen::Vector3d& target, double first,
                             double second, const Eigen::Vector3d& bend);

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

BodyPose solve_pose(const BodyShape& shape, const BodyTargets& to);

}  // namespace dynfilter::render
