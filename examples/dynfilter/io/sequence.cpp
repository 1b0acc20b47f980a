// SPDX-License-Identifier: MIT
#include "io/sequence.hpp"
#include "io/cpu_clock.hpp"
#include "io/euroc_index.hpp"
#include "io/image_folder_index.hpp"
#include "io/kitti_index.hpp"
#include "io/known_camera.hpp"
#include "io/sequence_source.hpp"
#include "io/tum_index.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
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

inline void shrink(cv::Mat& image, double scale, int interpolation) {
  if (!image.empty()) cv::resize(image, image, {}, scale, scale, interpolation);
}

}  // namespace detail

Sequence Sequence::open(const std::filesystem::path& source, const SequenceOptions& options) {
  Sequence sequence;
  sequence.folder_ = source;
  sequence.open_source(source, options);
  sequence.find_camera(options);
  sequence.apply_scale(options.scale);
  return sequence;
}

inline void Sequence::open_source(const std::filesystem::path& source, const SequenceOptions& options) {
  may_guess_camera_ = true;
  switch (kind_of_source(source)) {
    case SourceKind::Folder:
      index_ = detail::read_index(source, options);
      may_guess_camera_ = index_.may_guess_camera;
      break;
    case SourceKind::Images:
      folder_ = source.parent_path().empty() ? "." : source.parent_path();
      index_ = detail::read_image_pattern_index(source, options.rate_hz);
      break;
    case SourceKind::Video:
      stream_ = VideoStream::of_file(source);
      break;
    case SourceKind::Camera:
      stream_ = VideoStream::of_camera(camera_address(source));
      break;
  }
}

std::string Sequence::image_name(std::size_t i) const {
  if (!stream_) return std::filesystem::path(index_.frames.at(i).image).stem().string();
  char name[24];
  std::snprintf(name, sizeof name, "%06zu", i);
  return name;
}

std::vector<std::string> Sequence::notes() const {
  std::vector<std::string> notes = index_.notes;
  if (!stream_) return notes;
  for (std::string& note : stream_->notes()) notes.push_back(std::move(note));
  return notes;
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
  std::optional<SequenceFrame> frame = read(i);
  if (!frame) throw IoError(folder_.string() + ": ended before frame " + std::to_string(i));
  return std::move(*frame);
}

std::optional<SequenceFrame> Sequence::read(std::size_t i) const {
  SequenceFrame frame;
  if (stream_) {
    std::optional<TimedImage> image = stream_->read(i);
    if (!image) return std::nullopt;
    check_camera_size(image->colour.size(), image_name(i));
    frame.timestamp_s = image->timestamp_s;
    frame.colour = std::move(image->colour);
    frame.depth_unit_m = 1.0 / depth_units_per_m_;
  } else {
    frame = load_files(i);
  }
  const CpuClock clock = CpuClock::of_thread();
  convert(frame);
  frame.convert_ms = clock.ms();
  return frame;
}

inline SequenceFrame Sequence::load_files(std::size_t i) const {
  const detail::IndexedFrame& frame = index_.frames.at(i);
  SequenceFrame loaded;
  loaded.timestamp_s = frame.timestamp_s;
  loaded.depth_unit_m = 1.0 / depth_units_per_m_;
  loaded.colour = read_image(folder_ / frame.image, ImageAs::Colour,
                             [&](const cv::Size& size) { check_camera_size(size, frame.image); });
  if (!frame.depth.empty()) loaded.depth = load_depth(frame, loaded.colour.size());
  if (!frame.right.empty()) loaded.right = load_right(frame, loaded.colour.size());
  return loaded;
}

