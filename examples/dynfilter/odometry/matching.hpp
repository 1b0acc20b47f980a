// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "feature_grid.hpp"
#include "frame_features.hpp"
#include "projection.hpp"

namespace dynfilter::odometry {

/// A point to search for in a frame.
struct SearchPoint {
  Eigen::Vector3d world_m;
  Descriptor descriptor;
  int octave = 0;               ///< expected octave
  std::int64_t map_point = -1;  ///< -1: only a point of the last frame
};

struct Window {
  double radius_px = 15;  ///< at octave 0; grows with the octave
  int octaves = 1;        ///< search range below and above the expected octave
  int max_distance = 80;
  double max_ratio = 0.9;
};

/// Finds known points in a frame by descriptor, near their predicted positions.
/// Each point matches at most one feature and each feature at most one point.
/// The closer descriptor wins. Features with a map point are skipped.
class ProjectionMatcher {
 public:
  ProjectionMatcher(const Pinhole& camera, double scale_factor, int levels) : camera_(camera) {
    scale_.resize(levels, 1.0);
    for (int i = 1; i < levels; ++i) scale_[i] = scale_[i - 1] * scale_factor;
  }

  void set_image(cv::Size size) { image_ = size; }

  /// feature[i]: feature that matches points[i]; -1: none.
  void match(const std::vector<SearchPoint>& points, const Eigen::Isometry3d& T_camera_world,
             const FrameFeatures& features, const FeatureGrid& grid, const Window& window,
             std::vector<std::int32_t>& feature) {
    feature.assign(points.size(), -1);
    owner_.assign(features.size(), {-1, 257});
    for (std::size_t i = 0; i < points.size(); ++i) {
      Eigen::Vector3d expected_px;
      if (!visible(points[i].world_m, T_camera_world, expected_px)) continue;
      const Found found = search(points[i], expected_px, features, grid, window);
      if (found.feature < 0 || found.distance >= owner_[found.feature].distance) continue;
      Owner& owner = owner_[found.feature];
      if (owner.point >= 0) feature[owner.point] = -1;
      owner = {static_cast<std::int32_t>(i), found.distance};
      feature[i] = found.feature;
    }
  }

  /// True if a point is inside the image. Sets its position (u, v, disparity).
  bool visible(const Eigen::Vector3d& world_m, const Eigen::Isometry3d& T_camera_world,
               Eigen::Vector3d& expected_px) const {
    constexpr double kNear = 0.1;
    const Eigen::Vector3d p = T_camera_world * world_m;
    if (!(p.z() > kNear)) return false;
    expected_px = camera_.project(p);
    return expected_px.x() >= 0 && expected_px.y() >= 0 && expected_px.x() < image_.width &&
           expected_px.y() < image_.height;
  }

 private:
  struct Owner {
    std::int32_t point;
    int distance;
  };
  struct Found {
    std::int32_t feature = -1;
    int distance = 257, second = 257, octave = -1, second_octave = -1;
  };

  Found search(const SearchPoint& point, const Eigen::Vector3d& expected_px, const FrameFeatures& features,
               const FeatureGrid& grid, const Window& window) const {
    const int levels = static_cast<int>(scale_.size());
    const double radius = window.radius_px * scale_[std::clamp(point.octave, 0, levels - 1)];
    Found found;
    grid.visit(expected_px.x(), expected_px.y(), radius, [&](std::int32_t i) {
      const cv::KeyPoint& keypoint = features.keypoints_undistorted[i];
      if (features.map_point[i] >= 0 || std::abs(keypoint.octave - point.octave) > window.octaves) return;
      if (std::abs(keypoint.pt.x - expected_px.x()) > radius) return;
      if (std::abs(keypoint.pt.y - expected_px.y()) > radius) return;
      const float depth = features.depth_m[i];
      if (depth > 0 && std::abs(camera_.baseline_fx_px_m / depth - expected_px.z()) > radius) return;
      note(found, i, hamming(point.descriptor, features.descriptors[i]), keypoint.octave);
    });
    const bool ambiguous =
        found.octave == found.second_octave && found.distance > window.max_ratio * found.second;
    if (found.distance > window.max_distance || ambiguous) found.feature = -1;
    return found;
  }

  static void note(Found& found, std::int32_t feature, int distance, int octave) {
    if (distance < found.distance) {
      found.second = found.distance;
      found.second_octave = found.octave;
      found.distance = distance;
      found.octave = octave;
      found.feature = feature;
    } else if (distance < found.second) {
      found.second = distance;
      found.second_octave = octave;
    }
  }

  Pinhole camera_;
  cv::Size image_;
  std::vector<double> scale_;
  std::vector<Owner> owner_;
};

}  // namespace dynfilter::odometry
