// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/detectors/image_encoder.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <dynfilter/mapping/mapping_thread.hpp>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/atomic_file.hpp"
#include "io/output_lock.hpp"
#include "io/ply.hpp"
#include "map_picture.hpp"
#include "map_summary.hpp"
#include "running/interruption.hpp"

namespace dynfilter::command {

/// A frame for the map, with deep copies of its data.
struct MapInput {
  std::size_t index = 0;  ///< in the sequence
  bool keyframe = false;
  mapping::MapFrame frame;  ///< without the lists
  std::vector<cv::Point2f> moving_px, still_px;
  std::vector<Detection> detections;

  mapping::MapFrame view() const {
    mapping::MapFrame view = frame;
    view.moving_px = moving_px;
    view.still_px = still_px;
    view.detections = detections;
    return view;
  }
};

/// Throws IoError if a file cannot be created.
inline std::filesystem::path checked_target(const std::filesystem::path& file) {
  const std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  if (!std::filesystem::is_directory(folder)) throw IoError(folder.string() + ": no such folder");
  if (std::filesystem::is_directory(file)) throw IoError(file.string() + ": is a folder");
  Interruption::watch();
  return file;
}

/// Builds the static map of a sequence in its own thread and writes its files.
class MapOutput {
 public:
  /// Throws IoError if `file` cannot be written to its folder, ConfigError for invalid parameters.
  MapOutput(const std::filesystem::path& file, const mapping::MappingParams& params, std::string title)
      : file_(checked_target(file)), lock_(file_), title_(std::move(title)), map_(params, kCapacity) {}

  void add(const MapInput& input) {
    const mapping::MapFrame view = input.view();
    if (!first_) first_ = MapView{view.camera, view.depth.size(), view.T_world_camera};
    if (++waiting_ == kCapacity) {  // files are read faster than real time: waiting avoids dropped frames
      map_.finish();
      waiting_ = 1;
    }
    input.keyframe ? map_.add(view) : map_.observe(view);
  }

  void move(std::int64_t id, const Pose& T_world_camera) { map_.move(id, T_world_camera); }

  /// Waits until all added frames are processed.
  mapping::MapCloud cloud() { return map_.cloud(); }
  mapping::MapSources sources() { return map_.sources(); }

  /// Writes the cloud, and pictures of it from above and from the first camera.
  /// If one cannot be written, none is. Writes nothing for a cloud without points.
  MapSummary write(const mapping::MapCloud& cloud) {
    const mapping::MapState state = map_.state();
    const mapping::MappingThreadStatus status = map_.status();
    if (cloud.size() > 0) write_files(cloud, state.leaf_m);
    MapSummary s;
    s.file = cloud.size() > 0 ? file_.string() : "";
    s.points = cloud.size();
    s.keyframes = status.fused, s.skipped = status.skipped, s.dropped = status.dropped;
    s.full_points = status.left_pixels, s.cut_points = status.pixels - status.left_pixels;
    s.bytes = state.voxel_bytes + state.keyframe_bytes, s.cloud_bytes = cloud.size() * kPointBytes;
    s.leaf_m = state.leaf_m;
    s.ms_per_keyframe = status.fused > 0 ? status.fused_ms / static_cast<double>(status.fused) : NAN;
    s.last_note = status.last_note;
    return s;
  }

 private:
  static constexpr std::size_t kCapacity = 128;
  static constexpr std::size_t kPointBytes = 19;  ///< in the file: three floats, three colours, a class

  void write_files(const mapping::MapCloud& cloud, double leaf_m) const {
    const std::vector<std::uint8_t> picture = picture_of(cloud, leaf_m);
    std::filesystem::path picture_file = file_;
    picture_file.replace_extension(".png");
    io::write_file_atomically(picture_file, [&](std::ostream& out) {
      out.write(reinterpret_cast<const char*>(picture.data()), static_cast<std::streamsize>(picture.size()));
      out.flush();
      if (!out) throw IoError(picture_file.string() + ": writing failed (disk full?)");
      io::write_ply(file_, cloud.points_m, cloud.colours, cloud.classes);
    });
  }

  std::vector<std::uint8_t> picture_of(const mapping::MapCloud& cloud, double leaf_m) const {
    const std::string title = fmt::format("{}   {} points, voxels of {:g} m", title_, cloud.size(), leaf_m);
    const cv::Mat both = draw_map(cloud, leaf_m, *first_, title);
    return io::encode_png(both);
  }

  std::filesystem::path file_;
  io::OutputLock lock_;
  std::string title_;  ///< of the picture
  mapping::MappingThread map_;
  std::size_t waiting_ = 0;  ///< upper bound of the frames in the queue
  std::optional<MapView> first_;
};

}  // namespace dynfilter::command
