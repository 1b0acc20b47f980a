// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/keyframe/frame_summary.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/pipeline/pipeline.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/yaml.hpp>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "full_cloud.hpp"
#include "io/sequence.hpp"
#include "io/trajectory.hpp"
#include "map_judge.hpp"
#include "map_keyframes.hpp"
#include "map_output.hpp"
#include "odometry/odometry.hpp"
#include "running/command_registry.hpp"
#include "running/pipeline_judge.hpp"
#include "running/sequence_run.hpp"
#include "text/option_hint.hpp"

namespace dynfilter::command {

inline bool has_stages(const Pipeline& pipeline) {
  return pipeline.stages(CallPoint::BeforePose) || pipeline.stages(CallPoint::AfterPose) ||
         pipeline.stages(CallPoint::AtKeyframe);
}

/// Throws ConfigError for invalid parameters.
inline mapping::MappingParams map_params(const RunOptions& options) {
  mapping::MappingParams params;
  if (!options.map_config.empty()) {
    const YamlDocument document =
        read_for("--map-config", [&] { return YamlDocument::from_file(options.map_config); });
    try {
      const auto node = document.root().find("mapping");
      if (!node) throw ConfigError("", "expected the key `mapping`");
      params = read_parameters<mapping::MappingParams>(*node);
      mapping::check_mapping(params);
    } catch (const ConfigError& error) {
      throw ConfigError("--map-config " + options.map_config, error.what());
    }
  }
  const double leaf_m = options.map_leaf_m.value_or(params.leaf_m);
  if (!(leaf_m >= 0.001 && leaf_m <= params.max_depth_m))
    throw ConfigError(
        "", fmt::format("--map-leaf-m {:g}: expected 0.001 to {:g} m; farther depths are not used", leaf_m,
                        params.max_depth_m));
  params.leaf_m = leaf_m;
  return params;
}

/// Reliable points of the odometry's map that are visible from this camera.
/// Reliable means observed by two keyframes or more.
/// A point is visible if it is in the image and not occluded in the depth image.
/// Unlike matches, this set changes little from frame to frame.
inline std::vector<std::int64_t> points_in_view(const odometry::Map& map, const Camera& camera,
                                                const io::SequenceFrame& frame, const Pose& T_world_camera) {
  const Eigen::Isometry3d T = T_world_camera.isometry().inverse();
  const std::size_t settled = map.keyframes.size() < 2 ? 1 : 2;
  std::vector<std::int64_t> seen;
  for (std::int64_t i = map.points.first(); i < static_cast<std::int64_t>(map.points.size()); ++i) {
    if (!map.alive(i) || map.point(i).observations.size() < settled) continue;
    const odometry::MapPoint& point = map.point(i);
    const Eigen::Vector3d p = T * point.world_m;
    if (!(p.z() > 0.1)) continue;
    const double u = camera.fx_px * p.x() / p.z() + camera.cx_px,
                 v = camera.fy_px * p.y() / p.z() + camera.cy_px;
    if (!(u >= 0 && v >= 0 && u < frame.depth.cols - 1 && v < frame.depth.rows - 1)) continue;
    const int x = cvRound(u), y = cvRound(v);
    const double measured_m = frame.depth_unit_m * (frame.depth.type() == CV_16UC1
                                                        ? frame.depth.at<std::uint16_t>(y, x)
                                                        : static_cast<double>(frame.depth.at<float>(y, x)));
    if (measured_m > 0 && measured_m < 0.9 * p.z()) continue;
    seen.push_back(i);
  }
  return seen;
}

/// Converts a tracked frame for a keyframe selector.
inline FrameSummary frame_summary(const odometry::Odometry& odometry, const odometry::TrackResult& result,
                                  const Camera& camera, const io::SequenceFrame& frame) {
  FrameSummary summary;
  summary.id = result.frame_id;
  summary.timestamp_s = result.timestamp_s;
  summary.T_world_camera = *result.T_world_camera;
  summary.image_px = frame.grey.size();
  summary.dynamic_features = result.rejected;
  for (const cv::KeyPoint& keypoint : odometry.features().keypoints) summary.pixels.push_back(keypoint.pt);
  summary.points = points_in_view(odometry.map(), camera, frame, summary.T_world_camera);
  return summary;
}

/// The map of a sequence during a run.
/// Removes from the depth images what the pipeline rejects.
/// Removes boxes and masks if the pipeline has a stage that uses them.
class MapRun {
 public:
  /// `sequence` must outlive this object. Throws Error for unusable options.
  MapRun(const RunOptions& options, const Pipeline& pipeline, const io::Sequence& sequence)
      : sequence_(&sequence),
        params_(map_params(options)),
        cuts_boxes_(uses_stage(pipeline, "semantic_box")),
        cuts_mask_(uses_stage(pipeline, "semantic_mask")),
        judges_(has_stages(pipeline)),
        keyframes_(options.keyframes),
        output_(options.map, params_, "Map of " + sequence.name() + "   pipeline " + pipeline.name()) {
    if (options.truth) judge_.emplace(sequence, params_);
    if (!options.map_full.empty()) full_.emplace(options.map_full, params_);
  }

