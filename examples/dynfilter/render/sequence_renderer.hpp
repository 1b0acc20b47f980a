// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/random.hpp>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/colour_sensor.hpp"
#include "render/depth_sensor.hpp"
#include "render/detector_model.hpp"
#include "render/inertial_sensor.hpp"
#include "render/rasteriser.hpp"
#include "render/scene_drawer.hpp"
#include "render/scenes.hpp"
#include "render/shutter.hpp"
#include "render/truth.hpp"

namespace dynfilter::render {

struct SequenceOptions {
  std::string scene = "walking_xyz";
  int frames = 200;
  std::uint64_t seed = 1;
  std::optional<double> rate_hz;      ///< nullopt: value of the scene's camera
  bool right_images = false;          ///< also those of a second camera, to the right of the first
  bool exposure_variation = false;    ///< smooth gain variation
  bool exposure_steps = false;        ///< gain jumps about once per second
  bool motion_blur = false;           ///< exposure of kBlurExposure_ms, unless exposure_ms is set
  std::optional<double> exposure_ms;  ///< 0: no motion blur; nullopt: value of the scene's camera
  /// Time from the exposure of the first row to that of the last; nullopt: value of the scene's camera.
  std::optional<double> rolling_shutter_ms;
  double depth_offset_ms = 0;    ///< delay of the depth image relative to its timestamp
  double calibration_error = 0;  ///< error of calibration(); 1: a bad calibration
  double image_noise = 1.6;      ///< grey levels; 0: no noise
  bool perfect_depth = false;    ///< no noise, no holes
  DetectorFaults detector;
  TruthRule truth;
  GyroGrade gyro = GyroGrade::Phone;  ///< of the gyroscope that write_sequence() adds
  double gyro_offset_ms = 0;          ///< delay of its stamps
  bool instances = false;             ///< write_sequence() also writes perfect instance masks
  bool overwrite = false;             ///< write_sequence() replaces a folder that is not empty
};

constexpr double kBlurExposure_ms = 12;

struct RenderedFrame {
  double timestamp_s = 0;
  cv::Mat colour;        ///< CV_8UC3
  cv::Mat right;         ///< CV_8UC3, of the right camera; empty unless the options ask for it
  cv::Mat depth;         ///< CV_16UC1, in units of the scene's camera; 0: no depth
  cv::Mat true_depth_m;  ///< CV_32FC1, at the pose of the colour image
  TruthImages truth;
  /// CV_8UC1, 0: none, else the number of the object that a detector knows. Parked cars have one, too.
  cv::Mat instances;
  std::vector<Detection> instance_boxes;  ///< without faults; `track_id` is the number in `instances`
  Pose T_world_camera;
  /// nullopt: no result, because the detector is late.
  std::optional<std::vector<Detection>> detections;
  int detected_on_frame = -1;  ///< frame that they were computed on
};

/// Renders the frames of a sequence in any order.
/// A frame depends only on the options, the seed and its number.
/// The timestamp is the middle of the exposure of the middle row.
/// Pose and truth belong to this instant.
/// Cost: about 50 ms per frame, and 0.4 s to create the scene.
/// Blur and rolling rows cost another 25 ms per sub-frame.
class SequenceRenderer {
 public:
  /// Throws ConfigError for an unknown scene or invalid options.
  explicit SequenceRenderer(const SequenceOptions& options);

  const SequenceOptions& options() const { return options_; }
  const Camera& camera() const { return camera_; }
  /// Calibration for users of the sequence, with its error.
  const Camera& calibration() const { return calibration_; }
  const Scene& scene() const { return scene_; }
  int size() const { return options_.frames; }
  /// What results from the options and the scene; 0: no rolling shutter, no motion blur.
  double readout_ms() const { return options_.rolling_shutter_ms.value_or(scene_.readout_ms); }
  double exposure_ms() const {
    return options_.exposure_ms.value_or(options_.motion_blur ? kBlurExposure_ms : scene_.exposure_ms);
  }
  double rate_hz() const { return options_.rate_hz.value_or(scene_.camera_model.rate_hz); }
  double time_s(double frame) const { return frame / rate_hz(); }
  double timestamp_s(int frame) const { return stamp_s(frame * 1e6 / rate_hz()); }
  /// Timestamp of frame 0 of every sequence.
  static double first_timestamp_s() { return stamp_s(0); }
  Pose pose(int frame) const { return Pose::from(scene_.camera->pose(time_s(frame))); }

  RenderedFrame frame(int index);

  /// Renders into an existing frame and reuses its memory.
  void render(int index, RenderedFrame& out);

  /// Image of a camera without noise and with an instant shutter.
  void instant(double at_s, cv::Mat& colour) {
    drawer_.draw_colour(scene_, at_s, scene_.camera->pose(at_s), {0, camera_.height_px - 1}, colour);
  }

 private:
  static const SequenceOptions& checked(const SequenceOptions& o);
  static void require(const char* option, double value, double low, double high);
  static std::string text(double value);
  void check_shutter() const;
  static double stamp_s(double micros) { return (1.7e15 + std::round(micros)) / 1e6; }
  static DepthSensor::Options depth_options(const SequenceOptions& o, const CameraModel& model);
  static ColourSensor::Options colour_options(const SequenceOptions& o);
  Random random_of(int frame, std::uint64_t purpose) const {
    return Random(options_.seed * std::uint64_t{1000003} + static_cast<std::uint64_t>(frame), purpose);
  }

  void find_items(int index);

  void find_instances(RenderedFrame& out) const;

  void measure_depth(double now_s, Random& random, cv::Mat& depth);

  /// `drawn`: the image at `now_s`. `T_camera_eye`: where the image is taken from, in the camera's frame.
  void expose(double now_s, const cv::Mat& drawn, const Eigen::Isometry3d& T_camera_eye, cv::Mat& colour);

  void take_right_image(int index, double now_s, cv::Mat& right);

  /// Longest image path of a point over `span_s`, centred at the frame.
  double largest_motion_px(double now_s, double span_s);

  /// Motion of points on each item, from the current camera frame to that `by_s` later.
  std::vector<Eigen::Isometry3d> moved(double now_s, double by_s);

  double miss_px(const Eigen::Vector3d& p, int x, int y) const;

  void remember_detections(int index);

  void give_detections(int index, RenderedFrame& out);

  SequenceOptions options_;
  Scene scene_;
  Camera camera_, calibration_;
  SceneDrawer drawer_;
  DepthSensor depth_sensor_;
  ColourSensor colour_sensor_;
  TruthMaker truth_maker_;
  DetectorModel detector_;
  GeometryImage geometry_, later_;
  cv::Mat instant_, drawn_right_;
  LightSum light_;
  std::vector<ItemTruth> items_;
  std::vector<Eigen::Isometry3d> now_, last_, then_;
  std::map<int, std::vector<Detection>> detected_;
};

}  // namespace dynfilter::render
