// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/synth/colour_sensor.hpp>
#include <dynfilter/synth/depth_sensor.hpp>
#include <dynfilter/synth/detector_model.hpp>
#include <dynfilter/synth/rasteriser.hpp>
#include <dynfilter/synth/scenes.hpp>
#include <dynfilter/synth/truth.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter::synth {

struct SequenceOptions {
  std::string scene = "walking_xyz";
  int frames = 200;
  std::uint64_t seed = 1;
  bool exposure_variation = false;
  bool motion_blur = false;
  double image_noise = 1.6;    ///< grey levels, 0: none
  bool perfect_depth = false;  ///< no noise, no holes
  DetectorFaults detector;
  TruthRule truth;
  bool overwrite = false;  ///< write_sequence(): replace a folder that is not empty
};

/// The camera of every sequence: TUM's freiburg3, 30 Hz.
inline Camera fr3_camera() {
  Camera camera;
  camera.fx_px = 535.4, camera.fy_px = 539.2, camera.cx_px = 320.1, camera.cy_px = 247.6;
  camera.width_px = 640, camera.height_px = 480;
  return camera;
}
constexpr double kFps = 30.0, kDepthUnitsPerM = 5000.0;

struct RenderedFrame {
  double timestamp_s = 0;
  cv::Mat colour;        ///< CV_8UC3
  cv::Mat depth;         ///< CV_16UC1, kDepthUnitsPerM, 0: none
  cv::Mat true_depth_m;  ///< CV_32FC1
  TruthImages truth;
  Pose T_world_camera;
  std::optional<std::vector<Detection>> detections;  ///< nullopt: none came (the detector is late)
  int detected_on_frame = -1;                        ///< the frame they were computed on
};

/// Renders the frames of a sequence, in any order: a frame depends on options, seed and its number only.
/// About 50 ms a frame, and 0.4 s to build the scene.
class SequenceRenderer {
 public:
  /// Throws ConfigError on an unknown scene or senseless options.
  explicit SequenceRenderer(const SequenceOptions& options)
      : options_(checked(options)),
        camera_(fr3_camera()),
        scene_(make_scene(options.scene, options.seed)),
        rasteriser_(camera_),
        depth_sensor_(camera_, depth_options(options), options.seed),
        colour_sensor_(colour_options(options), options.seed),
        truth_maker_(camera_, options.truth),
        detector_(options.detector) {}

  const SequenceOptions& options() const { return options_; }
  const Camera& camera() const { return camera_; }
  const Scene& scene() const { return scene_; }
  int size() const { return options_.frames; }
  static double time_s(double frame) { return frame / kFps; }
  static double timestamp_s(int frame) { return (1.7e15 + std::round(frame * 1e6 / kFps)) / 1e6; }
  Pose pose(int frame) const { return Pose::from(scene_.camera->pose(time_s(frame))); }

  RenderedFrame frame(int index) {
    RenderedFrame out;
    render(index, out);
    return out;
  }

  /// The same into a frame that is used again: its images keep their memory.
  void render(int index, RenderedFrame& out) {
    const Eigen::Isometry3d T_world_camera = scene_.camera->pose(time_s(index));
    draw(index, T_world_camera);
    out.timestamp_s = timestamp_s(index);
    out.T_world_camera = Pose::from(T_world_camera);
    truth_maker_.make(geometry_, items_, T_world_camera, out.truth);
    geometry_.depth_m.copyTo(out.true_depth_m);
    Random depth_random = random_of(index, 1), colour_random = random_of(index, 2);
    depth_sensor_.measure(geometry_, scene_.materials, depth_random, out.depth);
    if (options_.motion_blur) flow(index, T_world_camera);
    geometry_.colour.copyTo(out.colour);
    colour_sensor_.expose(out.colour, flow_px_, time_s(index), colour_random);
    remember_detections(index);
    give_detections(index, out);
  }

 private:
  static const SequenceOptions& checked(const SequenceOptions& o) {
    if (o.frames < 1) throw ConfigError("frames", "expected at least 1, got " + std::to_string(o.frames));
    if (o.detector.late_frames < 0)
      throw ConfigError("late_frames", "expected 0 or more, got " + std::to_string(o.detector.late_frames));
    if (o.truth.window_frames < 1) throw ConfigError("window_frames", "expected at least 1");
    return o;
  }
  static DepthSensor::Options depth_options(const SequenceOptions& o) {
    DepthSensor::Options out;
    out.perfect = o.perfect_depth;
    out.depth_units_per_m = kDepthUnitsPerM;
    return out;
  }
  static ColourSensor::Options colour_options(const SequenceOptions& o) {
    ColourSensor::Options out;
    out.noise = o.image_noise;
    out.exposure_variation = o.exposure_variation;
    out.motion_blur = o.motion_blur;
    return out;
  }
  Random random_of(int frame, std::uint64_t purpose) const {
    return Random(options_.seed * 1000003ULL + static_cast<std::uint64_t>(frame), purpose);
  }

