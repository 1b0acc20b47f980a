// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <functional>
#include <string>
#include <vector>

#include "support/layered_scene.hpp"

namespace dynfilter_test {

enum class SceneSensor { RgbD, Stereo, Mono };

/// A host that plays a scene and hands in all that hosts have: images, poses, boxes with masks, labels,
/// matches, map points and keyframes.
class RecordedHost {
 public:
  static constexpr int kMinFeatures = 20;

  explicit RecordedHost(SceneSensor sensor) : sensor_(sensor) {
    for (int k = 0; k < LayeredScene::kFrames; ++k) {
      frames_.push_back(LayeredScene().frame(k));
      frames_.back().boxes[0].mask = frames_.back().labels.clone();
    }
    const LayeredFrame& first = frames_[0];
    keyframes_ = {{0, first.T_world_camera, first.keypoints, depth_of(first), first.map_point_ids}};
  }

  dynfilter::FrameView view(std::size_t k, dynfilter::CallPoint point) const {
    using dynfilter::CallPoint;
    const LayeredFrame& f = frames_[k];
    dynfilter::FrameView view;
    view.id = f.id, view.timestamp_s = f.timestamp_s;
    view.keypoints = f.keypoints, view.descriptors = f.descriptors;
    view.grey = f.grey;
    view.camera = LayeredScene().camera();
    view.depth_m = depth_of(f);
    if (sensor_ == SceneSensor::RgbD) view.depth = f.depth;
    if (sensor_ == SceneSensor::Stereo) view.right_u_px = f.right_u_px;
    if (sensor_ == SceneSensor::Mono) view.camera->baseline_fx_px_m = 0;
    view.detections = dynfilter::DetectionInput{k % 2 == 0 ? -1 : f.id - 1, boxes_of(k)};
    view.mask = dynfilter::MaskInput{-1, f.labels};
    if (k % 3 == 2) view.matches = dynfilter::HostMatches{f.id - 1, f.reference_index};
    view.T_world_camera = f.T_world_camera;
    view.motion_prior =
        dynfilter::MotionPrior::turn(Eigen::Matrix3d::Identity(), 1e-6 * Eigen::Matrix3d::Identity());
    view.pose_provenance = point == CallPoint::BeforePose ? dynfilter::PoseProvenance::Predicted
                                                          : dynfilter::PoseProvenance::Estimated;
    if (point == CallPoint::BeforePose) return view;
    view.map_point_ids = f.map_point_ids, view.map_points_world_m = f.map_points_world_m;
    if (point == CallPoint::AtKeyframe) view.covisible_keyframes = keyframes_;
    return view;
  }

  /// What it says of its own tracking.
  dynfilter::HostTracking tracking(std::size_t k) const {
    return {frames_[k].keypoints, frames_[k].map_point_ids, 40 + k, 2};
  }

  /// Plays all frames. `use` gets each verdict. Frame 5 follows a reset and frame 3 a loss. Each pose is
  /// refined later.
  void play(dynfilter::Pipeline& pipeline, const std::function<void(const dynfilter::Verdict&)>& use) const {
    using dynfilter::CallPoint;
    for (std::size_t k = 0; k < frames_.size(); ++k) {
      if (k == 5) pipeline.reset();
      if (k == 3) pipeline.lost();
      use(pipeline.before_pose(view(k, CallPoint::BeforePose), {kMinFeatures}));
      use(pipeline.after_pose(view(k, CallPoint::AfterPose)));
      if (k % 3 == 0) use(pipeline.at_keyframe(view(k, CallPoint::AtKeyframe)));
      if (k > 0)
        pipeline.update_pose(frames_[k - 1].id, frames_[k - 1].T_world_camera,
                             dynfilter::PoseProvenance::Refined, tracking(k - 1));
    }
  }

 private:
  dynfilter::Span<const float> depth_of(const LayeredFrame& f) const {
    return sensor_ == SceneSensor::RgbD ? dynfilter::Span<const float>(f.depth_m)
                                        : dynfilter::Span<const float>();
  }
  /// Boxes of odd frames are those of the last one, late.
  const std::vector<dynfilter::Detection>& boxes_of(std::size_t k) const {
    return frames_[k % 2 == 0 ? k : k - 1].boxes;
  }

  SceneSensor sensor_;
  std::vector<LayeredFrame> frames_;
  std::vector<dynfilter::KeyframeView> keyframes_;
};

}  // namespace dynfilter_test
