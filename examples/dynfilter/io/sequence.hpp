// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/sequence_index.hpp"
#include "io/trajectory.hpp"

namespace dynfilter::io {

/// The camera of a sequence is not known, or does not fit its images: a camera file helps.
class CameraError : public IoError {
 public:
  using IoError::IoError;
};

struct SequenceOptions {
  double max_association_gap_s = 0.02;  ///< largest time difference of the images of one frame
  /// Replaces the camera of the folder. Images are then not rectified.
  std::optional<Camera> camera;
  /// Replaces the value of the folder, which is 5000 by default.
  std::optional<double> depth_units_per_m;
  /// Rate of a folder of images that has no stamps. Replaces Camera.fps of camera.yaml.
  std::optional<double> rate_hz;
};

/// One loaded frame. The caller owns the images.
struct SequenceFrame {
  double timestamp_s = 0;
  cv::Mat colour;           ///< CV_8UC3, in the order blue, green, red
  cv::Mat grey;             ///< CV_8UC1
  cv::Mat right;            ///< CV_8UC1, rectified, of the right camera; empty: no right image
  cv::Mat depth;            ///< CV_16UC1, 0 for no depth; empty: no depth image
  double depth_unit_m = 0;  ///< metres per unit of `depth`
};

/// A recorded sequence as downloaded. The folder tells its layout:
///  - TUM RGB-D or Bonn, with or without associations.txt, and folders written by synth;
///  - KITTI odometry: calib.txt, times.txt, image_0/ and image_1/, or the colour images 2 and 3;
///  - EuRoC or ASL: mav0/cam0 and mav0/cam1 with data.csv and sensor.yaml, rectified when loaded;
///  - any other folder of images: images/, left/ (with right/), or the images themselves, with camera.yaml.
class Sequence {
 public:
  /// Reads the lists, not the images.
  /// Throws IoError with one line that names the file. Causes are a missing folder, an unknown layout, and
  /// lists that are missing, empty or out of order. Others are a TUM folder without any depth and an unknown
  /// camera.
  static Sequence open(const std::filesystem::path& folder, const SequenceOptions& options = {});

  std::size_t size() const { return index_.frames.size(); }
  double timestamp_s(std::size_t i) const { return index_.frames.at(i).timestamp_s; }
  /// Name of the colour image without folder and suffix. Related images have the same name.
  std::string image_name(std::size_t i) const;
  /// File of the colour image, relative to the folder. An image without a file is a PNG of its name.
  std::string image_file(std::size_t i) const {
    return i < index_.frames.size() ? index_.frames[i].image : image_name(i) + ".png";
  }
  /// True if load() returns rectified images, whose pixels are not those of the files.
  bool rectifies() const { return index_.rectifier.has_value(); }
  const Camera& camera() const { return camera_; }
  const std::filesystem::path& folder() const { return folder_; }
  /// Name of the folder itself, also for "." and similar paths.
  std::string name() const { return name_of(folder_); }
  /// What was skipped, with counts, one line each.
  const std::vector<std::string>& notes() const { return index_.notes; }

  /// "rgbd", "stereo" or "mono" if camera.yaml names one, else "".
  const std::string& sensor() const { return sensor_; }
  bool has_depth() const;
  /// True if there are right images, and the camera has a baseline and no distortion.
  bool has_stereo() const;

  /// Loads a frame. Throws IoError with the file name if an image is missing, truncated or invalid.
  /// Depth must be 16 bit, and the sizes must match each other and the camera.
  SequenceFrame load(std::size_t i) const;

  /// Poses of the camera; nullopt if there is no file with them. Throws IoError if it cannot be read.
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

  void find_camera(const SequenceOptions& options);

  void check_camera_size(const cv::Size& size, const std::string& file) const;

  cv::Mat load_right(const detail::IndexedFrame& frame, const cv::Size& left_size) const;

  cv::Mat load_depth(const detail::IndexedFrame& frame, const cv::Size& colour_size) const;

  cv::Mat load_label_image(const char* kind, std::size_t i) const;

  static std::string text(const cv::Size& size);

  std::filesystem::path folder_;
  detail::SequenceIndex index_;
  Camera camera_;
  std::string sensor_;
  double depth_units_per_m_ = 5000;
};

}  // namespace dynfilter::io
