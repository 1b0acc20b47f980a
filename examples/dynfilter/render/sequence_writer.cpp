// SPDX-License-Identifier: MIT
#include "render/sequence_writer.hpp"

#include <cstdio>
#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/image_encoder.hpp>
#include <opencv2/imgproc.hpp>
#include <ostream>
#include <system_error>

#include "io/atomic_file.hpp"
#include "io/atomic_folder.hpp"
#include "io/camera_writer.hpp"

namespace dynfilter::render {

std::string stamp_text(double timestamp_s) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6f", timestamp_s);
  return text;
}

SensorValues sensor_values(const SequenceRenderer& renderer) {
  const SequenceOptions& o = renderer.options();
  return {{"hz", renderer.rate_hz()},
          {"exposure_ms", renderer.exposure_ms()},
          {"rolling_shutter_ms", renderer.readout_ms()},
          {"depth_offset_ms", o.depth_offset_ms},
          {"calibration_error", o.calibration_error},
          {"exposure_variation", o.exposure_variation ? 1 : 0},
          {"exposure_steps", o.exposure_steps ? 1 : 0}};
}

SequenceWriter::SequenceWriter(const std::filesystem::path& folder, const Camera& camera,
                               const CameraModel& model)
    : folder_(folder) {
  camera_.camera = camera;
  camera_.depth_units_per_m = model.depth_units_per_m;
  if (model.is_stereo && camera.baseline_fx_px_m > 0) camera_.sensor = "stereo";
  for (const char* name : {"rgb", "depth", "labels", "motion", "dynamic", "masks"})
    std::filesystem::create_directory(folder_ / name);
}

void SequenceWriter::add(const RenderedFrame& frame) {
  const std::string stamp = stamp_text(frame.timestamp_s), file = stamp + ".png";
  image("rgb", file, frame.colour);
  image("depth", file, frame.depth);
  if (!frame.right.empty()) {
    std::filesystem::create_directory(folder_ / "right");
    image("right", file, frame.right);
  }
  image("labels", file, frame.truth.labels);
  image("motion", file, frame.truth.motion);
  image("dynamic", file, frame.truth.dynamic);
  image("masks", file, frame.truth.person);
  if (!frame.instances.empty()) add_instances(stamp, frame);
  rgb_ += stamp + " rgb/" + file + "\n";
  depth_ += stamp + " depth/" + file + "\n";
  associations_ += stamp + " rgb/" + file + " " + stamp + " depth/" + file + "\n";
  trajectory_.push_back({frame.timestamp_s, frame.T_world_camera});
  if (frame.detections) add_detections(stamp, *frame.detections, detections_);
}

void SequenceWriter::finish() const {
  text("rgb.txt", "# color images\n# timestamp filename\n" + rgb_);
  text("depth.txt", "# depth maps\n# timestamp filename\n" + depth_);
  text("associations.txt", associations_);
  const std::string head = "# timestamp class_id class_name score x1 y1 x2 y2\n";
  text("detections.txt", head + detections_);
  if (!instances_.empty()) text("instances.txt", head + instances_);
  io::write_tum_trajectory(folder_ / "groundtruth.txt", trajectory_);
  io::write_camera(folder_ / "camera.yaml", camera_);
}

inline void SequenceWriter::image(const char* kind, const std::string& file, const cv::Mat& picture) const {
  io::write_image(folder_ / kind / file, picture);
}

inline void SequenceWriter::text(const char* name, const std::string& content) const {
  io::write_file_atomically(folder_ / name, [&](std::ostream& out) { out << content; });
}

// Networks make masks of about a quarter of the image's size.
inline void SequenceWriter::add_instances(const std::string& stamp, const RenderedFrame& frame) {
  for (const char* name : {"instances", "instances_small"}) std::filesystem::create_directory(folder_ / name);
  image("instances", stamp + ".png", frame.instances);
  cv::Mat small;
  cv::resize(frame.instances, small, {}, 0.25, 0.25, cv::INTER_NEAREST);
  image("instances_small", stamp + ".png", small);
  add_detections(stamp, frame.instance_boxes, instances_);
}

inline void SequenceWriter::add_detections(const std::string& stamp, const std::vector<Detection>& detections,
                                           std::string& lines) {
  if (detections.empty()) lines += stamp + " none\n";
  for (const Detection& d : detections) {
    char numbers[96];
    std::snprintf(numbers, sizeof(numbers), " %.4f %.1f %.1f %.1f %.1f\n", static_cast<double>(d.score),
                  static_cast<double>(d.box.x), static_cast<double>(d.box.y),
                  static_cast<double>(d.box.br().x), static_cast<double>(d.box.br().y));
    lines += stamp + " " + std::to_string(d.class_id) + " " + d.class_name + numbers;
  }
}

namespace detail {

inline void add_gyroscope(const std::filesystem::path& folder, const SequenceRenderer& renderer) {
  constexpr double kMargin_s = 0.1;
  const SequenceOptions& o = renderer.options();
  const CameraMotion& camera = *renderer.scene().camera;
  InertialRecord record;
  record.samples = inertial_samples([&](double time_s) { return camera.pose(time_s); }, -kMargin_s,
                                    renderer.time_s(renderer.size() - 1) + kMargin_s);
  record.noise = gyro_noise(o.gyro);
  record.first_frame_s = SequenceRenderer::first_timestamp_s();
  record.stamps_late_s = o.gyro_offset_ms / 1e3;
  Random random(o.seed, kInertialStream);
  add_gyro_noise(record.noise, random, record.samples);
  write_inertial(folder / "imu0", record);
}

}  // namespace detail

SensorValues write_sequence(const SequenceOptions& options, const std::filesystem::path& folder,
                            const ProgressCallback& progress) {
  std::error_code error;
  if (std::filesystem::is_directory(folder, error) && !std::filesystem::is_empty(folder, error) &&
      !options.overwrite) {
    throw IoError(folder.string() + ": exists and is not empty");
  }
  SequenceRenderer renderer(options);
  io::AtomicFolder results(folder, io::OtherEntries::Remove);
  SequenceWriter writer(results.path(), renderer.calibration(), renderer.scene().camera_model);
  RenderedFrame frame;
  for (int i = 0; i < renderer.size(); ++i) {
    renderer.render(i, frame);
    writer.add(frame);
    if (progress) progress(i + 1, renderer.size());
  }
  writer.finish();
  if (options.gyro != GyroGrade::None) detail::add_gyroscope(results.path(), renderer);
  write_scene_name(results.path(), {options.scene, options.seed, sensor_values(renderer)});
  results.commit();
  return sensor_values(renderer);
}

}  // namespace dynfilter::render
