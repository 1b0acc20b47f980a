// SPDX-License-Identifier: MIT
#include "render/sequence_renderer.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <dynfilter/core/error.hpp>
#include <opencv2/core.hpp>

#include "render/calibration_error.hpp"

namespace dynfilter::render {

namespace detail {

inline Camera with_baseline(Camera camera, double baseline_m) {
  camera.baseline_fx_px_m = baseline_m * camera.fx_px;
  return camera;
}

}  // namespace detail

SequenceRenderer::SequenceRenderer(const SequenceOptions& options)
    : options_(checked(options)),
      scene_(make_scene(options.scene, options.seed)),
      camera_(detail::with_baseline(scene_.camera_model.camera,
                                    options.right_images ? scene_.camera_model.baseline_m : 0)),
      calibration_(with_calibration_error(camera_, options.calibration_error, options.seed)),
      drawer_(camera_),
      depth_sensor_(camera_, depth_options(options, scene_.camera_model), options.seed),
      colour_sensor_(colour_options(options), options.seed),
      truth_maker_(camera_, options.truth),
      detector_(options.detector) {
  check_shutter();
}

RenderedFrame SequenceRenderer::frame(int index) {
  RenderedFrame out;
  render(index, out);
  return out;
}

void SequenceRenderer::render(int index, RenderedFrame& out) {
  const double now_s = time_s(index);
  const Eigen::Isometry3d T_world_camera = scene_.camera->pose(now_s);
  drawer_.draw(scene_, now_s, T_world_camera, geometry_);
  out.timestamp_s = timestamp_s(index);
  out.T_world_camera = Pose::from(T_world_camera);
  find_items(index);
  truth_maker_.make(geometry_, items_, T_world_camera, out.truth);
  geometry_.depth_m.copyTo(out.true_depth_m);
  if (options_.instances) find_instances(out);
  Random depth_random = random_of(index, 1), colour_random = random_of(index, 2);
  measure_depth(now_s, depth_random, out.depth);
  expose(now_s, geometry_.colour, Eigen::Isometry3d::Identity(), out.colour);
  colour_sensor_.expose(out.colour, now_s, colour_random);
  if (options_.right_images) take_right_image(index, now_s, out.right);
  remember_detections(index);
  give_detections(index, out);
}

inline const SequenceOptions& SequenceRenderer::checked(const SequenceOptions& o) {
  if (o.frames < 1) throw ConfigError("frames", "expected at least 1, got " + std::to_string(o.frames));
  if (o.detector.late_frames < 0)
    throw ConfigError("late_frames", "expected 0 or more, got " + std::to_string(o.detector.late_frames));
  if (o.rate_hz) require("rate_hz", *o.rate_hz, 1, 1000);
  require("depth_offset_ms", o.depth_offset_ms, 0, 1000);
  require("calibration_error", o.calibration_error, -20, 20);
  require("gyro_offset_ms", o.gyro_offset_ms, -100, 100);
  require("window_s", o.truth.window_s, 1e-6, 1e6);
  return o;
}

inline void SequenceRenderer::require(const char* option, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw ConfigError(option, "expected " + text(low) + " to " + text(high) + ", got " + text(value));
}

inline std::string SequenceRenderer::text(double value) {
  char out[32];
  std::snprintf(out, sizeof(out), "%g", value);
  return out;
}

inline void SequenceRenderer::check_shutter() const {
  const double most_ms = 1e3 / rate_hz();
  require("exposure_ms", exposure_ms(), 0, most_ms);
  require("rolling_shutter_ms", readout_ms(), 0, most_ms);
}

inline DepthSensor::Options SequenceRenderer::depth_options(const SequenceOptions& o,
                                                            const CameraModel& model) {
  DepthSensor::Options out;
  out.perfect = o.perfect_depth || model.exact_depth_to_m > 0;
  if (model.exact_depth_to_m > 0) out.farthest_perfect_m = model.exact_depth_to_m;
  out.depth_units_per_m = model.depth_units_per_m;
  return out;
}

inline ColourSensor::Options SequenceRenderer::colour_options(const SequenceOptions& o) {
  ColourSensor::Options out;
  out.noise = o.image_noise;
  out.exposure_variation = o.exposure_variation;
  out.exposure_steps = o.exposure_steps;
  return out;
}

inline void SequenceRenderer::find_items(int index) {
  item_poses(scene_, time_s(index), now_);
  item_poses(scene_, time_s(index - 1), last_);
  item_poses(scene_, time_s(index - options_.truth.window_s * rate_hz()), then_);
  items_.assign(1, {});
  for (const Mover& mover : scene_.movers) {
    for (const MoverPart& part : mover.parts) {
      const std::size_t i = items_.size();
      const Eigen::Isometry3d back = now_[i].inverse();
      items_.push_back({part.label, part.person, last_[i] * back, then_[i] * back});
    }
  }
}

// Numbers above 255 repeat: no image shows that many objects.
inline void SequenceRenderer::find_instances(RenderedFrame& out) const {
  const auto number = [](int object) { return object == 0 ? 0 : (object - 1) % 255 + 1; };
  out.instances.create(geometry_.instance.size(), CV_8UC1);
  for (int y = 0; y < out.instances.rows; ++y)
    for (int x = 0; x < out.instances.cols; ++x)
      out.instances.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(number(geometry_.instance.at<std::uint16_t>(y, x)));
  const std::vector<cv::Rect> boxes =
      visible_boxes(geometry_.instance, scene_.objects.size(), options_.detector.smallest_px);
  out.instance_boxes.clear();
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (!boxes[i].empty())
      out.instance_boxes.push_back({cv::Rect2f(boxes[i]),
                                    scene_.objects[i].class_id,
                                    scene_.objects[i].class_name,
                                    1.0F,
                                    number(static_cast<int>(i) + 1),
                                    {}});
}

inline void SequenceRenderer::measure_depth(double now_s, Random& random, cv::Mat& depth) {
  const double later_s = now_s + options_.depth_offset_ms / 1e3;
  if (later_s != now_s) drawer_.draw(scene_, later_s, scene_.camera->pose(later_s), later_);
  depth_sensor_.measure(later_s != now_s ? later_ : geometry_, scene_.materials, random, depth);
}

inline void SequenceRenderer::take_right_image(int index, double now_s, cv::Mat& right) {
  Eigen::Isometry3d T_camera_eye = Eigen::Isometry3d::Identity();
  T_camera_eye.translation().x() = scene_.camera_model.baseline_m;
  drawer_.draw_colour(scene_, now_s, scene_.camera->pose(now_s) * T_camera_eye, {0, camera_.height_px - 1},
                      drawn_right_);
  expose(now_s, drawn_right_, T_camera_eye, right);
  Random random = random_of(index, 4);
  colour_sensor_.expose(right, now_s, random);
}

inline void SequenceRenderer::expose(double now_s, const cv::Mat& drawn,
                                     const Eigen::Isometry3d& T_camera_eye, cv::Mat& colour) {
  const double exposure_s = exposure_ms() / 1e3, readout_s = readout_ms() / 1e3;
  const double motion_px = largest_motion_px(now_s, exposure_s + readout_s);
  const Shutter shutter(exposure_s, readout_s, Shutter::steps_for(exposure_s, readout_s, motion_px),
                        camera_.height_px);
  if (shutter.steps() == 1) {
    drawn.copyTo(colour);
    return;
  }
  light_.begin(drawn.size());
  for (int step = 0; step < shutter.steps(); ++step) {
    const RowRange rows = shutter.rows(step);
    if (rows.last < rows.first) continue;
    const double at_s = now_s + shutter.offset_s(step);
    drawer_.draw_colour(scene_, at_s, scene_.camera->pose(at_s) * T_camera_eye, rows, instant_);
    for (int y = rows.first; y <= rows.last; ++y) light_.add_row(instant_, y, shutter.weight(step, y));
  }
  light_.write(colour);
}

inline double SequenceRenderer::largest_motion_px(double now_s, double span_s) {
  if (span_s <= 0) return 0;
  item_poses(scene_, now_s, now_);
  const std::vector<Eigen::Isometry3d> before = moved(now_s, -span_s / 2), after = moved(now_s, span_s / 2);
  constexpr int kGrid_px = 8;
  double largest = 0;
  for (int y = kGrid_px / 2; y < camera_.height_px; y += kGrid_px) {
    for (int x = kGrid_px / 2; x < camera_.width_px; x += kGrid_px) {
      const double z = static_cast<double>(geometry_.depth_m.at<float>(y, x));
      if (z <= 0) continue;
      const std::size_t item = geometry_.item.at<std::uint16_t>(y, x);
      const Eigen::Vector3d p(z * (x - camera_.cx_px) / camera_.fx_px,
                              z * (y - camera_.cy_px) / camera_.fy_px, z);
      largest = std::max(largest, miss_px(before[item] * p, x, y) + miss_px(after[item] * p, x, y));
    }
  }
  return largest;
}

inline std::vector<Eigen::Isometry3d> SequenceRenderer::moved(double now_s, double by_s) {
  const Eigen::Isometry3d T_world_now = scene_.camera->pose(now_s);
  const Eigen::Isometry3d T_then_world = scene_.camera->pose(now_s + by_s).inverse();
  std::vector<Eigen::Isometry3d> then;
  item_poses(scene_, now_s + by_s, then);
  for (std::size_t i = 0; i < then.size(); ++i)
    then[i] = T_then_world * then[i] * now_[i].inverse() * T_world_now;
  return then;
}

inline double SequenceRenderer::miss_px(const Eigen::Vector3d& p, int x, int y) const {
  if (p.z() < 0.05) return 0;
  return std::hypot(camera_.fx_px * p.x() / p.z() + camera_.cx_px - x,
                    camera_.fy_px * p.y() / p.z() + camera_.cy_px - y);
}

inline void SequenceRenderer::remember_detections(int index) {
  Random random = random_of(index, 3);
  detected_[index] = detector_.detect(geometry_.instance, scene_.objects, random);
  while (detected_.size() > 64) detected_.erase(detected_.begin());
}

inline void SequenceRenderer::give_detections(int index, RenderedFrame& out) {
  out.detected_on_frame = index - options_.detector.late_frames;
  out.detections.reset();
  if (out.detected_on_frame < 0) {
    out.detected_on_frame = -1;
    return;
  }
  // Frames were requested out of order.
  if (detected_.find(out.detected_on_frame) == detected_.end()) {
    const double then_s = time_s(out.detected_on_frame);
    drawer_.draw(scene_, then_s, scene_.camera->pose(then_s), geometry_);
    remember_detections(out.detected_on_frame);
  }
  out.detections = detected_[out.detected_on_frame];
}

}  // namespace dynfilter::render
