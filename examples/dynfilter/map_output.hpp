// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/io/image_file.hpp>
#include <dynfilter/io/ply.hpp>
#include <dynfilter/io/tum_sequence.hpp>
#include <dynfilter/mapping/cloud_picture.hpp>
#include <dynfilter/mapping/mapping_thread.hpp>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "odometry/track_result.hpp"
#include "pipeline_judge.hpp"
#include "run_summary.hpp"

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

/// The static map of a sequence, in a thread of its own. What the pipeline rejects is cut out of the depth
/// images; boxes and masks are, where the pipeline has a stage that looks at them.
class MapOutput {
 public:
  /// Throws IoError when `file` cannot be in its folder, ConfigError for parameters.
  MapOutput(std::filesystem::path file, const mapping::MappingParams& params, const Pipeline& pipeline)
      : file_(std::move(file)),
        moving_classes_(params.cut.moving_classes),
        cuts_boxes_(uses_stage(pipeline, "semantic_box")),
        cuts_mask_(uses_stage(pipeline, "semantic_mask")),
        map_(params, kCapacity) {
    const std::filesystem::path folder = std::filesystem::absolute(file_).parent_path();
    if (!std::filesystem::is_directory(folder)) throw IoError(folder.string() + ": no such folder");
    if (std::filesystem::is_directory(file_)) throw IoError(file_.string() + ": is a folder");
  }

  /// `truth`: CV_8UC1, what moves by the renderer's labels, or empty.
  void add(std::int64_t id, const io::RgbdFrame& frame, const Camera& camera, const Pose& T_world_camera,
           bool keyframe, const odometry::SemanticInputs& inputs, const FrameVerdict& verdict,
           const cv::Mat& truth) {
    if (frame.depth.empty()) return;
    if (!first_) first_ = View{camera, frame.depth.size(), T_world_camera};
    mapping::MapFrame view;
    view.id = id;
    view.timestamp_s = frame.timestamp_s;
    view.T_world_camera = T_world_camera;
    view.camera = camera;
    view.depth = frame.depth;
    view.depth_unit_m = frame.depth_unit_m;
    if (frame.colour.size() == frame.depth.size()) view.bgr = frame.colour;
    std::vector<cv::Point2f> moving;
    for (const MarkedFeature& feature : verdict.features)
      if (feature.decision == Vote::Dynamic) moving.push_back(feature.pixel);
    view.moving_px = moving;
    const std::vector<Detection> detections = own_detections(id, inputs);
    view.detections = detections;
    const bool has_mask = inputs.mask && of_this_frame(inputs.mask->frame_id, id);
    if (!truth.empty())
      view.moving_mask = truth;
    else if (cuts_mask_ && has_mask)
      view.moving_mask = inputs.mask->labels;
    keyframe ? map_.add(view) : map_.observe(view);
  }

  void move(std::int64_t id, const Pose& T_world_camera) { map_.move(id, T_world_camera); }

  /// Waits for the map and writes it, and a picture of it from above and from the first camera beside it.
  MapSummary write() {
    const mapping::MapCloud cloud = map_.cloud();
    const mapping::MapState state = map_.state();
    const mapping::MappingThreadStatus status = map_.status();
    io::write_ply(file_, cloud.points_m, cloud.colours, cloud.classes);
    if (first_) write_picture(cloud, state.leaf_m);
    return {file_.string(), cloud.size(),    status.fused,
            status.skipped, status.dropped,  state.voxel_bytes + state.keyframe_bytes,
            state.leaf_m,   status.last_note};
  }

 private:
  static constexpr std::size_t kCapacity = 256;  ///< frames that wait: a sequence is read faster than filmed
  struct View {
    Camera camera;
    cv::Size size;
    Pose T_world_camera;
  };

  static bool of_this_frame(std::int64_t frame_id, std::int64_t id) { return frame_id < 0 || frame_id == id; }

  std::vector<Detection> own_detections(std::int64_t id, const odometry::SemanticInputs& inputs) const {
    std::vector<Detection> own;
    if (!inputs.detections || !of_this_frame(inputs.detections->frame_id, id)) return own;
    for (const Detection& detection : inputs.detections->detections) {
      const bool may_move = std::find(moving_classes_.begin(), moving_classes_.end(), detection.class_name) !=
                            moving_classes_.end();
      if (cuts_boxes_ || !may_move) own.push_back(detection);
    }
    return own;
  }

  void write_picture(const mapping::MapCloud& cloud, double leaf_m) const {
    const View& view = *first_;
    const Pose above = mapping::overview_pose(cloud, view.T_world_camera, view.camera, view.size);
    cv::Mat both;
    cv::hconcat(mapping::render_cloud(cloud, leaf_m, view.camera, view.size, above),
                mapping::render_cloud(cloud, leaf_m, view.camera, view.size, view.T_world_camera), both);
    std::vector<std::uint8_t> bytes;
    cv::imencode(".png", both, bytes);
    std::filesystem::path picture = file_;
    picture.replace_extension(".png");
    io::write_file_atomically(picture, [&](std::ostream& out) {
      out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    });
  }

  std::filesystem::path file_;
  std::vector<std::string> moving_classes_;
  bool cuts_boxes_, cuts_mask_;
  mapping::MappingThread map_;
  std::optional<View> first_;
};

}  // namespace dynfilter::command
