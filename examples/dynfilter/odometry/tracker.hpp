// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "feature_grid.hpp"
#include "mapper.hpp"
#include "matching.hpp"
#include "pose_refinement.hpp"
#include "recovery.hpp"
#include "sighting.hpp"
#include "track_result.hpp"

namespace dynfilter::odometry {

/// Estimates the pose of a frame from the last frame and the local map.
/// After a loss, it uses keyframes.
class Tracker {
 public:
  Tracker(const Pinhole& camera, const OdometryOptions& options)
      : camera_(camera),
        options_(options),
        refiner_(camera),
        recovery_(camera, options.sensor != Sensor::Mono),
        matcher_(camera, options.extractor.scale_factor, options.extractor.levels) {}

  void set_image(cv::Size size) {
    image_ = size;
    matcher_.set_image(size);
  }
  void index(const FrameFeatures& features) { grid_.build(features.keypoints_undistorted, image_); }

  /// T_camera_world by constant velocity; none after a loss.
  /// It is also a weak prior of the pose.
  std::optional<Eigen::Isometry3d> predict(double timestamp_s) {
    if (!last_tracked_) return std::nullopt;
    if (!velocity_) return last_pose_;
    const double share = std::clamp((timestamp_s - last_timestamp_s_) / last_interval_s_, 0.0, 3.0);
    const Eigen::AngleAxisd turn(velocity_->linear());
    Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
    step.linear() = Eigen::AngleAxisd(turn.angle() * share, turn.axis()).toRotationMatrix();
    step.translation() = velocity_->translation() * share;
    const Eigen::Isometry3d expected = step * last_pose_;
    refiner_.expect(expected, timestamp_s - last_timestamp_s_);
    return expected;
  }
  void forget_motion() { velocity_.reset(); }

  /// Estimates a first pose from the points of the last frame, including those without a map point.
  /// If most matches contradict the pose, the true ones may lie outside of the search window. So wider ones
  /// are tried, too, and the pose with the most inliers is taken.
  bool track_last_frame(const Map& map, const Eigen::Isometry3d& predicted, FrameFeatures& features,
                        Eigen::Isometry3d& pose) {
    collect_last_points(map);
    const double radius_px = options_.match.motion_radius_px;
    const Attempt attempts[] = {
        {predicted, radius_px}, {predicted, 2 * radius_px}, {last_pose_, 4 * radius_px}};
    const Attempt* best = nullptr;
    int most = options_.min_inliers - 1;
    for (const Attempt& attempt : attempts) {
      const int inliers = track_from(attempt, features, pose);
      if (inliers >= options_.min_inliers && 2 * inliers > static_cast<int>(pose_points_.size())) return true;
      if (inliers > most) best = &attempt, most = inliers;
    }
    if (best != nullptr) track_from(*best, features, pose);
    return best != nullptr;
  }

  /// Refines the pose with the points of covisible keyframes. Returns the number of inliers.
  int track_local_map(Mapper& mapper, FrameFeatures& features, Eigen::Isometry3d& pose) {
    Map& map = mapper.map();
    collect_local_points(mapper, features, pose);
    const MatchOptions& m = options_.match;
    matcher_.match(search_, pose, features, grid_, {m.map_radius_px, 1, m.max_distance, m.max_ratio}, found_);
    for (std::size_t i = 0; i < found_.size(); ++i)
      if (found_[i] >= 0) features.map_point[found_[i]] = search_[i].map_point;
    collect_pose_points(map, features);
    const int inliers = refiner_.refine(pose_points_, pose, inlier_);
    for (std::size_t i = 0; i < pose_points_.size(); ++i) {
      if (inlier_[i])
        ++map.point(features.map_point[pose_feature_[i]]).found;
      else
        features.map_point[pose_feature_[i]] = -1;
    }
    return inliers;
  }

