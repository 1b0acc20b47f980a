// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <optional>
#include <vector>

#include "feature_judge.hpp"
#include "frame_features.hpp"
#include "io/sequence.hpp"
#include "map.hpp"
#include "options.hpp"
#include "sensor.hpp"
#include "track_result.hpp"

namespace dynfilter::odometry {

/// Connects the odometry with the toolkit.
/// It fills the frame view, calls the judge and removes rejected features.
/// It also keeps the rejections for the caller.
class JudgeGate {
 public:
  JudgeGate(const OdometryOptions& options, FeatureJudge* judge)
      : sensor_(options.sensor), weighs_(options.weights), judge_(judge) {}

  void begin(std::int64_t frame_id, const io::SequenceFrame& frame, const Camera& camera,
             const SemanticInputs& inputs, std::size_t features) {
    view_ = FrameView{};
    view_.id = frame_id;
    view_.timestamp_s = frame.timestamp_s;
    view_.grey = frame.grey;
    if (sensor_ == Sensor::Rgbd) {
      view_.depth = frame.depth, view_.depth_handed_over = true;  // each frame has an image of its own
      view_.depth_unit_m = frame.depth_unit_m;
    }
    if (sensor_ == Sensor::Stereo) view_.right_grey = frame.right;
    view_.camera = camera;
    if (sensor_ != Sensor::Stereo) view_.camera->baseline_fx_px_m = 0;
    view_.detections = inputs.detections;
    view_.mask = inputs.mask;
    view_.motion_prior = inputs.motion_prior;
    rejected_at_.assign(features, RejectedAt::Nowhere);
  }

  void before_pose(FrameFeatures& features, const std::optional<Eigen::Isometry3d>& T_camera_world) {
    extracted_ = features.keypoints;
    if (!judge_) return;
    show(features);
    if (T_camera_world) show_pose(*T_camera_world, PoseProvenance::Predicted);
    apply(judge_->before_pose(view_), RejectedAt::BeforePose, features);
  }

  void after_pose(FrameFeatures& features, const Eigen::Isometry3d& T_camera_world, const Map& map) {
    if (!judge_) return;
    show(features);
    show_pose(T_camera_world, PoseProvenance::Estimated);
    show_map(features, map);
    apply(judge_->after_pose(view_), RejectedAt::AfterPose, features);
  }

  void at_keyframe(FrameFeatures& features, const Eigen::Isometry3d& T_camera_world, const Map& map) {
    if (!judge_) return;
    show(features);
    show_pose(T_camera_world, PoseProvenance::Refined);
    show_map(features, map);
    show_keyframes(features, map);
    apply(judge_->at_keyframe(view_), RejectedAt::AtKeyframe, features);
  }

  bool wait_for_keyframe() const { return judge_ && judge_->wait_for_keyframe(); }

  void done(const Eigen::Isometry3d& T_camera_world) {
    if (judge_) judge_->pose_refined(view_.id, Pose::from(T_camera_world.inverse()));
  }

  void lost() {
    if (judge_) judge_->lost();
  }
  void reset() {
    if (judge_) judge_->reset();
  }

  const std::vector<cv::KeyPoint>& extracted() const { return extracted_; }
  const std::vector<RejectedAt>& rejected_at() const { return rejected_at_; }
  int rejected() const {
    return static_cast<int>(rejected_at_.size()) -
           static_cast<int>(std::count(rejected_at_.begin(), rejected_at_.end(), RejectedAt::Nowhere));
  }

 private:
  void show(FrameFeatures& features) {
    view_.keypoints = features.keypoints;
    view_.keypoints_undistorted = features.keypoints_undistorted;
    view_.descriptors = as_matrix(features.descriptors);
    if (sensor_ != Sensor::Mono) view_.depth_m = features.depth_m;
    view_.right_u_px = features.right_u_px;
  }

  void show_pose(const Eigen::Isometry3d& T_camera_world, PoseProvenance provenance) {
    view_.T_world_camera = Pose::from(T_camera_world.inverse());
    view_.pose_provenance = provenance;
  }

  void show_map(const FrameFeatures& features, const Map& map) {
    point_world_m_.assign(features.size(), cv::Point3f());
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (!map.alive(features.map_point[i])) continue;
      const Eigen::Vector3f p = map.point(features.map_point[i]).world_m.cast<float>();
      point_world_m_[i] = {p.x(), p.y(), p.z()};
    }
    view_.map_point_ids = features.map_point;
    view_.map_points_world_m = point_world_m_;
  }

  void show_keyframes(const FrameFeatures& features, const Map& map) {
    constexpr std::size_t kShown = 5;
    keyframes_.clear();
    for (const std::int32_t k : map.covisible(features.map_point, kShown)) {
      const Keyframe& keyframe = map.keyframes[k];
      keyframes_.push_back(
          {keyframe.frame_id, keyframe.T_world_camera, keyframe.features.keypoints_undistorted,
           sensor_ == Sensor::Mono ? Span<const float>() : Span<const float>(keyframe.features.depth_m),
           keyframe.features.map_point});
    }
    view_.covisible_keyframes = keyframes_;
  }

  void apply(FeatureJudge::Flags flags, RejectedAt where, FrameFeatures& features) {
    if (flags.size() != features.size()) return;
    for (std::size_t i = 0; i < flags.size(); ++i)
      if (flags[i]) rejected_at_[features.extracted[i]] = where;
    const Span<const MatchSpread> spread = judge_->spread();
    if (weighs_ && spread.size() == features.size()) features.spread.assign(spread.begin(), spread.end());
    features.compact(flags);
  }

  Sensor sensor_;
  bool weighs_;
  FeatureJudge* judge_;
  FrameView view_;
  std::vector<cv::KeyPoint> extracted_;
  std::vector<RejectedAt> rejected_at_;
  std::vector<cv::Point3f> point_world_m_;
  std::vector<KeyframeView> keyframes_;
};

}  // namespace dynfilter::odometry
