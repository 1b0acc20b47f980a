// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/io/camera_file.hpp>
#include <dynfilter/io/detections.hpp>
#include <dynfilter/io/tum_sequence.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "sequence_run.hpp"

namespace dynfilter::command {

inline io::TumSequence open_sequence(const RunOptions& options) {
  io::TumOptions tum;
  if (!options.camera.empty()) {
    const io::CameraFile file = io::read_camera(options.camera);
    tum.camera = file.camera;
    tum.depth_units_per_m = file.depth_units_per_m;
  }
  return io::TumSequence::open(options.sequence, tum);
}

/// Indices into the sequence in the order in which they are played: turned round first, then cut.
inline std::vector<std::size_t> playing_order(const RunOptions& options, std::size_t size) {
  std::vector<std::size_t> order(size);
  for (std::size_t i = 0; i < size; ++i) order[i] = options.reverse ? size - 1 - i : i;
  if (options.start >= size) {
    throw Error("--start " + std::to_string(options.start) + ": the sequence has only " +
                std::to_string(size) + " frames");
  }
  order.erase(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(options.start));
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
                                                         const io::TumSequence& sequence,
                                                         std::vector<std::string>& notes) {
  std::optional<std::filesystem::path> path;
  if (!options.detections.empty()) path = options.detections;
  if (!path && (path = detections_in(sequence.folder())))
    notes.push_back("boxes from " + path->filename().string());
  if (!path) return std::nullopt;
  io::DetectionTrack track = io::read_detections(*path);
  const std::string name = path->filename().string();
  if (track.unusable > 0) {
    notes.push_back(name + ": " + std::to_string(track.unusable) +
                    (track.unusable == 1 ? " unusable box" : " unusable boxes") +
                    " left out (empty, not finite, or score out of [0, 1])");
  }
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

}  // namespace dynfilter::command