  /// Estimates a pose without prediction, from the reference keyframe, then from older ones in turn, two per
  /// frame.
  bool recover(const Map& map, FrameFeatures& features, Eigen::Isometry3d& pose) {
    refiner_.expect_nothing();
    for (const std::int32_t k : {reference_, next_candidate(map), next_candidate(map)}) {
      search_.clear();
      for (const std::int64_t i : map.keyframes[k].features.map_point)
        if (map.alive(i))
          search_.push_back({map.point(i).world_m, map.point(i).descriptor, map.point(i).octave, i});
      std::fill(features.map_point.begin(), features.map_point.end(), -1);
      if (!recovery_.recover(search_, features, kMinRecovered, pose)) continue;
      const Window window{options_.match.motion_radius_px, 2, options_.match.max_distance,
                          options_.match.max_ratio};
      matcher_.match(search_, pose, features, grid_, window, found_);
      if (refine_found(features, pose) < options_.min_inliers) continue;
      reference_ = k;
      return true;
    }
    return false;
  }

  bool needs_keyframe(const Map& map, const FrameFeatures& features, const Eigen::Isometry3d& pose,
                      const TrackResult& result) const {
    const KeyframeOptions& k = options_.keyframe;
    if (result.frame_id - map.keyframes.back().frame_id >= k.max_gap_frames) return true;
    if (result.tracked_points < k.min_tracked_share * keyframe_points_) return true;
    const Eigen::Isometry3d motion = pose * map.keyframes[reference_].T_camera_world.inverse();
    const double turned_deg = Eigen::AngleAxisd(motion.linear()).angle() * 180 / M_PI;
    return turned_deg > k.max_rotation_deg ||
           motion.translation().norm() > k.max_translation_ratio * median_depth(map, features, pose);
  }

  void keyframe_made(const Map& map, std::int32_t index, const Eigen::Isometry3d& before_adjustment) {
    reference_ = index;
    tracked_pose_ = before_adjustment;
    keyframe_points_ = 0;
    for (const std::int64_t i : map.keyframes[index].features.map_point)
      keyframe_points_ += map.alive(i) && (index == 0 || map.point(i).observations.size() > 1);
  }

  /// Stores this frame for the next one. True if the track has just been lost.
  bool frame_done(bool tracked, double timestamp_s, const FrameFeatures& features,
                  const Eigen::Isometry3d& pose) {
    refiner_.expect_nothing();  // if the next pose is given, nothing is predicted
    const bool newly_lost = last_tracked_ && !tracked;
    if (tracked) {
      const double interval_s = timestamp_s - last_timestamp_s_;
      velocity_.reset();
      if (last_tracked_ && interval_s != 0) {
        velocity_ = tracked_pose_.value_or(pose) * last_pose_.inverse();
        last_interval_s_ = interval_s;
      }
      last_pose_ = pose;
      last_features_ = features;
    } else {
      velocity_.reset();
    }
    tracked_pose_.reset();
    last_tracked_ = tracked;
    last_timestamp_s_ = timestamp_s;
    return newly_lost;
  }

  std::int32_t reference_keyframe() const { return reference_; }
  int keyframe_points() const { return keyframe_points_; }

 private:
  static constexpr int kMinRecovered = 12;

  struct Attempt {
    Eigen::Isometry3d from;
    double radius_px;
  };
  /// Returns the number of inliers.
  int track_from(const Attempt& attempt, FrameFeatures& features, Eigen::Isometry3d& pose) {
    const MatchOptions& m = options_.match;
    matcher_.match(search_, attempt.from, features, grid_,
                   {attempt.radius_px, 1, m.max_distance, m.max_ratio}, found_);
    pose = attempt.from;
    return refine_found(features, pose);
  }

  void collect_last_points(const Map& map) {
    search_.clear();
    const Eigen::Isometry3d T_world_camera = last_pose_.inverse();
    for (std::size_t i = 0; i < last_features_.size(); ++i) {
      const std::int64_t id = last_features_.map_point[i];
      const cv::KeyPoint& keypoint = last_features_.keypoints_undistorted[i];
      const float depth_m = last_features_.depth_m[i];
      if (map.alive(id)) {
        search_.push_back({map.point(id).world_m, last_features_.descriptors[i], keypoint.octave, id});
      } else if (depth_m > 0) {
        const Eigen::Vector3d p = camera_.back_project(keypoint.pt.x, keypoint.pt.y, depth_m);
        search_.push_back({T_world_camera * p, last_features_.descriptors[i], keypoint.octave, -1});
      }
    }
  }

