// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "render/sequence_renderer.hpp"

namespace steady {

enum class Camera { Rgbd, Stereo, Mono };

inline const char* to_string(Camera camera) {
  return camera == Camera::Rgbd ? "rgbd" : camera == Camera::Stereo ? "stereo" : "mono";
}

/// Rendered frames with all that a host can give, played to and fro without end.
/// view() allocates nothing.
class Recording {
 public:
  static constexpr double kRate_hz = 30;

  Recording(Camera camera, const std::string& scene, int frames) {
    dynfilter::render::SequenceOptions options;
    options.scene = scene;
    options.frames = frames;
    options.rate_hz = kRate_hz;
    dynfilter::render::SequenceRenderer renderer(options);
    camera_ = renderer.calibration();
    if (camera == Camera::Stereo) camera_.baseline_fx_px_m = kBaseline_m * camera_.fx_px;
    for (int k = 0; k < frames; ++k) add(camera, renderer.frame(k), k);
  }

  /// The frame of call `n`: 0 1 ... N-1 N-2 ... 0 1 ..., with ids and stamps that increase.
  dynfilter::FrameView view(std::size_t n) const {
    const std::size_t phase = n % period(), last = frames_.size() - 1;
    const Frame& frame = frames_[phase <= last ? phase : period() - phase];
    dynfilter::FrameView view;
    view.id = static_cast<std::int64_t>(n);
    view.timestamp_s = static_cast<double>(n) / kRate_hz;
    view.keypoints = frame.keypoints;
    view.descriptors = frame.descriptors;
    view.depth_m = frame.depth_m;
    view.right_u_px = frame.right_u_px;
    view.grey = frame.grey;
    view.depth = frame.depth;
    view.depth_unit_m = 1.0 / dynfilter::render::kDepthUnitsPerM;
    view.camera = camera_;
    view.T_world_camera = frame.T_world_camera;
    view.pose_provenance = dynfilter::PoseProvenance::Estimated;
    view.map_point_ids = frame.map_point_ids;
    view.map_points_world_m = frame.map_points_world_m;
    view.detections.emplace();
    view.detections->frame_id = view.id;
    view.detections->detections = frame.detections;
    view.mask.emplace();
    view.mask->frame_id = view.id;
    view.mask->labels = frame.labels;
    return view;
  }
  /// Frames until all repeats.
  std::size_t period() const { return 2 * (frames_.size() - 1); }

 private:
  static constexpr double kBaseline_m = 0.1;
  static constexpr int kFeatures = 800;

  struct Frame {
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors, grey, depth, labels;
    std::vector<float> depth_m, right_u_px;
    std::vector<std::int64_t> map_point_ids;
    std::vector<cv::Point3f> map_points_world_m;
    std::vector<dynfilter::Detection> detections;
    dynfilter::Pose T_world_camera;
  };

  void add(Camera camera, const dynfilter::render::RenderedFrame& rendered, int index) {
    Frame frame;
    frame.T_world_camera = rendered.T_world_camera;
    cv::cvtColor(rendered.colour, frame.grey, cv::COLOR_BGR2GRAY);
    cv::ORB::create(kFeatures)->detectAndCompute(frame.grey, cv::noArray(), frame.keypoints,
                                                 frame.descriptors);
    frame.labels = rendered.truth.person.clone();
    if (rendered.detections) frame.detections = *rendered.detections;
    if (camera == Camera::Rgbd) frame.depth = rendered.depth.clone();
    for (std::size_t i = 0; i < frame.keypoints.size(); ++i) {
      const cv::Point2f px = frame.keypoints[i].pt;
      const cv::Point at(cvRound(px.x), cvRound(px.y));
      const float depth_m = rendered.true_depth_m.at<float>(at);
      if (camera == Camera::Rgbd) frame.depth_m.push_back(depth_m);
      if (camera == Camera::Stereo)
        frame.right_u_px.push_back(px.x - static_cast<float>(camera_.baseline_fx_px_m) / depth_m);
      frame.map_point_ids.push_back(index % 2 == 0 ? static_cast<std::int64_t>(i) : -1);
      frame.map_points_world_m.emplace_back(0.0F, 0.0F, depth_m);
    }
    frames_.push_back(std::move(frame));
  }

  dynfilter::Camera camera_;
  std::vector<Frame> frames_;
};

}  // namespace steady
