// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "io/trajectory.hpp"
#include "render/camera_model.hpp"
#include "render/scene_file.hpp"
#include "render/sequence_renderer.hpp"

namespace dynfilter::render {

/// Called after each frame with the number of completed frames and the total.
using ProgressCallback = std::function<void(int, int)>;

std::string stamp_text(double timestamp_s);

/// All sensor options of a sequence with their values (flags: 0 or 1).
SensorValues sensor_values(const SequenceRenderer& renderer);

/// Writes one sequence to a folder in the layout of TUM RGB-D, with truth.
class SequenceWriter {
 public:
  /// `camera`: what users of the sequence believe. Right images are written if frames have them.
  SequenceWriter(const std::filesystem::path& folder, const Camera& camera, const CameraModel& model = {});

  void add(const RenderedFrame& frame);

  void finish() const;

 private:
  void image(const char* kind, const std::string& file, const cv::Mat& picture) const;

  void text(const char* name, const std::string& content) const;

  void add_instances(const std::string& stamp, const RenderedFrame& frame);

  static void add_detections(const std::string& stamp, const std::vector<Detection>& detections,
                             std::string& lines);

  std::filesystem::path folder_;
  io::CameraFile camera_;
  std::string rgb_, depth_, associations_, detections_, instances_;
  io::Trajectory trajectory_;
};

/// Renders a sequence into `folder`, which appears when it is complete. Returns the sensor values.
/// Throws IoError if the folder exists and is not empty, unless options.overwrite is set.
/// Throws ConfigError for an unknown scene.
SensorValues write_sequence(const SequenceOptions& options, const std::filesystem::path& folder,
                            const ProgressCallback& progress = {});

}  // namespace dynfilter::render
