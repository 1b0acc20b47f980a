// SPDX-License-Identifier: MIT
#include "io/sequence.hpp"
#include "io/euroc_index.hpp"
#include "io/image_folder_index.hpp"
#include "io/kitti_index.hpp"
#include "io/known_camera.hpp"
#include "io/tum_index.hpp"

#include <algorithm>
#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>
#include <utility>

namespace dynfilter::io {

namespace detail {

inline SequenceIndex read_index(const std::filesystem::path& folder, const SequenceOptions& options) {
  if (is_tum_folder(folder)) return read_tum_index(folder, options.max_association_gap_s);
  if (is_kitti_folder(folder)) return read_kitti_index(folder);
  if (is_euroc_folder(folder)) return read_euroc_index(folder, options.max_association_gap_s);
  if (is_image_folder(folder)) return read_image_folder_index(folder, options.rate_hz);
  throw IoError(
      folder.string() +
      ": is no sequence: no rgb.txt (TUM), no calib.txt with image_0/ (KITTI), no mav0/cam0/data.csv "
      "(EuRoC) and no images");
}

}  // namespace detail

Sequence Sequence::open(const std::filesystem::path& folder, const SequenceOptions& options) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) throw IoError(folder.string() + ": no such folder");
  Sequence sequence;
  sequence.folder_ = folder;
  sequence.index_ = detail::read_index(folder, options);
  sequence.find_camera(options);
  return sequence;
}

std::string Sequence::image_name(std::size_t i) const {
  return std::filesystem::path(index_.frames.at(i).image).stem().string();
}

bool Sequence::has_depth() const {
  return std::any_of(index_.frames.begin(), index_.frames.end(),
                     [](const detail::IndexedFrame& frame) { return !frame.depth.empty(); });
}

bool Sequence::has_stereo() const {
  return camera_.baseline_fx_px_m > 0 && !camera_.distorted() &&
         std::any_of(index_.frames.begin(), index_.frames.end(),
                     [](const detail::IndexedFrame& frame) { return !frame.right.empty(); });
}

SequenceFrame Sequence::load(std::size_t i) const {
  const detail::IndexedFrame& frame = index_.frames.at(i);
  const auto& rectifier = index_.rectifier;
  SequenceFrame loaded;
  loaded.timestamp_s = frame.timestamp_s;
  loaded.depth_unit_m = 1.0 / depth_units_per_m_;
  loaded.colour = read_image(folder_ / frame.image, ImageAs::Colour,
                             [&](const cv::Size& size) { check_camera_size(size, frame.image); });
  if (rectifier) loaded.colour = rectifier->left(loaded.colour);
  cv::cvtColor(loaded.colour, loaded.grey, cv::COLOR_BGR2GRAY);
  if (!frame.depth.empty()) loaded.depth = load_depth(frame, loaded.colour.size());
  if (frame.right.empty()) return loaded;
  loaded.right = load_right(frame, loaded.grey.size());
  if (rectifier) loaded.right = rectifier->right(loaded.right);
  return loaded;
}

std::optional<Trajectory> Sequence::ground_truth() const {
  std::error_code error;
  if (!std::filesystem::is_regular_file(index_.poses, error)) return std::nullopt;
  Trajectory poses = read_trajectory(index_.poses, index_.pose_format, index_.pose_times_s).trajectory;
  for (StampedPose& pose : poses) pose.T_world_camera = pose.T_world_camera * index_.T_body_camera;
  return poses;
}

bool Sequence::has_labels() const {
  std::error_code error;
  return std::filesystem::is_directory(folder_ / "labels", error) &&
         std::filesystem::is_directory(folder_ / "dynamic", error);
}

std::string Sequence::name_of(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(folder, error);
  const std::filesystem::path& path = error ? folder : whole;
  return path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
}

inline std::string Sequence::recording_of(const std::filesystem::path& list) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(list, error)) return "";
  LineReader reader(list);
  for (std::string line; reader.number() < 3 && reader.next(line);)
    if (line.rfind("# file:", 0) == 0) return line;
  return "";
}

inline void Sequence::find_camera(const SequenceOptions& options) {
  std::error_code error;
  const std::filesystem::path file = folder_ / "camera.yaml";
  std::optional<Camera> found = index_.camera;
  if (!found && std::filesystem::is_regular_file(file, error)) {
    const CameraFile read = read_camera(file);
    found = read.camera;
    sensor_ = read.sensor;
    depth_units_per_m_ = read.depth_units_per_m.value_or(depth_units_per_m_);
  }
  for (const std::string& name :
       {name_of(folder_), recording_of(folder_ / "groundtruth.txt"), recording_of(folder_ / "rgb.txt")}) {
    if (!found) found = known_camera(name);
  }
  if (options.camera) {
    found = options.camera;
    index_.rectifier.reset();
  }
  if (!found || !found->valid()) {
    throw CameraError(folder_.string() +
                      ": the camera is not known: no camera.yaml there, and the folder's name does not " +
                      "say freiburg1, 2, 3 or bonn; give a camera file");
  }
  camera_ = *found;
  depth_units_per_m_ = options.depth_units_per_m.value_or(depth_units_per_m_);
}

inline void Sequence::check_camera_size(const cv::Size& size, const std::string& file) const {
  const cv::Size expected(camera_.width_px, camera_.height_px);
  if (expected.width <= 0 || expected.height <= 0 || size == expected) return;
  throw CameraError((folder_ / file).string() + ": is " + text(size) + ", but the camera is for " +
                    text(expected) + "; give another camera file");
}

inline cv::Mat Sequence::load_right(const detail::IndexedFrame& frame, const cv::Size& left_size) const {
  const std::filesystem::path path = folder_ / frame.right;
  cv::Mat grey;
  const auto check = [&](const cv::Size& size) {
    if (size == left_size) return;
    throw IoError(path.string() + ": is " + text(size) + ", but its left image " + frame.image + " is " +
                  text(left_size));
  };
  cv::cvtColor(read_image(path, ImageAs::Colour, check), grey, cv::COLOR_BGR2GRAY);
  return grey;
}

inline cv::Mat Sequence::load_depth(const detail::IndexedFrame& frame, const cv::Size& colour_size) const {
  const std::filesystem::path path = folder_ / frame.depth;
  const auto check = [&](const cv::Size& size) {
    if (size == colour_size) return;
    throw IoError(path.string() + ": is " + text(size) + ", but its colour image " + frame.image + " is " +
                  text(colour_size));
  };
  cv::Mat depth = read_image(path, ImageAs::Stored, check);
  if (depth.type() != CV_16UC1) throw IoError(path.string() + ": is not a 16-bit depth image");
  return depth;
}

cv::Mat Sequence::load_label_image(const char* kind, std::size_t i) const {
  return read_label_image(folder_ / kind / (image_name(i) + ".png"));
}

inline std::string Sequence::text(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

}  // namespace dynfilter::io
