// SPDX-License-Identifier: MIT
// Every reader of one file. The first line names the reader, the rest is the file.
// What is read is written and read again where there is a writer.
#include <unistd.h>
#include <cmath>
#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/detectors/class_list.hpp>
#include <dynfilter/detectors/detections.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/recorder/recording.hpp>
#include <filesystem>

#include "io/association.hpp"
#include "io/camera_writer.hpp"
#include "io/detections_writer.hpp"
#include "io/point_tracks.hpp"
#include "io/pose_lookup.hpp"
#include "io/trajectory.hpp"
#include "io/trajectory_formats.hpp"
#include "memory_file.hpp"
#include "record_file.hpp"
#include "support/allocated_bytes.hpp"
#include "target.hpp"

namespace {

using namespace dynfilter;
using fuzz::require;
namespace fs = std::filesystem;

/// Where writers, which replace a file as a whole, may write.
const fs::path& scratch() {
  struct Folder {
    fs::path path = fs::temp_directory_path() / ("dynfilter_fuzz_" + std::to_string(::getpid()));
    Folder() { fs::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      fs::remove_all(path, ignored);
    }
  };
  static const Folder folder;
  return folder.path;
}

void read_poses(const std::string& path, std::optional<io::TrajectoryFormat> format) {
  const io::Trajectory poses = io::read_trajectory(path, format).trajectory;
  require(!poses.empty(), "a trajectory that is read has a pose");
  std::vector<double> stamps;
  for (const io::StampedPose& pose : poses) {
    require(std::isfinite(pose.timestamp_s), "stamps are finite");
    require(stamps.empty() || pose.timestamp_s > stamps.back(), "stamps ascend");
    stamps.push_back(pose.timestamp_s);
  }
  for (const auto& [a, b] : io::associate(stamps, stamps, 0.02))
    require(a == b, "a stamp is nearest to itself");
  const fs::path copy = scratch() / "poses.txt";
  io::write_tum_trajectory(copy, poses);
  io::read_tum_trajectory(copy);
}

void read_boxes(const std::string& path) {
  const io::DetectionTrack track = io::read_detections(path);
  for (const io::StampedDetections& image : track.images) {
    require(image.detections.size() <= limits::kMaxBoxes, "boxes per frame have a limit");
    for (const Detection& d : image.detections)
      require(io::detail::usable(d), "boxes that are read can be used");
    require(track.at(image.timestamp_s) != nullptr, "an image with boxes is found by its stamp");
  }
  const fs::path copy = scratch() / "boxes.txt";
  io::write_detections(copy, track.images);
  io::read_detections(copy);
}

void read_tracks(const std::string& path) {
  const io::PointTracks tracks = io::read_point_tracks(path);
  const auto points = static_cast<std::size_t>(tracks.points),
             frames = static_cast<std::size_t>(tracks.frames);
  require(tracks.label.size() == points && tracks.px.size() == points * frames,
          "tracks are as large as they say");
  for (int p = 0; p < tracks.points; ++p) {
    const int last = tracks.last_visible(p);
    require(last < tracks.frames && (last < 0 || tracks.visible(p, last)),
            "a point is visible where it is last");
  }
  io::widest_label(tracks);
}

void read_camera(const std::string& path) {
  const io::CameraFile camera = io::read_camera(path);
  const fs::path copy = scratch() / "camera.yaml";
  io::write_camera(copy, camera);
  require(io::read_camera(copy).camera == camera.camera, "a camera that is written is read again");
}

/// Buffers of the file's stream and texts.
constexpr std::size_t kReaderBytes = 100'000;
/// Larger images are refused here only to keep the fuzzer quick.
constexpr int kMostPixels = 100'000;

/// Memory is within the bound that is documented, whether the image is read or refused.
void read_picture(const std::string& path, std::size_t file_bytes, io::ImageAs as) {
  cv::Size told;
  const dynfilter_test::AllocatedBytes allocated;
  const auto check_memory = [&] {
    const std::size_t pixels = told.area() > kMostPixels ? 0 : static_cast<std::size_t>(told.area());
    require(allocated.bytes() <= kReaderBytes + file_bytes + io::detail::kMaxDecodingBytes +
                                     pixels * io::detail::kMaxDecodingBytesPerPixel,
            "an image takes no more memory than its size allows");
  };
  try {
    const cv::Mat image = io::read_image(path, as, [&](const cv::Size& size) {
      told = size;
      require(size.width <= limits::kMaxImageSide_px && size.height <= limits::kMaxImageSide_px &&
                  std::int64_t{size.width} * size.height <= limits::kMaxImagePixels,
              "a size that is told is within the limits");
      if (size.area() > kMostPixels) throw IoError("too large for the fuzzer");
    });
    require(image.size() == told, "an image has the size that was told before it was decoded");
    require(image.type() == CV_8UC3 || as == io::ImageAs::Stored,
            "a colour image is of 8 bits and 3 channels");
  } catch (const IoError&) {
    check_memory();
    throw;
  }
  check_memory();
}

/// In both forms, whether or not the first can be read.
void read_pictures(const std::string& path, std::size_t file_bytes) {
  try {
    read_picture(path, file_bytes, io::ImageAs::Stored);
  } catch (const IoError& error) {
    fuzz::require_one_line(error.what());
  }
  read_picture(path, file_bytes, io::ImageAs::Colour);
}

/// LZ4 expands its bytes 255 times at most. Lists of the host's own types are larger than what is written.
constexpr std::size_t kMostExpansion = 255, kMostListExpansion = 8;

/// Every event of a recording, through a pipeline: what a file holds is as odd as any host's frame.
void replay(const std::string& path, std::size_t file_bytes) {
  std::vector<KeyframeView> keyframes;
  Pipeline pipeline(
      pipeline_from_text("pipeline: { before_pose: [ semantic_box, flow_consistency ] }", builtin_filters()));
  std::size_t events = 0;
  std::optional<recorder::RecordingReader> reader;
  {
    const dynfilter_test::AllocatedBytes allocated;
    reader.emplace(path);
    require(allocated.bytes() <= kReaderBytes + kMostListExpansion * kMostExpansion * file_bytes,
            "the places of the records take no more memory than the file allows");
  }
  for (;;) {
    std::optional<recorder::RecordedEvent> event;
    {
      const dynfilter_test::AllocatedBytes allocated;
      event = reader->next();
      require(allocated.bytes() <= kReaderBytes + kMostListExpansion * kMostExpansion * file_bytes,
              "an event takes no more memory than the file allows");
    }
    if (!event) break;
    require(++events <= file_bytes / sizeof(recorder::RecordHeader), "an event has a record");
    if (event->kind != recorder::RecordedEvent::Kind::Frame) continue;
    pipeline.process(event->frame.view(keyframes), event->point, event->limits);
    if (event->verdict) recorder::difference(*event->verdict, *event->verdict);
  }
  require(events >= reader->calls(), "each call is an event");
}

/// Records of these contents, whose checksums are right: a kind, the content's length and the content each.
void replay_records(const std::string& text) {
  const fs::path path = scratch() / "records.dfr";
  {
    recorder::RecordFile file(path.string(), std::uint64_t{1} << 30U);
    std::uint64_t call = 1;
    for (std::size_t at = 0; at + 3 <= text.size();) {
      const auto byte = [&](std::size_t k) { return static_cast<std::uint8_t>(text[at + k]); };
      const std::size_t size = std::min<std::size_t>(byte(1) + 256U * byte(2), text.size() - at - 3);
      recorder::RecordBuffer buffer;
      buffer.raw.assign(text.data() + at + 3, text.data() + at + 3 + size);
      const auto kind = static_cast<recorder::RecordKind>(1 + byte(0) % recorder::kRecordKinds);
      file.append(kind, call, buffer);
      call += kind == recorder::RecordKind::Verdict ? 1 : 0;
      at += 3 + size;
    }
  }
  replay(path.string(), fs::file_size(path));
}

void read(const std::string& kind, const std::string& path, std::size_t file_bytes) {
  if (kind == "recording") replay(path, file_bytes);
  if (kind == "poses") read_poses(path, std::nullopt);
  if (kind == "tum") read_poses(path, io::TrajectoryFormat::Tum);
  if (kind == "kitti") read_poses(path, io::TrajectoryFormat::Kitti);
  if (kind == "euroc") read_poses(path, io::TrajectoryFormat::Euroc);
  if (kind == "times") io::read_times_s(path);
  if (kind == "boxes") read_boxes(path);
  if (kind == "tracks") read_tracks(path);
  if (kind == "camera") read_camera(path);
  if (kind == "classes") ClassList(ClassList::from_file(path), 0, {});
  if (kind == "image") read_pictures(path, file_bytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string input(reinterpret_cast<const char*>(data), size);
  const std::size_t end = input.find('\n');
  if (end == std::string::npos) return 0;
  const fuzz::MemoryFile file(input.substr(end + 1));
  try {
    if (input.substr(0, end) == "records") replay_records(input.substr(end + 1));
    read(input.substr(0, end), file.path(), size);
  } catch (const Error& error) {
    fuzz::require_one_line(error.what());
  }
  return 0;
}
