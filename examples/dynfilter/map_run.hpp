// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/io/tum_sequence.hpp>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "map_judge.hpp"
#include "map_keyframes.hpp"
#include "map_output.hpp"
#include "odometry/odometry.hpp"
#include "pipeline_judge.hpp"
#include "sequence_run.hpp"

namespace dynfilter::command {

/// Does any stage of the pipeline have this name?
inline bool uses_stage(const Pipeline& pipeline, const std::string& name) {
  bool found = false;
  for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
    if (const Stage* root = pipeline.stages(point))
      root->for_each([&](const Stage& stage, int) { found = found || stage.name() == name; });
  }
  return found;
}

inline mapping::MappingParams map_params(const RunOptions& options) {
  mapping::MappingParams params;
  if (!(options.map_leaf_m >= 0.001 && options.map_leaf_m <= params.max_depth_m))
    throw ConfigError("",
                      fmt::format("--map-leaf-m {:g}: expected 0.001 to {:g} m; farther depths are not used",
                                  options.map_leaf_m, params.max_depth_m));
  params.leaf_m = options.map_leaf_m;
  return params;
}

/// What of a tracked frame a keyframe selector wants to know: the map points that the odometry found in it,
/// but for those that only one keyframe has seen, as ORB-SLAM counts them.
inline FrameSummary frame_summary(const odometry::Odometry& odometry, const odometry::TrackResult& result,
                                  cv::Size image_px) {
  FrameSummary summary;
  summary.id = result.frame_id;
  summary.timestamp_s = result.timestamp_s;
  summary.T_world_camera = *result.T_world_camera;
  summary.image_px = image_px;
  summary.dynamic_features = result.rejected;
  const odometry::Map& map = odometry.map();
  const odometry::FrameFeatures& features = odometry.features();
  const bool first = map.keyframes.size() < 2;
  for (std::size_t i = 0; i < features.size(); ++i) {
    summary.pixels.push_back(features.keypoints[i].pt);
    const std::int64_t point = features.map_point[i];
    if (map.alive(point) && (first || map.point(point).observations.size() > 1))
      summary.points.push_back(point);
  }
  return summary;
}

/// The map of a sequence that is played. What the pipeline rejects is cut out of the depth images; boxes and
/// masks are, where the pipeline has a stage that looks at them.
class MapRun {
 public:
  /// `sequence` must outlive this. Throws Error for options that cannot be used.
  MapRun(const RunOptions& options, const Pipeline& pipeline, const io::TumSequence& sequence)
      : sequence_(&sequence),
        params_(map_params(options)),
        cuts_boxes_(uses_stage(pipeline, "semantic_box")),
        cuts_mask_(uses_stage(pipeline, "semantic_mask")),
        keyframes_(options.keyframes),
        output_(options.map, params_) {
    if (options.truth) judge_.emplace(sequence, params_);
  }

  /// A frame as played, whose index in the sequence is `index`. `truth`: CV_8UC1, what moves by the
  /// renderer's labels, or empty.
  void add(std::size_t index, const io::RgbdFrame& frame, const odometry::TrackResult& result,
           const odometry::Odometry& odometry, const odometry::SemanticInputs& inputs,
           const FrameVerdict& verdict, const cv::Mat& truth) {
    if (frame.depth.empty()) return;
    if (judge_) judge_->see(index, frame);
    if (!result.T_world_camera) return;
    ++frames_offered_;
    keyframes_.add(input_of(index, frame, result, inputs, verdict, truth),
                   frame_summary(odometry, result, frame.grey.size()), result.keyframe,
                   [this](const MapInput& decided) { take(decided); });
  }