  /// Adds a frame with its `index` in the sequence.
  /// `truth`: CV_8UC1, pixels that move according to the renderer's labels, or empty.
  void add(std::size_t index, const io::SequenceFrame& frame, const odometry::TrackResult& result,
           const odometry::Odometry& odometry, const odometry::SemanticInputs& inputs,
           const FrameVerdict& verdict, const cv::Mat& truth) {
    if (frame.depth.empty()) return;
    if (judge_) judge_->see(index, frame);
    if (!result.T_world_camera) return;
    ++frames_offered_;
    if (knows_nothing(verdict)) {
      ++held_back_;
      return;
    }
    keyframes_.add(input_of(index, frame, result, inputs, verdict, truth),
                   frame_summary(odometry, result, sequence_->camera(), frame), result.keyframe,
                   [this](const MapInput& decided) { take(decided); });
  }

  /// `estimate`: final poses with the frames' own timestamps, if given.
  MapSummary finish(const io::Trajectory& estimate, std::vector<std::string>& notes) {
    keyframes_.flush([this](const MapInput& decided) { take(decided); });
    std::map<double, Pose> poses;
    for (const io::StampedPose& pose : estimate) poses.emplace(pose.timestamp_s, pose.T_world_camera);
    for (const Key& key : keys_) {
      const auto at = poses.find(key.timestamp_s);
      if (at == poses.end() || same(at->second, key.T_world_camera)) continue;
      output_.move(key.id, at->second);
      if (full_) full_->move(key.id, at->second);
    }
    cloud_ = output_.cloud();
    MapSummary summary = output_.write(cloud_);
    if (full_) summary.full = full_->write();
    summary.keyframes_by = keyframes_.rule();
    summary.frames_offered = frames_offered_;
    if (held_back_ > 0)
      notes.push_back(
          fmt::format("not in the map: the first {}, about which the pipeline could not say anything yet",
                      held_back_ == 1 ? "frame" : fmt::format("{} frames", held_back_)));
    if (judge_) summary.truth = judge_->judge(cloud_, output_.sources(), estimate);
    describe(cloud_, notes);
    return summary;
  }

  /// After finish().
  const mapping::MapCloud& cloud() const { return cloud_; }

 private:
  static constexpr std::size_t kMostHeldBack = 5;
  struct Key {
    std::int64_t id;
    double timestamp_s;
    Pose T_world_camera;
  };

  // A pipeline that compares frames cannot judge the first ones.
  // Moving objects in them would remain in the map.
  bool knows_nothing(const FrameVerdict& verdict) {
    settled_ = settled_ || !judges_ || frames_offered_ > kMostHeldBack ||
               verdict.count(Vote::Unknown) < verdict.features.size();
    return !settled_;
  }

  static bool same(const Pose& a, const Pose& b) {
    return a.rotation == b.rotation && a.translation_m == b.translation_m;
  }
  static bool of_this_frame(std::int64_t frame_id, std::int64_t id) { return frame_id < 0 || frame_id == id; }

  MapInput input_of(std::size_t index, const io::SequenceFrame& frame, const odometry::TrackResult& result,
                    const odometry::SemanticInputs& inputs, const FrameVerdict& verdict,
                    const cv::Mat& truth) const {
    MapInput input;
    input.index = index;
    mapping::MapFrame& f = input.frame;
    f.id = result.frame_id;
    f.timestamp_s = sequence_->timestamp_s(index);
    f.T_world_camera = *result.T_world_camera;
    f.camera = sequence_->camera();
    f.depth = frame.depth;
    f.depth_unit_m = frame.depth_unit_m;
    if (frame.colour.size() == frame.depth.size()) f.bgr = frame.colour;
    for (const MarkedFeature& feature : verdict.features) {
      if (feature.decision == Vote::Dynamic) input.moving_px.push_back(feature.pixel);
      if (feature.decision == Vote::Static) input.still_px.push_back(feature.pixel);
    }
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
    if (full_) full_->add(decided);
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

  const io::Sequence* sequence_;
  mapping::MappingParams params_;
  bool cuts_boxes_, cuts_mask_, judges_, settled_ = false;
  MapKeyframes keyframes_;
  MapOutput output_;
  mapping::MapCloud cloud_;
  std::optional<FullCloud> full_;
  std::optional<MapJudge> judge_;
  std::vector<Key> keys_;  ///< with the poses at which they were added
  std::size_t frames_offered_ = 0, held_back_ = 0;
};

}  // namespace dynfilter::command