  void draw(int index, const Eigen::Isometry3d& T_world_camera) {
    const Eigen::Isometry3f T_camera_world = T_world_camera.inverse().cast<float>();
    rasteriser_.begin();
    items_.assign(1, {});
    for (const Model& model : scene_.room->models) rasteriser_.draw(model, T_camera_world, 0);
    for (const Mover& mover : scene_.movers) draw_mover(mover, index, T_camera_world);
    rasteriser_.resolve(scene_.materials, geometry_);
  }

  void draw_mover(const Mover& mover, int index, const Eigen::Isometry3f& T_camera_world) {
    mover.animation->pose(time_s(index), now_);
    mover.animation->pose(time_s(index - 1), last_);
    mover.animation->pose(time_s(index - options_.truth.window_frames), then_);
    for (std::size_t i = 0; i < mover.parts.size(); ++i) {
      const MoverPart& part = mover.parts[i];
      const Eigen::Isometry3d back = now_[i].inverse();
      items_.push_back({part.label, part.person, last_[i] * back, then_[i] * back});
      const Eigen::Isometry3f T_world_part = now_[i].cast<float>();
      shade_part(part.model, T_world_part);
      rasteriser_.draw(part.model, T_camera_world * T_world_part, static_cast<int>(items_.size()) - 1,
                       &shades_);
    }
  }

  void shade_part(const Model& model, const Eigen::Isometry3f& T_world_part) {
    shades_.resize(model.vertices.size());
    for (std::size_t i = 0; i < shades_.size(); ++i) {
      const Eigen::Vector3f p = T_world_part * model.vertices[i].position_m;
      const float open = std::min(1.0F, 0.62F + 0.28F * p.z());
      shades_[i] = scene_.room->lighting.shade(p, T_world_part.linear() * model.vertices[i].normal, open);
    }
  }

  /// Motion of every pixel since the last frame, for the blur.
  void flow(int index, const Eigen::Isometry3d& T_world_camera) {
    const Eigen::Isometry3d T_last_world = scene_.camera->pose(time_s(index - 1)).inverse();
    std::vector<Eigen::Isometry3f> last_from_camera;
    for (const ItemTruth& item : items_)
      last_from_camera.push_back((T_last_world * item.last_from_now * T_world_camera).cast<float>());
    const auto fx = static_cast<float>(camera_.fx_px), fy = static_cast<float>(camera_.fy_px);
    const auto cx = static_cast<float>(camera_.cx_px), cy = static_cast<float>(camera_.cy_px);
    flow_px_.create(geometry_.depth_m.size(), CV_32FC2);
    for (int y = 0; y < flow_px_.rows; ++y) {
      for (int x = 0; x < flow_px_.cols; ++x) {
        const float z = geometry_.depth_m.at<float>(y, x), px = static_cast<float>(x),
                    py = static_cast<float>(y);
        const Eigen::Vector3f p(z * (px - cx) / fx, z * (py - cy) / fy, z);
        const Eigen::Vector3f q = last_from_camera[geometry_.item.at<std::uint16_t>(y, x)] * p;
        flow_px_.at<cv::Vec2f>(y, x) =
            z > 0 && q.z() > 0.05F ? cv::Vec2f(px - fx * q.x() / q.z() - cx, py - fy * q.y() / q.z() - cy)
                                   : cv::Vec2f(0, 0);
      }
    }
  }

  void remember_detections(int index) {
    Random random = random_of(index, 3);
    detected_[index] = detector_.detect(geometry_.instance, scene_.objects, random);
    while (detected_.size() > 64) detected_.erase(detected_.begin());
  }

  void give_detections(int index, RenderedFrame& out) {
    out.detected_on_frame = index - options_.detector.late_frames;
    out.detections.reset();
    if (out.detected_on_frame < 0) {
      out.detected_on_frame = -1;
      return;
    }
    if (detected_.find(out.detected_on_frame) == detected_.end()) {  // asked for out of order
      draw(out.detected_on_frame, scene_.camera->pose(time_s(out.detected_on_frame)));
      remember_detections(out.detected_on_frame);
    }
    out.detections = detected_[out.detected_on_frame];
  }

  SequenceOptions options_;
  Camera camera_;
  Scene scene_;
  Rasteriser rasteriser_;
  DepthSensor depth_sensor_;
  ColourSensor colour_sensor_;
  TruthMaker truth_maker_;
  DetectorModel detector_;
  GeometryImage geometry_;
  cv::Mat flow_px_;
  std::vector<ItemTruth> items_;
  std::vector<Eigen::Isometry3d> now_, last_, then_;
  std::vector<Eigen::Vector3f> shades_;
  std::map<int, std::vector<Detection>> detected_;
};

}  // namespace dynfilter::synth
