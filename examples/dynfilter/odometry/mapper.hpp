// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <vector>

#include "bundle_adjustment.hpp"
#include "map.hpp"
#include "new_points.hpp"
#include "options.hpp"
#include "projection.hpp"
#include "sighting.hpp"
#include "two_view_start.hpp"

namespace dynfilter::odometry {

/// Creates keyframes and map points, and keeps the newest part of the map consistent.
class Mapper {
 public:
  Mapper(const Pinhole& camera, const OdometryOptions& options)
      : camera_(camera), options_(options), new_points_(camera, options), adjuster_(camera, options.bundle) {}

  const Map& map() const { return map_; }
  Map& map() { return map_; }
  void clear() {
    map_ = Map();
    first_young_ = 0;
  }

  /// The octave in which this camera will observe the point.
  int expected_octave(const MapPoint& point, const Eigen::Isometry3d& T_camera_world) const {
    const double distance_m = (T_camera_world * point.world_m).norm();
    const double steps = std::log(point.distance_m / distance_m) / std::log(options_.extractor.scale_factor);
    return std::clamp(point.octave + static_cast<int>(std::lround(steps)), 0, options_.extractor.levels - 1);
  }

  /// Turns a tracked frame into a keyframe and returns its index.
  /// Its map points get an observation. Its other features with depth become points.
  std::int32_t insert(std::int64_t frame_id, FrameFeatures& features,
                      const Eigen::Isometry3d& T_camera_world) {
    const auto index = static_cast<std::int32_t>(map_.keyframes.size());
    Keyframe keyframe;
    keyframe.frame_id = frame_id;
    keyframe.set_pose(T_camera_world);
    keyframe.features = features;
    map_.keyframes.push_back(std::move(keyframe));
    const Eigen::Isometry3d T_world_camera = T_camera_world.inverse();
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (features.map_point[i] < 0 && features.depth_m[i] > 0)
        features.map_point[i] = add_point(features, i, T_world_camera, index);
      if (features.map_point[i] >= 0)
        map_.observe(features.map_point[i], index, static_cast<std::int32_t>(i));
    }
    return index;
  }

  /// Adds points that the newest keyframe and its neighbours see, for features without depth.
  void triangulate() { new_points_.add(map_, static_cast<std::int32_t>(map_.keyframes.size()) - 1); }

  /// The two keyframes and the points of a mono map. Returns the index of the second keyframe.
  /// `features` are those of the second one, from which the judge may have removed some.
  std::int32_t start(const TwoViewStart::Start& start, std::int64_t frame_id, FrameFeatures& features) {
    FrameFeatures reference = start.reference;
    insert(start.reference_id, reference, Eigen::Isometry3d::Identity());
    const std::int32_t index = insert(frame_id, features, start.T_current_reference);
    std::vector<std::int32_t> left(static_cast<std::size_t>(start.extracted), -1);
    for (std::size_t i = 0; i < features.size(); ++i)
      left[static_cast<std::size_t>(features.extracted[i])] = static_cast<std::int32_t>(i);
    for (const TwoViewStart::Point& point : start.points) {
      const std::int32_t i = left[static_cast<std::size_t>(point.current)];
      if (i < 0) continue;
      MapPoint added;
      added.world_m = point.reference_m;
      added.descriptor = features.descriptors[static_cast<std::size_t>(i)];
      added.octave = features.keypoints[static_cast<std::size_t>(i)].octave;
      added.distance_m = (start.T_current_reference * point.reference_m).norm();
      added.born = index;
      map_.points.push_back(std::move(added));
      const auto id = static_cast<std::int64_t>(map_.points.size()) - 1;
      map_.observe(id, 0, point.reference);
      map_.observe(id, index, i);
    }
    features.map_point = map_.keyframes[static_cast<std::size_t>(index)].features.map_point;
    return index;
  }

  /// Removes bad points, then runs bundle adjustment around the newest keyframe.
  void refine(bool adjust = true) {
    const auto newest = static_cast<std::int32_t>(map_.keyframes.size()) - 1;
    if (newest < 1) return;
    cull(newest);
    if (!adjust) return;
    std::vector<std::int32_t> window = map_.covisible(map_.keyframes[newest].features.map_point,
                                                      static_cast<std::size_t>(options_.bundle.window));
    adjuster_.adjust(map_, window, [&](const Observation& o) {
      return sighting(options_, camera_, map_.keyframes[o.keyframe].features, o.feature);
    });
  }

 private:
  std::int64_t add_point(const FrameFeatures& features, std::size_t i,
                         const Eigen::Isometry3d& T_world_camera, std::int32_t keyframe) {
    const cv::KeyPoint& keypoint = features.keypoints_undistorted[i];
    const Eigen::Vector3d p = camera_.back_project(keypoint.pt.x, keypoint.pt.y, features.depth_m[i]);
    MapPoint point;
    point.world_m = T_world_camera * p;
    point.descriptor = features.descriptors[i];
    point.octave = keypoint.octave;
    point.distance_m = p.norm();
    point.born = keyframe;
    map_.points.push_back(std::move(point));
    return static_cast<std::int64_t>(map_.points.size()) - 1;
  }

  /// Removes young points that are not found where they should be visible, or that no second keyframe
  /// observes.
  void cull(std::int32_t newest) {
    constexpr int kYoung = 3, kSettled = 2;
    constexpr double kMinFound = 0.25;
    while (first_young_ < static_cast<std::int64_t>(map_.points.size()) &&
           (!map_.alive(first_young_) || map_.point(first_young_).born + kYoung < newest))
      ++first_young_;
    for (std::int64_t i = first_young_; i < static_cast<std::int64_t>(map_.points.size()); ++i) {
      if (!map_.alive(i)) continue;
      const MapPoint& point = map_.point(i);
      if (point.born == newest) continue;
      const bool rare = point.found < kMinFound * point.visible;
      const bool single = newest - point.born >= kSettled && point.observations.size() < 2;
      if (rare || single) map_.remove(i);
    }
  }

  Pinhole camera_;
  OdometryOptions options_;
  Map map_;
  NewPoints new_points_;
  BundleAdjuster adjuster_;
  std::int64_t first_young_ = 0;
};

}  // namespace dynfilter::odometry