  /// With `estimate`, the poses as they are known in the end, by the frames' own stamps.
  MapSummary finish(const io::Trajectory& estimate, std::vector<std::string>& notes) {
    keyframes_.flush([this](const MapInput& decided) { take(decided); });
    std::map<double, Pose> poses;
    for (const io::StampedPose& pose : estimate) poses.emplace(pose.timestamp_s, pose.T_world_camera);
    for (const Key& key : keys_) {
      const auto at = poses.find(key.timestamp_s);
      if (at != poses.end() && !same(at->second, key.T_world_camera)) output_.move(key.id, at->second);
    }
    const mapping::MapCloud cloud = output_.cloud();
    MapSummary summary = output_.write(cloud);
    summary.keyframes_by = keyframes_.rule();
    summary.frames_offered = frames_offered_;
    if (judge_) summary.truth = judge_->judge(cloud, estimate);
    describe(cloud, notes);
    return summary;
  }

 private:
  struct Key {
    std::int64_t id;
    double timestamp_s;
    Pose T_world_camera;
  };

  static bool same(const Pose& a, const Pose& b) {
    return a.rotation == b.rotation && a.translation_m == b.translation_m;
  }
  static bool of_this_frame(std::int64_t frame_id, std::int64_t id) { return frame_id < 0 || frame_id == id; }

  MapInput input_of(std::size_t index, const io::RgbdFrame& frame, const odometry::TrackResult& result,
                    const odometry::SemanticInputs& inputs, const FrameVerdict& verdict,
                    const cv::Mat& truth) const {
    MapInput input;
    input.index = index;
    mapping::MapFrame& f = input.frame;
    f.id = result.frame_id;
    f.timestamp_s = frame.timestamp_s;
    f.T_world_camera = *result.T_world_camera;
    f.camera = sequence_->camera();
    f.depth = frame.depth;
    f.depth_unit_m = frame.depth_unit_m;
    if (frame.colour.size() == frame.depth.size()) f.bgr = frame.colour;
    for (const MarkedFeature& feature : verdict.features)
      if (feature.decision == Vote::Dynamic) input.moving_px.push_back(feature.pixel);
    input.detections = own_detections(f.id, inputs);
    const bool has_mask = inputs.mask && of_this_frame(inputs.mask->frame_id, f.id);
    if (!truth.empty())
      f.moving_mask = truth.clone();
    else if (cuts_mask_ && has_mask)
      f.moving_mask = inputs.mask->labels.clone();
    return input;
  }

  std::vector<Detection> own_detections(std::int64_t id, const odometry::SemanticInputs& inputs) const {
    std::vector<Detection> own;
    if (!inputs.detections || !of_this_frame(inputs.detections->frame_id, id)) return own;
    const std::vector<std::string>& moving = params_.cut.moving_classes;
    for (const Detection& detection : inputs.detections->detections) {
      const bool may_move = std::find(moving.begin(), moving.end(), detection.class_name) != moving.end();
      if (!cuts_boxes_ && may_move) continue;
      own.push_back(detection);
      own.back().mask = detection.mask.clone();
    }
    return own;
  }

  void take(const MapInput& decided) {
    output_.add(decided);
    if (!decided.keyframe) return;
    keys_.push_back({decided.frame.id, sequence_->timestamp_s(decided.index), decided.frame.T_world_camera});
    if (judge_) judge_->add_keyframe(decided);
  }

  void describe(const mapping::MapCloud& cloud, std::vector<std::string>& notes) const {
    if (cloud.size() == 0) {
      notes.emplace_back("the map is empty: not written");
      return;
    }
    cv::Point3f low = cloud.points_m[0], high = low;
    for (const cv::Point3f& p : cloud.points_m) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const double size_m = static_cast<double>(std::max({high.x - low.x, high.y - low.y, high.z - low.z}));
    if (size_m < 2 * params_.leaf_m)
      notes.push_back(
          fmt::format("a voxel of {:g} m is about as large as all that was seen", params_.leaf_m));
  }

  const io::TumSequence* sequence_;
  mapping::MappingParams params_;
  bool cuts_boxes_, cuts_mask_;
  MapKeyframes keyframes_;
  MapOutput output_;
  std::optional<MapJudge> judge_;
  std::vector<Key> keys_;  ///< at the poses that they were added with
  std::size_t frames_offered_ = 0;
};

}  // namespace dynfilter::command
