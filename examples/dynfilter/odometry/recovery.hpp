// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <random>
#include <vector>

#include "frame_features.hpp"
#include "matching.hpp"
#include "projection.hpp"

namespace dynfilter::odometry {

/// Estimates a pose without a prediction.
/// Compares descriptors with all known points (mutual best, ratio test).
/// Then runs RANSAC over three 3D-3D pairs, scored by reprojection.
/// Used for relocalisation only. Cost: about 5 ms.
class PoseRecovery {
 public:
  explicit PoseRecovery(const Pinhole& camera) : camera_(camera) {}

  /// Returns the number of inlier pairs. Sets the pose if it is at least `min_inliers`.
  int recover(const std::vector<SearchPoint>& points, const FrameFeatures& features, int min_inliers,
              Eigen::Isometry3d& T_camera_world) {
    match(points, features);
    if (static_cast<int>(pairs_.size()) < min_inliers) return 0;
    std::mt19937 random(1);
    int best = 0;
    for (int i = 0; i < kTrials; ++i) {
      Eigen::Isometry3d T;
      if (!hypothesis(points, random, T)) continue;
      const int score = count(points, T);
      if (score <= best) continue;
      best = score;
      if (best >= min_inliers) T_camera_world = T;
    }
    return best >= min_inliers ? best : 0;
  }

 private:
  static constexpr int kTrials = 300, kMaxDistance = 64;
  static constexpr double kRatio = 0.8, kReach_px = 4.0;

  struct Pair {
    std::int32_t point;
    Eigen::Vector3d measured_px, camera_m;
  };

  void match(const std::vector<SearchPoint>& points, const FrameFeatures& features) {
    pairs_.clear();
    best_point_.assign(features.size(), {-1, 257});
    best_feature_.assign(points.size(), {-1, 257});
    for (std::size_t p = 0; p < points.size(); ++p) {
      int second = 257;
      for (std::size_t f = 0; f < features.size(); ++f) {
        const int d = hamming(points[p].descriptor, features.descriptors[f]);
        if (d < best_point_[f].distance) best_point_[f] = {static_cast<std::int32_t>(p), d};
        if (d < best_feature_[p].distance) {
          second = best_feature_[p].distance;
          best_feature_[p] = {static_cast<std::int32_t>(f), d};
        } else if (d < second) {
          second = d;
        }
      }
      if (best_feature_[p].distance > std::min<double>(kMaxDistance, kRatio * second))
        best_feature_[p].index = -1;
    }
    for (std::size_t p = 0; p < points.size(); ++p) add_pair(static_cast<std::int32_t>(p), features);
  }

  void add_pair(std::int32_t p, const FrameFeatures& features) {
    const std::int32_t f = best_feature_[p].index;
    if (f < 0 || best_point_[f].index != p || !(features.depth_m[f] > 0)) return;
    const cv::Point2f at = features.keypoints_undistorted[f].pt;
    const double depth = features.depth_m[f];
    pairs_.push_back(
        {p, {at.x, at.y, camera_.baseline_fx_px_m / depth}, camera_.back_project(at.x, at.y, depth)});
  }

  bool hypothesis(const std::vector<SearchPoint>& points, std::mt19937& random, Eigen::Isometry3d& T) const {
    Eigen::Matrix3d world, camera;
    std::array<std::size_t, 3> pick;
    for (int k = 0; k < 3; ++k) {
      pick[k] = random() % pairs_.size();
      for (int j = 0; j < k; ++j)
        if (pick[j] == pick[k]) return false;
      world.col(k) = points[pairs_[pick[k]].point].world_m;
      camera.col(k) = pairs_[pick[k]].camera_m;
    }
    const double area = (world.col(1) - world.col(0)).cross(world.col(2) - world.col(0)).norm();
    if (area < 1e-3) return false;
    T.matrix() = Eigen::umeyama(world, camera, false);
    return true;
  }

  int count(const std::vector<SearchPoint>& points, const Eigen::Isometry3d& T) const {
    int inliers = 0;
    for (const Pair& pair : pairs_) {
      const Eigen::Vector3d p = T * points[pair.point].world_m;
      if (p.z() > 0.1 && (camera_.project(p) - pair.measured_px).norm() < kReach_px) ++inliers;
    }
    return inliers;
  }

  struct Best {
    std::int32_t index;
    int distance;
  };

  Pinhole camera_;
  std::vector<Best> best_point_, best_feature_;
  std::vector<Pair> pairs_;
};

}  // namespace dynfilter::odometry
