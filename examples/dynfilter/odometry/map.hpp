// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <dynfilter/core/pose.hpp>
#include <vector>

#include "descriptor.hpp"
#include "frame_features.hpp"
#include "numbered.hpp"

namespace dynfilter::odometry {

struct Observation {
  std::int32_t keyframe, feature;
};

struct MapPoint {
  Eigen::Vector3d world_m = Eigen::Vector3d::Zero();
  Descriptor descriptor{};
  int octave = 0;  ///< octave of the first observation
  /// Distance of the first observation; with the octave, it predicts the octave of others.
  double distance_m = 0;
  std::int32_t born = 0;  ///< keyframe that created it
  int visible = 1, found = 1;
  std::vector<Observation> observations;
};

struct Keyframe {
  std::int64_t frame_id = 0;
  Eigen::Isometry3d T_camera_world;
  Pose T_world_camera;  ///< the same pose in the toolkit's type
  FrameFeatures features;

  void set_pose(const Eigen::Isometry3d& T) {
    T_camera_world = T;
    T_world_camera = Pose::from(T.inverse());
  }
};

/// Keyframes and points by index. Indices of removed ones are not reused.
class Map {
 public:
  NewestOf<Keyframe> keyframes;
  SparseVector<MapPoint> points;

  bool alive(std::int64_t point) const { return points.has(point); }
  MapPoint& point(std::int64_t i) { return points[i]; }
  const MapPoint& point(std::int64_t i) const { return points[i]; }

  void observe(std::int64_t i, std::int32_t keyframe, std::int32_t feature) {
    point(i).observations.push_back({keyframe, feature});
    keyframes[keyframe].features.map_point[feature] = i;
  }

  void forget(std::int64_t i, const Observation& seen) {
    auto& list = point(i).observations;
    list.erase(std::remove_if(list.begin(), list.end(),
                              [&](const Observation& o) {
                                return o.keyframe == seen.keyframe && o.feature == seen.feature;
                              }),
               list.end());
    keyframes[seen.keyframe].features.map_point[seen.feature] = -1;
    if (list.empty()) points.remove(i);
  }

  void remove(std::int64_t i) {
    for (const Observation& o : point(i).observations)
      keyframes[o.keyframe].features.map_point[o.feature] = -1;
    points.remove(i);
  }

  /// Points that no other keyframe observes are removed, too.
  void remove_oldest_keyframe() {
    const std::int32_t oldest = keyframes.first();
    const std::vector<std::int64_t> seen = keyframes[oldest].features.map_point;
    for (std::size_t k = 0; k < seen.size(); ++k)
      if (alive(seen[k])) forget(seen[k], {oldest, static_cast<std::int32_t>(k)});
    keyframes.remove_first();
  }

  /// Keyframes that observe the given points, by number of observations, at most `limit`.
  /// Ties prefer the newer keyframe.
  std::vector<std::int32_t> covisible(const std::vector<std::int64_t>& seen, std::size_t limit) const {
    const std::int32_t first = keyframes.first();
    std::vector<std::int32_t> votes(keyframes.count(), 0), order;
    for (const std::int64_t i : seen)
      if (alive(i))
        for (const Observation& o : point(i).observations) ++votes[o.keyframe - first];
    for (std::size_t k = 0; k < votes.size(); ++k)
      if (votes[k] > 0) order.push_back(first + static_cast<std::int32_t>(k));
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
      return votes[a - first] != votes[b - first] ? votes[a - first] > votes[b - first] : a > b;
    });
    if (order.size() > limit) order.resize(limit);
    return order;
  }

  /// The points that these keyframes observe, in ascending order without duplicates.
  std::vector<std::int64_t> points_of(const std::vector<std::int32_t>& frames) const {
    std::vector<std::int64_t> result;
    for (const std::int32_t k : frames)
      for (const std::int64_t i : keyframes[k].features.map_point)
        if (alive(i)) result.push_back(i);
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }
};

}  // namespace dynfilter::odometry
