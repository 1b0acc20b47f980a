// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/hosts/orb_slam/traits.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <functional>

namespace dynfilter::orb_slam {

/// A host's transform as a Pose: a 4x4 cv::Mat of float or double (version 2), or anything with a 4x4
/// `matrix()` (version 3). Empty, of another size, or not rigid: none.
template <class Transform>
std::optional<Pose> to_pose(const Transform& T_a_b) {
  Eigen::Matrix4d m;
  if constexpr (traits::IsMatrix<Transform>::value) {
    const cv::Mat matrix(T_a_b);
    if (matrix.rows != 4 || matrix.cols != 4 || matrix.channels() != 1) return std::nullopt;
    cv::Mat_<double> as_double;
    matrix.convertTo(as_double, CV_64F);
    for (int row = 0; row < 4; ++row)
      for (int col = 0; col < 4; ++col) m(row, col) = as_double(row, col);
  } else {
    m = T_a_b.matrix().template cast<double>();
  }
  const Pose pose = Pose::from(m.topLeftCorner<3, 3>(), m.topRightCorner<3, 1>());
  if (!is_rigid(pose)) return std::nullopt;
  return pose;
}

/// T_camera_world of a host's frame or keyframe, if it has one.
template <class Frame>
std::optional<Pose> camera_from_world(const Frame& frame) {
  if constexpr (traits::HasMatrixPose<Frame>::value) {
    return to_pose(frame.mTcw);
  } else {
    if (!frame.HasPose()) return std::nullopt;
    return to_pose(frame.GetPose());
  }
}

/// Of a host's map point.
template <class MapPoint>
std::int64_t id_of(const MapPoint& point) {
  return static_cast<std::int64_t>(point.mnId);
}

/// What the host made of a frame that it tracked: its map points, and how many of them are inliers. `ids`
/// holds what the result refers to.
template <class Frame>
HostTracking tracking_of(const Frame& frame, std::vector<std::int64_t>& ids) {
  HostTracking tracking;
  ids.assign(frame.mvKeys.size(), -1);
  if (frame.mvpMapPoints.size() < ids.size() || frame.mvbOutlier.size() < ids.size()) return tracking;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (frame.mvbOutlier[i])
      ++tracking.outliers;
    else if (frame.mvpMapPoints[i] != nullptr)
      ++tracking.inliers, ids[i] = id_of(*frame.mvpMapPoints[i]);
  }
  tracking.keypoints = frame.mvKeys, tracking.map_point_ids = ids;
  return tracking;
}

/// What the host knows of the camera before it tracks a frame.
struct HostPose {
  bool has_prediction = false, has_last = false;
  Pose predicted_T_world_camera;
  std::int64_t last_frame_id = -1;
  Pose last_T_world_camera;  ///< of that frame, as estimated by now
  /// Reads that frame. Only while the host has a map, because its map points die with it.
  std::function<HostTracking(std::vector<std::int64_t>& ids)> tracking;
};

/// The prediction of the host's constant-velocity model. `velocity` is the host's mVelocity (T_current_last),
/// `last` its mLastFrame; version 3 says with its mbVelocity whether there is one. Either may be missing.
template <class Velocity, class Frame>
HostPose predicted_pose(const Velocity& velocity, const Frame& last, bool has_velocity = true) {
  HostPose pose;
  const std::optional<Pose> T_last_world = camera_from_world(last);
  if (!T_last_world) return pose;
  pose.has_last = true;
  pose.last_frame_id = static_cast<std::int64_t>(last.mnId);
  pose.last_T_world_camera = inverse(*T_last_world);
  pose.tracking = [&last](std::vector<std::int64_t>& ids) { return tracking_of(last, ids); };
  if (!has_velocity) return pose;
  if (const std::optional<Pose> T_current_last = to_pose(velocity)) {
    pose.has_prediction = true;
    pose.predicted_T_world_camera = inverse(*T_current_last * *T_last_world);
  }
  return pose;
}

/// In the world [m]. A 3x1 cv::Mat of float (version 2) or an Eigen vector (version 3).
template <class Position>
cv::Point3f to_point(const Position& p) {
  if constexpr (traits::IsMatrix<Position>::value)
    return {p.template at<float>(0), p.template at<float>(1), p.template at<float>(2)};
  else
    return {static_cast<float>(p(0)), static_cast<float>(p(1)), static_cast<float>(p(2))};
}

/// The host's pinhole camera; none when its matrix is not there yet.
template <class Frame>
std::optional<Camera> camera_of(const Frame& frame) {
  cv::Mat_<double> K, distortion;
  if (frame.mK.rows != 3 || frame.mK.cols != 3) return std::nullopt;
  cv::Mat(frame.mK).convertTo(K, CV_64F);
  Camera camera;
  camera.fx_px = K(0, 0), camera.fy_px = K(1, 1), camera.cx_px = K(0, 2), camera.cy_px = K(1, 2);
  if (!camera.valid()) return std::nullopt;
  cv::Mat(frame.mDistCoef).convertTo(distortion, CV_64F);
  const std::size_t n = std::min(distortion.total(), camera.distortion.size());
  for (std::size_t i = 0; i < n; ++i) camera.distortion[i] = distortion(static_cast<int>(i));
  camera.baseline_fx_px_m = frame.mbf > 0 ? static_cast<double>(frame.mbf) : 0;
  return camera;
}