inline void Sequence::convert(SequenceFrame& frame) const {
  if (const auto& rectifier = index_.rectifier) {
    frame.colour = rectifier->left(frame.colour);
    if (!frame.right.empty()) frame.right = rectifier->right(frame.right);
  }
  if (scale_ < 1) {
    detail::shrink(frame.colour, scale_, cv::INTER_AREA);
    detail::shrink(frame.right, scale_, cv::INTER_AREA);
    detail::shrink(frame.depth, scale_, cv::INTER_NEAREST);
  }
  cv::cvtColor(frame.colour, frame.grey, cv::COLOR_BGR2GRAY);
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

inline std::optional<Camera> Sequence::camera_in_folder(const SequenceOptions& options) {
  if (options.camera) {
    index_.rectifier.reset();
    return options.camera;
  }
  if (index_.camera) return index_.camera;
  if (stream_) return std::nullopt;
  for (const std::string& name :
       {name_of(folder_), recording_of(folder_ / "groundtruth.txt"), recording_of(folder_ / "rgb.txt")})
    if (const std::optional<Camera> known = known_camera(name)) return known;
  return std::nullopt;
}

inline void Sequence::find_camera(const SequenceOptions& options) {
  std::error_code error;
  const std::filesystem::path file = folder_ / "camera.yaml";
  if (!stream_ && !index_.camera && std::filesystem::is_regular_file(file, error)) {
    const CameraFile read = read_camera(file);
    index_.camera = read.camera;
    sensor_ = read.sensor;
    depth_units_per_m_ = read.depth_units_per_m.value_or(depth_units_per_m_);
  }
  const std::optional<Camera> found = camera_in_folder(options);
  depth_units_per_m_ = options.depth_units_per_m.value_or(depth_units_per_m_);
  if (!found && may_guess_camera_) return guess_camera();
  if (!found || !found->valid()) {
    throw CameraError(folder_.string() +
                      ": the camera is not known: no camera.yaml there, and the folder's name does not " +
                      "say freiburg1, 2, 3 or bonn; give a camera file");
  }
  camera_ = *found;
  camera_px_ = {camera_.width_px, camera_.height_px};
  if (stream_) check_camera_size(stream_->size_px(), "");
}

inline cv::Size Sequence::first_image_size() const {
  if (stream_) return stream_->size_px();
  return read_image(folder_ / index_.frames.at(0).image, ImageAs::Colour).size();
}

// The larger side, in pixels: between 0.8 of it, a phone's, and 1.2, which reconstruction tools assume.
inline void Sequence::guess_camera() {
  constexpr double kFocalOfLargerSide = 1.0;
  const cv::Size size = first_image_size();
  camera_.fx_px = camera_.fy_px = kFocalOfLargerSide * std::max(size.width, size.height);
  camera_.cx_px = 0.5 * (size.width - 1), camera_.cy_px = 0.5 * (size.height - 1);
  camera_.width_px = size.width, camera_.height_px = size.height;
  camera_px_ = size;
  camera_is_guessed_ = true;
  index_.notes.push_back("no camera file: the focal length is guessed as " +
                         std::to_string(std::max(size.width, size.height)) +
                         " pixels, the larger side of the image; --camera gives the true one");
}

inline void Sequence::apply_scale(double scale) {
  constexpr int kMostSide_px = 8192;  // of larger images, one frame takes seconds
  if (!(scale > 0 && scale <= 1))
    throw Error("--scale " + std::to_string(scale) + ": expected above 0, at most 1");
  if (stream_ || scale < 1) {
    const cv::Size size = first_image_size();
    const double side_px = scale * std::max(size.width, size.height);
    if (side_px > kMostSide_px)
      throw IoError(folder_.string() + ": is " + text(size) + ", and at most " +
                    std::to_string(kMostSide_px) +
                    " pixels a side are processed; make it smaller with --scale, as --scale 0.25");
  }
  if (scale == 1) return;
  scale_ = scale;
  camera_.fx_px *= scale, camera_.fy_px *= scale, camera_.baseline_fx_px_m *= scale;
  camera_.cx_px = (camera_.cx_px + 0.5) * scale - 0.5, camera_.cy_px = (camera_.cy_px + 0.5) * scale - 0.5;
  camera_.width_px = cvRound(camera_.width_px * scale),
  camera_.height_px = cvRound(camera_.height_px * scale);
}

inline void Sequence::check_camera_size(const cv::Size& size, const std::string& file) const {
  const cv::Size& expected = camera_px_;
  if (expected.width <= 0 || expected.height <= 0 || size == expected) return;
  throw CameraError((file.empty() ? folder_ : folder_ / file).string() + ": is " + text(size) +
                    ", but the camera is for " + text(expected) + "; give another camera file");
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
  cv::Mat labels = read_label_image(folder_ / kind / (image_name(i) + ".png"));
  if (scale_ < 1) detail::shrink(labels, scale_, cv::INTER_NEAREST);
  return labels;
}

inline std::string Sequence::text(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

}  // namespace dynfilter::io
