// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/detectors/detections.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "io/sequence.hpp"
#include "odometry/options.hpp"
#include "odometry/sensor.hpp"
#include "sequence_run.hpp"
#include "text/option_hint.hpp"

namespace dynfilter::command {

inline io::Sequence open_sequence(const RunOptions& options) {
  io::SequenceOptions given;
  given.scale = options.scale;
  if (!options.camera.empty()) {
    const io::CameraFile file = read_for("--camera", [&] { return io::read_camera(options.camera); });
    given.camera = file.camera;
    given.depth_units_per_m = file.depth_units_per_m;
    given.rate_hz = file.rate_hz;
  }
  return with_hint<io::CameraError>(" with --camera",
                                    [&] { return io::Sequence::open(options.sequence, given); });
}

/// The sensor that the options or the data ask for. Throws IoError if the sequence lacks its images.
inline odometry::Sensor chosen_sensor(const RunOptions& options, const io::Sequence& sequence) {
  using odometry::Sensor;
  const auto named = odometry::sensor_named(options.sensor.empty() ? sequence.sensor() : options.sensor);
  if (!named)
    return sequence.has_depth() ? Sensor::Rgbd : sequence.has_stereo() ? Sensor::Stereo : Sensor::Mono;
  if (*named == Sensor::Rgbd && !sequence.has_depth())
    throw IoError(options.sequence + ": has no depth images, which the sensor rgbd needs");
  if (*named == Sensor::Stereo && !sequence.has_stereo())
    throw IoError(options.sequence +
                  ": the sensor stereo needs right images and the baseline of an undistorted camera");
  return *named;
}

inline odometry::OdometryOptions odometry_options(odometry::Sensor sensor, bool weights, bool poses) {
  odometry::OdometryOptions options;
  options.sensor = sensor;
  options.weights = weights, options.poses = poses;
  return options;
}

/// Throws Error for what a video or a camera cannot do. It names the option that helps.
inline void check_stream(const RunOptions& options, const io::Sequence& sequence) {
  if (!sequence.is_stream()) return;
  if (options.reverse)
    throw Error("--reverse, --variants: " + options.sequence +
                " is decoded forwards only; extract its images to a folder");
  if (sequence.is_camera() && options.frames == 0 && !options.live)
    throw Error(options.sequence + ": a camera has no end; give --frames N, or --live and end it with q");
}

/// Indices into the sequence in playing order: first reversed, then cut, then thinned.
inline std::vector<std::size_t> playing_order(const RunOptions& options, std::size_t size) {
  std::vector<std::size_t> order(size);
  for (std::size_t i = 0; i < size; ++i) order[i] = options.reverse ? size - 1 - i : i;
  if (options.start >= size) {
    throw Error("--start " + std::to_string(options.start) + ": the sequence has only " +
                std::to_string(size) + " frames");
  }
  order.erase(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(options.start));
  for (std::size_t k = 1; k * options.step < order.size(); ++k) order[k] = order[k * options.step];
  order.resize((order.size() + options.step - 1) / options.step);
  if (options.frames > 0 && options.frames < order.size()) order.resize(options.frames);
  return order;
}

/// detections.txt, else the first detections_*.txt by name.
inline std::optional<std::filesystem::path> detections_in(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::is_regular_file(folder / "detections.txt", error)) return folder / "detections.txt";
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("detections_", 0) == 0 && entry.path().extension() == ".txt")
      found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found.empty() ? std::nullopt : std::make_optional(found.front());
}

inline std::optional<io::DetectionTrack> load_detections(const RunOptions& options,
                                                         const io::Sequence& sequence,
                                                         std::vector<std::string>& notes) {
  if (options.no_detections) return std::nullopt;
  std::optional<std::filesystem::path> path;
  if (!options.detections.empty()) path = options.detections;
  if (!path && (path = detections_in(sequence.folder())))
    notes.push_back("boxes from " + path->filename().string());
  if (!path) return std::nullopt;
  io::DetectionTrack track =
      read_for(options.detections.empty() ? "boxes (see --no-detections):" : "--detections",
               [&] { return io::read_detections(*path); });
  for (io::StampedDetections& image : track.images)
    for (Detection& detection : image.detections)
      detection.box = {sequence.scaled(detection.box.tl()), sequence.scaled(detection.box.br())};
  const std::string name = path->filename().string();
  if (track.unusable > 0) {
    notes.push_back(name + ": " + std::to_string(track.unusable) +
                    (track.unusable == 1 ? " unusable box" : " unusable boxes") +
                    " left out (empty, not finite, or score out of [0, 1])");
  }
  if (sequence.is_stream()) return track;  // its stamps are not known yet
  std::vector<double> stamps_s;
  for (std::size_t i = 0; i < sequence.size(); ++i) stamps_s.push_back(sequence.timestamp_s(i));
  std::size_t strangers = 0;
  for (const io::StampedDetections& image : track.images) {
    const auto next = std::lower_bound(stamps_s.begin(), stamps_s.end(), image.timestamp_s - 5e-4);
    strangers += next == stamps_s.end() || *next > image.timestamp_s + 5e-4;
  }
  if (strangers > 0)
    notes.push_back(name + ": boxes of " + std::to_string(strangers) +
                    (strangers == 1 ? " image that is" : " images that are") +
                    " not in the sequence left out");
  return track;
}

/// A folder of masks or label images: 8-bit PNGs with the names of the colour images.
/// A colour image without a file has no mask.
class MaskFolder {
 public:
  /// Throws IoError if a folder was requested and has no mask of the sequence.
  MaskFolder(const RunOptions& options, const io::Sequence& sequence) {
    if (options.no_masks) return;
    const std::filesystem::path folder =
        options.masks.empty() ? sequence.folder() / "masks" : std::filesystem::path(options.masks);
    std::size_t found = 0;
    std::error_code error;
    if (options.masks.empty() && !std::filesystem::is_directory(folder, error)) return;
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      const std::filesystem::path file = folder / (sequence.image_name(i) + ".png");
      const bool there = std::filesystem::is_regular_file(file, error);
      files_.push_back(there ? file : std::filesystem::path());
      found += there ? 1 : 0;
    }
    if (found == 0 && !options.masks.empty())
      throw IoError("--masks " + options.masks + ": no mask is named as a colour image of the sequence");
    if (found == 0) files_.clear();
  }

  /// True if no image has a mask.
  bool empty() const { return files_.empty(); }

  /// Throws IoError if an image cannot be read or is not 8-bit with one channel.
  std::optional<MaskInput> load(std::size_t i) const {
    if (files_.empty() || files_[i].empty()) return std::nullopt;
    MaskInput mask;
    mask.labels = io::read_image(files_[i], io::ImageAs::Stored);
    if (mask.labels.type() != CV_8UC1)
      throw IoError(files_[i].string() + ": is not an 8-bit label image (see --masks, --no-masks)");
    return mask;
  }

 private:
  std::vector<std::filesystem::path> files_;
};

}  // namespace dynfilter::command