/// Ids and places of map points, -1 where there is none or the host has given it up. Buffers are kept.
class MapPointReader {
 public:
  /// Reads all of them, by the host's own functions.
  template <class MapPoint>
  void read(const std::vector<MapPoint*>& map_points) {
    const std::size_t n = map_points.size();
    ids_.assign(n, -1);
    positions_.assign(n, cv::Point3f());
    any_ = false;
    for (std::size_t i = 0; i < n; ++i) {
      MapPoint* const point = map_points[i];
      if (point == nullptr || point->isBad()) continue;
      ids_[i] = id_of(*point);
      positions_[i] = to_point(point->GetWorldPos());
      any_ = true;
    }
  }
  bool any() const { return any_; }                              ///< whether there is a map point at all
  const std::vector<std::int64_t>& ids() const { return ids_; }  ///< per feature; -1: none
  /// In the world [m]; (0, 0, 0) where there is none.
  const std::vector<cv::Point3f>& positions() const { return positions_; }

 private:
  std::vector<std::int64_t> ids_;
  std::vector<cv::Point3f> positions_;
  bool any_ = false;
};

/// The covisible keyframes of a host, as views on its own arrays. Valid until the next read.
class KeyframeReader {
 public:
  /// The first `at_most` that are usable.
  template <class KeyFrame>
  Span<const KeyframeView> read(const std::vector<KeyFrame*>& keyframes, int at_most) {
    views_.clear();
    points_.resize(keyframes.size());
    for (KeyFrame* const keyframe : keyframes) {
      if (static_cast<int>(views_.size()) >= at_most) break;
      if (keyframe == nullptr || keyframe->isBad()) continue;
      const std::optional<Pose> T_camera_world = to_pose(keyframe->GetPose());
      if (!T_camera_world) continue;
      MapPointReader& points = points_[views_.size()];
      points.read(keyframe->GetMapPointMatches());
      views_.push_back({static_cast<std::int64_t>(keyframe->mnId), inverse(*T_camera_world),
                        Span<const cv::KeyPoint>(keyframe->mvKeysUn), Span<const float>(keyframe->mvDepth),
                        Span<const std::int64_t>(points.ids())});
    }
    return views_;
  }

 private:
  std::vector<KeyframeView> views_;
  std::vector<MapPointReader> points_;
};

/// Fills a FrameView from a host's Frame. Of a fisheye frame only what needs no pinhole model is filled:
/// keypoints, depth per feature, pose and map points, so that boxes and masks judge it and geometry abstains.
class FrameReader {
 public:
  /// `image` and `depth` (metres, or units of `depth_unit_m`) may be empty. Nothing is copied.
  /// `stereo`: the frame's columns in the right image were matched there.
  template <class Frame>
  FrameView read(const Frame& frame, const cv::Mat& image, const cv::Mat& depth, double depth_unit_m,
                 bool stereo) {
    require_frame<Frame>();
    FrameView view;
    const std::size_t n = frame.mvKeys.size();
    view.id = static_cast<std::int64_t>(frame.mnId);
    view.timestamp_s = frame.mTimeStamp;
    view.keypoints = frame.mvKeys;
    if (frame.mvDepth.size() == n) view.depth_m = frame.mvDepth;
    read_map_points(frame, view);
    if (is_fisheye(frame)) return view;
    if (frame.mvKeysUn.size() == n) view.keypoints_undistorted = frame.mvKeysUn;
    if (static_cast<std::size_t>(frame.mDescriptors.rows) == n) view.descriptors = frame.mDescriptors;
    view.grey = image;
    view.depth = depth;
    // Of an RGB-D host these columns are computed from the depth.
    if (stereo && frame.mvuRight.size() == n) view.right_u_px = frame.mvuRight;
    view.depth_unit_m = depth_unit_m;
    view.camera = camera_of(frame);
    if (view.camera) view.camera->width_px = image.cols, view.camera->height_px = image.rows;
    return view;
  }

 private:
  template <class Frame>
  void read_map_points(const Frame& frame, FrameView& view) {
    const std::size_t n = frame.mvKeys.size();
    if (frame.mvpMapPoints.size() < n) return;
    points_.read(frame.mvpMapPoints);
    if (!points_.any()) return;
    view.map_point_ids = Span<const std::int64_t>(points_.ids().data(), n);
    view.map_points_world_m = Span<const cv::Point3f>(points_.positions().data(), n);
  }

  MapPointReader points_;
};

}  // namespace dynfilter::orb_slam
