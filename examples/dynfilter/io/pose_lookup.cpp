// SPDX-License-Identifier: MIT
#include "io/pose_lookup.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <vector>

namespace dynfilter::io {

std::optional<Pose> PoseLookup::at(double timestamp_s) const {
  const auto next = std::lower_bound(trajectory_.begin(), trajectory_.end(), timestamp_s,
                                     [](const StampedPose& p, double t) { return p.timestamp_s < t; });
  if (next != trajectory_.end() && next->timestamp_s - timestamp_s <= kSameS) return next->T_world_camera;
  if (next == trajectory_.begin()) return std::nullopt;
  const auto last = next - 1;
  if (timestamp_s - last->timestamp_s <= kSameS) return last->T_world_camera;
  if (next == trajectory_.end() || next->timestamp_s - last->timestamp_s > max_gap_s_) return std::nullopt;
  const double share = (timestamp_s - last->timestamp_s) / (next->timestamp_s - last->timestamp_s);
  const Eigen::Quaterniond from(last->T_world_camera.R()), to(next->T_world_camera.R());
  const Eigen::Vector3d t = (1 - share) * last->T_world_camera.t() + share * next->T_world_camera.t();
  return Pose::from(from.slerp(share, to).toRotationMatrix(), t);
}

std::pair<std::size_t, double> PoseLookup::gaps() const {
  std::pair<std::size_t, double> result{0, 0};
  for (std::size_t i = 1; i < trajectory_.size(); ++i) {
    const double gap_s = trajectory_[i].timestamp_s - trajectory_[i - 1].timestamp_s;
    if (gap_s > max_gap_s_) result = {result.first + 1, std::max(result.second, gap_s)};
  }
  return result;
}

std::optional<Pose> align_poses(const Trajectory& to, const Trajectory& from) {
  const PoseLookup lookup(to);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  std::vector<std::pair<Pose, Pose>> pairs;
  for (const StampedPose& pose : from) {
    const std::optional<Pose> other = lookup.at(pose.timestamp_s);
    if (!other) continue;
    pairs.emplace_back(*other, pose.T_world_camera);
    sum += other->R() * pose.T_world_camera.R().transpose();
  }
  if (pairs.empty()) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d UV = svd.matrixU() * svd.matrixV().transpose();
  const Eigen::Vector3d sign(1, 1, UV.determinant() < 0 ? -1 : 1);
  const Eigen::Matrix3d R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  for (const auto& [a, b] : pairs) t += a.t() - R * b.t();
  return Pose::from(R, t / static_cast<double>(pairs.size()));
}

}  // namespace dynfilter::io
