// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <random>
#include <vector>

#include "frame_features.hpp"
#include "matching.hpp"
#include "projection.hpp"

namespace dynfilter::odometry {

/// Estimates a pose without a prediction.
/// Compares descriptors with all known points (mutual best, ratio test).
/// Then runs RANSAC over three 3D-3D pairs, scored by reprojection; without depth over 3D-2D pairs.
/// Used for relocalisation only. Cost: about 5 ms.
class PoseRecovery {
 public:
  /// `with_depth`: features have depth. Without it the pose comes from pixels only (PnP).
  explicit PoseRecovery(const Pinhole& camera, bool with_depth = true)
      : camera_(camera), with_depth_(with_depth) {}

  /// Returns the number of inlier pairs. Sets the pose if it is at least `min_inliers`.
  int recover(const std::vector<SearchPoint>& points, const FrameFeatures& features, int min_inliers,
              Eigen::Isometry3d& T_camera_world) {
    match(points, features);
    if (static_cast<int>(pairs_.size()) < min_inliers) return 0;
    if (!with_depth_) return recover_from_pixels(points, min_inliers, T_camera_world);
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
  static constexpr double kRatio = 0.8, kReach_px = 4.0, kConfidence = 0.999;

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
    if (f < 0 || best_point_[f].index != p || (with_depth_ && !(features.depth_m[f] > 0))) return;
    const cv::Point2f at = features.keypoints_undistorted[f].pt;
    const double depth = with_depth_ ? features.depth_m[f] : 1;
    pairs_.push_back(
        {p, {at.x, at.y, camera_.baseline_fx_px_m / depth}, camera_.back_project(at.x, at.y, depth)});
  }

  int recover_from_pixels(const std::vector<SearchPoint>& points, int min_inliers,
                          Eigen::Isometry3d& T_camera_world) const {
    std::vector<cv::Point3d> world;
    std::vector<cv::Point2d> px;
    for (const Pair& pair : pairs_) {
      const Eigen::Vector3d& p = points[pair.point].world_m;
      world.emplace_back(p.x(), p.y(), p.z());
      px.emplace_back(pair.measured_px.x(), pair.measured_px.y());
    }
    const cv::Matx33d K(camera_.fx_px, 0, camera_.cx_px, 0, camera_.fy_px, camera_.cy_px, 0, 0, 1);
    cv::Mat turn, t, R;
    std::vector<int> inliers;
    const bool found =
        cv::solvePnPRansac(world, px, K, cv::noArray(), turn, t, false, kTrials,
                           static_cast<float>(kReach_px), kConfidence, inliers, cv::SOLVEPNP_EPNP);
    if (!found || static_cast<int>(inliers.size()) < min_inliers) return 0;
    cv::Rodrigues(turn, R);
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation;
    cv::cv2eigen(R, rotation);
    cv::cv2eigen(t, translation);
    T_camera_world.linear() = rotation;
    T_camera_world.translation() = translation;
    return static_cast<int>(inliers.size());
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
  bool with_depth_;
  std::vector<Best> best_point_, best_feature_;
  std::vector<Pair> pairs_;
};

}  // namespace dynfilter::odometry
