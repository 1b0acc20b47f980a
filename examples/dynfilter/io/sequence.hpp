// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/sequence_index.hpp"
#include "io/trajectory.hpp"
#include "io/video_stream.hpp"

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
  /// Images are made smaller by this, in (0, 1]. Camera, depth and labels fit the smaller images.
  double scale = 1;
};

/// One loaded frame. The caller owns the images.
struct SequenceFrame {
  double timestamp_s = 0;
  cv::Mat colour;           ///< CV_8UC3, in the order blue, green, red
  cv::Mat grey;             ///< CV_8UC1
  cv::Mat right;            ///< CV_8UC1, rectified, of the right camera; empty: no right image
  cv::Mat depth;            ///< CV_16UC1, 0 for no depth; empty: no depth image
  double depth_unit_m = 0;  ///< metres per unit of `depth`
  double convert_ms = 0;    ///< CPU time for grey, scale and rectification
};

/// A video file, a camera (camera:0), images by a pattern ('frames/*.png'), or a recording as downloaded.
/// A folder tells its layout:
///  - TUM RGB-D or Bonn, with or without associations.txt, and folders written by synth;
///  - KITTI odometry: calib.txt, times.txt, image_0/ and image_1/, or the colour images 2 and 3;
///  - EuRoC or ASL: mav0/cam0 and mav0/cam1 with data.csv and sensor.yaml, rectified when loaded;
///  - any other folder of images: images/, left/ (with right/), or the images themselves, with camera.yaml.
class Sequence {
 public:
  /// Reads the lists, not the images. Of videos and images without a camera it reads the first image.
  /// Throws IoError with one line that names the file. Causes are a missing folder, an unknown layout, and
  /// lists that are missing, empty or out of order. Others are a TUM folder without any depth and an unknown
  /// camera.
  static Sequence open(const std::filesystem::path& folder, const SequenceOptions& options = {});

  /// Of a video what its container counts: read() tells where it ends. Of a camera more than ever come.
  std::size_t size() const { return stream_ ? stream_->size() : index_.frames.size(); }
  /// Of a frame of a video that was not read yet, this is an estimate.
  double timestamp_s(std::size_t i) const {
    return stream_ ? stream_->timestamp_s(i) : index_.frames.at(i).timestamp_s;
  }
  /// Name of the colour image without folder and suffix. Related images have the same name.
  /// Of a video or a camera it is the frame's number, as 000012.
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
  /// What was skipped, with counts, one line each. Of a video so far.
  std::vector<std::string> notes() const;

  /// A video or a camera, whose frames are decoded one after another.
  bool is_stream() const { return stream_ != nullptr; }
  bool is_camera() const { return stream_ && stream_->is_camera(); }
  /// Frames per second that a video or a camera states; 0 of a folder.
  double rate_hz() const { return stream_ ? stream_->rate_hz() : 0; }
  /// No camera was given or found: its focal length is a guess, good for verdicts and not for poses.
  bool camera_is_guessed() const { return camera_is_guessed_; }
  /// Size of the images relative to the stored ones.
  double scale() const { return scale_; }
  cv::Point2f scaled(const cv::Point2f& stored_px) const { return stored_px * static_cast<float>(scale_); }

  /// "rgbd", "stereo" or "mono" if camera.yaml names one, else "".
  const std::string& sensor() const { return sensor_; }
  bool has_depth() const;
  /// True if there are right images, and the camera has a baseline and no distortion.
  bool has_stereo() const;

  /// Loads a frame. Throws IoError with the file name if an image is missing, truncated or invalid.
  /// Depth must be 16 bit, and the sizes must match each other and the camera.
  SequenceFrame load(std::size_t i) const;
  /// The same, but nullopt where a video or a camera ended before this frame.
  std::optional<SequenceFrame> read(std::size_t i) const;

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

  void open_source(const std::filesystem::path& source, const SequenceOptions& options);

  void find_camera(const SequenceOptions& options);
  std::optional<Camera> camera_in_folder(const SequenceOptions& options);
  void guess_camera();
  void apply_scale(double scale);
  cv::Size first_image_size() const;

  SequenceFrame load_files(std::size_t i) const;
  void convert(SequenceFrame& frame) const;

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
  std::shared_ptr<VideoStream> stream_;  ///< null: files
  bool may_guess_camera_ = false, camera_is_guessed_ = false;
  double scale_ = 1;
  cv::Size camera_px_;  ///< size of the stored images that the camera is for; empty: any
};

}  // namespace dynfilter::io
