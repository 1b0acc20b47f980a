// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "map.hpp"
#include "options.hpp"
#include "projection.hpp"
#include "triangulation.hpp"

namespace dynfilter::odometry {

/// Map points for features without depth, from the newest keyframe and its neighbours.
/// A feature is searched along its epipolar line by descriptor, and triangulated.
/// Cost: about 5 ms per keyframe.
class NewPoints {
 public:
  NewPoints(const Pinhole& camera, const OdometryOptions& options) : camera_(camera), options_(options) {}

  void add(Map& map, std::int32_t newest) {
    const auto neighbours = static_cast<std::size_t>(options_.new_points.neighbours);
    std::vector<std::int32_t> others =
        map.covisible(map.keyframes[newest].features.map_point, neighbours + 1);
    others.erase(std::remove(others.begin(), others.end(), newest), others.end());
    for (const std::int32_t other : others)
      if (has_baseline(map, newest, other)) add_between(map, newest, other);
  }

 private:
  bool has_baseline(const Map& map, std::int32_t a, std::int32_t b) const {
    const Eigen::Isometry3d &T_a = map.keyframes[a].T_camera_world, &T_b = map.keyframes[b].T_camera_world;
    const double baseline = (T_a.inverse().translation() - T_b.inverse().translation()).norm();
    std::vector<double> depths;
    for (const std::int64_t i : map.keyframes[b].features.map_point)
      if (map.alive(i)) depths.push_back((T_b * map.point(i).world_m).z());
    if (depths.empty()) return false;
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    return baseline > options_.new_points.least_baseline_share * *middle;
  }

  void add_between(Map& map, std::int32_t a, std::int32_t b) {
    const FrameFeatures &in_a = map.keyframes[a].features, &in_b = map.keyframes[b].features;
    const Eigen::Isometry3d T_b_a =
        map.keyframes[b].T_camera_world * map.keyframes[a].T_camera_world.inverse();
    const Eigen::Matrix3d E = skew(T_b_a.translation()) * T_b_a.linear();
    free_.clear();
    for (std::size_t k = 0; k < in_b.size(); ++k)
      if (in_b.map_point[k] < 0) free_.push_back(static_cast<std::int32_t>(k));
    taken_.assign(in_b.size(), 0);
    for (std::size_t i = 0; i < in_a.size(); ++i) {
      if (in_a.map_point[i] >= 0) continue;
      const std::int32_t k = best_on_line(in_a, i, in_b, E);
      if (k < 0) continue;
      const ViewOfPoint view_a = view(map.keyframes[a], i), view_b = view(map.keyframes[b], k);
      const auto point = confirmed_point(camera_, view_a, view_b, options_.new_points.max_cosine);
      if (!point || !sizes_agree(*point, view_a, view_b)) continue;
      taken_[static_cast<std::size_t>(k)] = 1;
      const std::int64_t id = insert(map, a, i, *point);
      map.observe(id, a, static_cast<std::int32_t>(i));
      map.observe(id, b, k);
    }
  }

  std::int32_t best_on_line(const FrameFeatures& in_a, std::size_t i, const FrameFeatures& in_b,
                            const Eigen::Matrix3d& E) const {
    const Eigen::Vector3d line = E * ray(in_a.keypoints_undistorted[i].pt);
    const double norm = line.head<2>().norm();
    if (!(norm > 0)) return -1;
    std::int32_t best = -1;
    int least = options_.new_points.max_distance + 1;
    for (const std::int32_t k : free_) {
      const cv::KeyPoint& keypoint = in_b.keypoints_undistorted[static_cast<std::size_t>(k)];
      if (taken_[static_cast<std::size_t>(k)] || std::abs(keypoint.octave - in_a.keypoints[i].octave) > 1)
        continue;
      const double off_px = camera_.fx_px * std::abs(line.dot(ray(keypoint.pt))) / norm;
      if (off_px > options_.new_points.line_reach_px * sigma_px(keypoint.octave)) continue;
      const int distance = hamming(in_a.descriptors[i], in_b.descriptors[static_cast<std::size_t>(k)]);
      if (distance >= least) continue;
      least = distance;
      best = k;
    }
    return best;
  }

  /// The octaves of a point go with its distances.
  bool sizes_agree(const Eigen::Vector3d& world_m, const ViewOfPoint& a, const ViewOfPoint& b) const {
    const double distances = (a.T_camera_world * world_m).norm() / (b.T_camera_world * world_m).norm(),
                 sizes = b.sigma_px / a.sigma_px;
    const double limit = kSizeTolerance * options_.extractor.scale_factor;
    return distances < limit * sizes && sizes < limit * distances;
  }

  std::int64_t insert(Map& map, std::int32_t keyframe, std::size_t i, const Eigen::Vector3d& world_m) const {
    const FrameFeatures& features = map.keyframes[keyframe].features;
    MapPoint point;
    point.world_m = world_m;
    point.descriptor = features.descriptors[i];
    point.octave = features.keypoints[i].octave;
    point.distance_m = (map.keyframes[keyframe].T_camera_world * world_m).norm();
    point.born = keyframe;
    map.points.push_back(std::move(point));
    return static_cast<std::int64_t>(map.points.size()) - 1;
  }

  ViewOfPoint view(const Keyframe& keyframe, std::size_t i) const {
    const cv::KeyPoint& keypoint = keyframe.features.keypoints_undistorted[i];
    return {keyframe.T_camera_world, {keypoint.pt.x, keypoint.pt.y}, sigma_px(keypoint.octave)};
  }
  ViewOfPoint view(const Keyframe& keyframe, std::int32_t i) const {
    return view(keyframe, static_cast<std::size_t>(i));
  }
  Eigen::Vector3d ray(cv::Point2f px) const { return camera_.back_project(px.x, px.y, 1); }
  double sigma_px(int octave) const { return std::pow(options_.extractor.scale_factor, octave); }

  static constexpr double kSizeTolerance = 1.5;

  Pinhole camera_;
  OdometryOptions options_;
  std::vector<std::int32_t> free_;
  std::vector<std::uint8_t> taken_;
};

}  // namespace dynfilter::odometry
