// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/tum_sequence.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/io/camera_file.hpp>
#include <dynfilter/io/image_file.hpp>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>
#include <utility>

namespace dynfilter::io {

DYNFILTER_INLINE TumSequence TumSequence::open(const std::filesystem::path& folder,
                                               const TumOptions& options) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) throw IoError(folder.string() + ": no such folder");
  TumSequence sequence;
  sequence.folder_ = folder;
  detail::TumIndex index = detail::read_tum_index(folder, options.max_association_gap_s);
  sequence.frames_ = std::move(index.frames);
  sequence.notes_ = std::move(index.notes);
  sequence.find_camera(options);
  return sequence;
}

DYNFILTER_INLINE std::string TumSequence::image_name(std::size_t i) const {
  return std::filesystem::path(frames_.at(i).colour).stem().string();
}

DYNFILTER_INLINE RgbdFrame TumSequence::load(std::size_t i) const {
  const detail::IndexedFrame& frame = frames_.at(i);
  RgbdFrame loaded;
  loaded.timestamp_s = frame.timestamp_s;
  loaded.depth_unit_m = 1.0 / depth_units_per_m_;
  loaded.colour = read_image(folder_ / frame.colour, cv::IMREAD_COLOR);
  check_camera_size(loaded.colour.size(), frame.colour);
  cv::cvtColor(loaded.colour, loaded.grey, cv::COLOR_BGR2GRAY);
  if (!frame.depth.empty()) loaded.depth = load_depth(frame, loaded.colour.size());
  return loaded;
}

DYNFILTER_INLINE std::optional<Trajectory> TumSequence::ground_truth() const {
  std::error_code error;
  const std::filesystem::path path = folder_ / "groundtruth.txt";
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  return read_tum_trajectory(path);
}

DYNFILTER_INLINE bool TumSequence::has_labels() const {
  std::error_code error;
  return std::filesystem::is_directory(folder_ / "labels", error) &&
         std::filesystem::is_directory(folder_ / "dynamic", error);
}

DYNFILTER_INLINE std::string TumSequence::name_of(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(folder, error);
  const std::filesystem::path& path = error ? folder : whole;
  return path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
}

inline std::string TumSequence::recording_of(const std::filesystem::path& list) {
  std::ifstream in(list);
  std::string line;
  for (int i = 0; i < 3 && std::getline(in, line); ++i) {
    if (line.rfind("# file:", 0) == 0) return line;
  }
  return "";
}

inline void TumSequence::find_camera(const TumOptions& options) {
  std::error_code error;
  const std::filesystem::path file = folder_ / "camera.yaml";
  std::optional<Camera> found;
  if (std::filesystem::is_regular_file(file, error)) {
    const CameraFile read = read_camera(file);
    found = read.camera;
    depth_units_per_m_ = read.depth_units_per_m.value_or(depth_units_per_m_);
  }
  for (const std::string& name :
       {name_of(folder_), recording_of(folder_ / "groundtruth.txt"), recording_of(folder_ / "rgb.txt")}) {
    if (!found) found = known_camera(name);
  }
  if (options.camera) found = options.camera;
  if (!found || !found->valid()) {
    throw CameraError(folder_.string() +
                      ": the camera is not known: no camera.yaml there, and the folder's name does not " +
                      "say freiburg1, 2, 3 or bonn; give a camera file");
  }
  camera_ = *found;
  depth_units_per_m_ = options.depth_units_per_m.value_or(depth_units_per_m_);
}

inline void TumSequence::check_camera_size(const cv::Size& size, const std::string& file) const {
  const cv::Size expected(camera_.width_px, camera_.height_px);
  if (expected.width <= 0 || expected.height <= 0 || size == expected) return;
  throw CameraError((folder_ / file).string() + ": is " + text(size) + ", but the camera is for " +
                    text(expected) + "; give another camera file");
}

inline cv::Mat TumSequence::load_depth(const detail::IndexedFrame& frame, const cv::Size& colour_size) const {
  const std::filesystem::path path = folder_ / frame.depth;
  cv::Mat depth = read_image(path, cv::IMREAD_UNCHANGED);
  if (depth.type() != CV_16UC1) throw IoError(path.string() + ": is not a 16-bit depth image");
  if (depth.size() != colour_size) {
    throw IoError(path.string() + ": is " + text(depth.size()) + ", but its colour image " + frame.colour +
                  " is " + text(colour_size));
  }
  return depth;
}

DYNFILTER_INLINE cv::Mat TumSequence::load_label_image(const char* kind, std::size_t i) const {
  const std::filesystem::path path = folder_ / kind / (image_name(i) + ".png");
  cv::Mat image = read_image(path, cv::IMREAD_UNCHANGED);
  if (image.type() != CV_8UC1) throw IoError(path.string() + ": is not an 8-bit label image");
  return image;
}

inline std::string TumSequence::text(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

}  // namespace dynfilter::io
