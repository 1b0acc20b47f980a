// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/io/camera_file.hpp>
#include <dynfilter/io/image_file.hpp>
#include <dynfilter/io/trajectory.hpp>
#include <dynfilter/io/tum_index.hpp>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter::io {

/// The camera of a sequence is not known, or does not fit its images: a camera file helps.
class CameraError : public IoError {
 public:
  using IoError::IoError;
};

struct TumOptions {
  double max_association_gap_s = 0.02;  ///< largest time difference of a colour and a depth image
  std::optional<Camera> camera;         ///< replaces the camera of the folder
  /// Replaces the value of the folder, which is 5000 by default.
  std::optional<double> depth_units_per_m;
};

/// One loaded frame. The caller owns the images.
struct RgbdFrame {
  double timestamp_s = 0;
  cv::Mat colour;           ///< CV_8UC3, in the order blue, green, red
  cv::Mat grey;             ///< CV_8UC1
  cv::Mat depth;            ///< CV_16UC1, 0 for no depth; empty: no depth image
  double depth_unit_m = 0;  ///< metres per unit of `depth`
};

/// A TUM RGB-D or Bonn folder as downloaded, with or without associations.txt.
/// Folders written by synth also have labels.
class TumSequence {
 public:
  /// Reads the lists, not the images.
  /// Throws IoError with one line that names the file:
  /// if the folder is missing, if lists are missing, empty or out of order,
  /// if no frame has depth or the camera is unknown.
  static TumSequence open(const std::filesystem::path& folder, const TumOptions& options = {}) {
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

  std::size_t size() const { return frames_.size(); }
  double timestamp_s(std::size_t i) const { return frames_.at(i).timestamp_s; }
  /// Name of the colour image without folder and suffix. Related images have the same name.
  std::string image_name(std::size_t i) const {
    return std::filesystem::path(frames_.at(i).colour).stem().string();
  }
  const Camera& camera() const { return camera_; }
  const std::filesystem::path& folder() const { return folder_; }
  /// Name of the folder itself, also for "." and similar paths.
  std::string name() const { return name_of(folder_); }
  /// What was skipped, with counts, one line each.
  const std::vector<std::string>& notes() const { return notes_; }

  /// Loads a frame. Throws IoError with the file name if an image is missing, truncated or invalid.
  /// Depth must be 16 bit, and the sizes must match each other and the camera.
  RgbdFrame load(std::size_t i) const {
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

  /// Reads groundtruth.txt; nullopt if it does not exist. Throws IoError if it cannot be read.
  std::optional<Trajectory> ground_truth() const {
    std::error_code error;
    const std::filesystem::path path = folder_ / "groundtruth.txt";
    if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
    return read_tum_trajectory(path);
  }

  /// True for synthetic sequences, which have labels/ and dynamic/.
  bool has_labels() const {
    std::error_code error;
    return std::filesystem::is_directory(folder_ / "labels", error) &&
           std::filesystem::is_directory(folder_ / "dynamic", error);
  }
  /// CV_8UC1: 0 static, 255 dynamic, 128 don't care (slow motion or near a silhouette).
  /// Throws IoError.
  cv::Mat load_truth(std::size_t i) const { return load_label_image("dynamic", i); }
  /// CV_8UC1: 0 static, k = mover k, moving or not. Throws IoError.
  cv::Mat load_labels(std::size_t i) const { return load_label_image("labels", i); }

 private:
  static std::string name_of(const std::filesystem::path& folder) {
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::weakly_canonical(folder, error);
    const std::filesystem::path& path = error ? folder : whole;
    return path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
  }

  // The TUM lists name the recording in a comment, which remains valid if the folder is renamed.
  static std::string recording_of(const std::filesystem::path& list) {
    std::ifstream in(list);
    std::string line;
    for (int i = 0; i < 3 && std::getline(in, line); ++i) {
      if (line.rfind("# file:", 0) == 0) return line;
    }
    return "";
  }

  void find_camera(const TumOptions& options) {
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

  void check_camera_size(const cv::Size& size, const std::string& file) const {
    const cv::Size expected(camera_.width_px, camera_.height_px);
    if (expected.width <= 0 || expected.height <= 0 || size == expected) return;
    throw CameraError((folder_ / file).string() + ": is " + text(size) + ", but the camera is for " +
                      text(expected) + "; give another camera file");
  }

  cv::Mat load_depth(const detail::IndexedFrame& frame, const cv::Size& colour_size) const {
    const std::filesystem::path path = folder_ / frame.depth;
    cv::Mat depth = read_image(path, cv::IMREAD_UNCHANGED);
    if (depth.type() != CV_16UC1) throw IoError(path.string() + ": is not a 16-bit depth image");
    if (depth.size() != colour_size) {
      throw IoError(path.string() + ": is " + text(depth.size()) + ", but its colour image " + frame.colour +
                    " is " + text(colour_size));
    }
    return depth;
  }

  cv::Mat load_label_image(const char* kind, std::size_t i) const {
    const std::filesystem::path path = folder_ / kind / (image_name(i) + ".png");
    cv::Mat image = read_image(path, cv::IMREAD_UNCHANGED);
    if (image.type() != CV_8UC1) throw IoError(path.string() + ": is not an 8-bit label image");
    return image;
  }

  static std::string text(const cv::Size& size) {
    return std::to_string(size.width) + "x" + std::to_string(size.height);
  }

  std::filesystem::path folder_;
  std::vector<detail::IndexedFrame> frames_;
  std::vector<std::string> notes_;
  Camera camera_;
  double depth_units_per_m_ = 5000;
};

}  // namespace dynfilter::io