  void collect_local_points(Mapper& mapper, const FrameFeatures& features, const Eigen::Isometry3d& pose) {
    Map& map = mapper.map();
    std::vector<std::int32_t> frames =
        map.covisible(features.map_point, static_cast<std::size_t>(options_.local_keyframes));
    if (std::find(frames.begin(), frames.end(), reference_) == frames.end()) frames.push_back(reference_);
    assigned_ = features.map_point;
    std::sort(assigned_.begin(), assigned_.end());
    search_.clear();
    Eigen::Vector3d expected_px;
    for (const std::int64_t i : map.points_of(frames)) {
      MapPoint& point = map.point(i);
      if (!matcher_.visible(point.world_m, pose, expected_px)) continue;
      ++point.visible;
      if (std::binary_search(assigned_.begin(), assigned_.end(), i)) continue;
      search_.push_back({point.world_m, point.descriptor, mapper.expected_octave(point, pose), i});
    }
  }

  int refine_found(FrameFeatures& features, Eigen::Isometry3d& pose) {
    pose_points_.clear();
    pose_feature_.clear();
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (found_[i] < 0) continue;
      pose_points_.push_back({search_[i].world_m, sighting(options_, camera_, features, found_[i])});
      pose_feature_.push_back(static_cast<std::int32_t>(i));
    }
    const int inliers = refiner_.refine(pose_points_, pose, inlier_);
    std::fill(features.map_point.begin(), features.map_point.end(), -1);
    for (std::size_t i = 0; i < pose_points_.size(); ++i)
      if (inlier_[i]) features.map_point[found_[pose_feature_[i]]] = search_[pose_feature_[i]].map_point;
    return inliers;
  }

  void collect_pose_points(const Map& map, const FrameFeatures& features) {
    pose_points_.clear();
    pose_feature_.clear();
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (!map.alive(features.map_point[i])) continue;
      pose_points_.push_back(
          {map.point(features.map_point[i]).world_m, sighting(options_, camera_, features, i)});
      pose_feature_.push_back(static_cast<std::int32_t>(i));
    }
  }

  std::int32_t next_candidate(const Map& map) {
    const bool is_last = candidate_ + 1 >= static_cast<std::int32_t>(map.keyframes.size());
    return candidate_ = std::max(is_last ? 0 : candidate_ + 1, map.keyframes.first());
  }

  /// Of the features; of a mono camera, of their map points.
  static double median_depth(const Map& map, const FrameFeatures& features, const Eigen::Isometry3d& pose) {
    std::vector<float> depths;
    for (const float depth_m : features.depth_m)
      if (depth_m > 0) depths.push_back(depth_m);
    if (depths.empty())
      for (const std::int64_t i : features.map_point)
        if (map.alive(i)) depths.push_back(static_cast<float>((pose * map.point(i).world_m).z()));
    if (depths.empty()) return 1e9;
    std::nth_element(depths.begin(), depths.begin() + depths.size() / 2, depths.end());
    return depths[depths.size() / 2];
  }

  Pinhole camera_;
  OdometryOptions options_;
  PoseRefiner refiner_;
  PoseRecovery recovery_;
  ProjectionMatcher matcher_;
  FeatureGrid grid_;
  cv::Size image_;

  FrameFeatures last_features_;
  Eigen::Isometry3d last_pose_ = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Isometry3d> velocity_, tracked_pose_;
  double last_timestamp_s_ = 0, last_interval_s_ = 1;
  bool last_tracked_ = false;
  std::int32_t reference_ = 0, candidate_ = 0;
  int keyframe_points_ = 0;

  std::vector<SearchPoint> search_;
  std::vector<std::int32_t> found_, pose_feature_;
  std::vector<PosePoint> pose_points_;
  std::vector<std::uint8_t> inlier_;
  std::vector<std::int64_t> assigned_;  ///< map points of the frame, ascending
};

}  // namespace dynfilter::odometry
