// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/io/trajectory.hpp>
#include <dynfilter/io/tum_index.hpp>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
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
  static TumSequence open(const std::filesystem::path& folder, const TumOptions& options = {});

  std::size_t size() const { return frames_.size(); }
  double timestamp_s(std::size_t i) const { return frames_.at(i).timestamp_s; }
  /// Name of the colour image without folder and suffix. Related images have the same name.
  std::string image_name(std::size_t i) const;
  const Camera& camera() const { return camera_; }
  const std::filesystem::path& folder() const { return folder_; }
  /// Name of the folder itself, also for "." and similar paths.
  std::string name() const { return name_of(folder_); }
  /// What was skipped, with counts, one line each.
  const std::vector<std::string>& notes() const { return notes_; }

  /// Loads a frame. Throws IoError with the file name if an image is missing, truncated or invalid.
  /// Depth must be 16 bit, and the sizes must match each other and the camera.
  RgbdFrame load(std::size_t i) const;

  /// Reads groundtruth.txt; nullopt if it does not exist. Throws IoError if it cannot be read.
  std::optional<Trajectory> ground_truth() const;

  /// True for synthetic sequences, which have labels/ and dynamic/.
  bool has_labels() const;
  /// CV_8UC1: 0 static, 255 dynamic, 128 don't care (slow motion or near a silhouette).
  /// Throws IoError.
  cv::Mat load_truth(std::size_t i) const { return load_label_image("dynamic", i); }
  /// CV_8UC1: 0 static, k = mover k, moving or not. Throws IoError.
  cv::Mat load_labels(std::size_t i) const { return load_label_image("labels", i); }

 private:
  static std::string name_of(const std::filesystem::path& folder);

  // The TUM lists name the recording in a comment, which remains valid if the folder is renamed.
  static std::string recording_of(const std::filesystem::path& list);

  void find_camera(const TumOptions& options);

  void check_camera_size(const cv::Size& size, const std::string& file) const;

  cv::Mat load_depth(const detail::IndexedFrame& frame, const cv::Size& colour_size) const;

  cv::Mat load_label_image(const char* kind, std::size_t i) const;

  static std::string text(const cv::Size& size);

  std::filesystem::path folder_;
  std::vector<detail::IndexedFrame> frames_;
  std::vector<std::string> notes_;
  Camera camera_;
  double depth_units_per_m_ = 5000;
};

}  // namespace dynfilter::io

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/io/detail/tum_sequence-inl.hpp>
#endif
