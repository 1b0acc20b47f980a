// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/rectifier.hpp"
#include "io/trajectory_formats.hpp"

/// Where the frames of a sequence are, without the images. One reader per layout.
namespace dynfilter::io::detail {

/// Files relative to the sequence's folder.
struct IndexedFrame {
  double timestamp_s = 0;
  std::string image;         // colour or grey; of a stereo camera the left one
  std::string right, depth;  // empty: none
};

struct SequenceIndex {
  std::vector<IndexedFrame> frames;
  std::vector<std::string> notes;
  std::optional<Camera> camera;
  std::optional<double> depth_units_per_m;
  bool may_guess_camera = false;  // images without depth need a camera for poses only
  std::optional<Rectifier> rectifier;
  std::filesystem::path poses;       // the ground truth; empty: none
  std::vector<double> pose_times_s;  // of KITTI's poses
  std::optional<TrajectoryFormat> pose_format;
  Pose T_body_camera;  // the poses are those of the body
};

std::string counted(std::size_t n, const std::string& one, const std::string& many);

/// A timestamp in a list. Throws IoError with file and line.
double stamp_of(const TextLine& line, std::size_t field, const std::filesystem::path& path);

/// False for a repeated timestamp, which the caller skips. Throws IoError for an earlier one.
bool comes_later(double timestamp_s, double last_s, const TextLine& line, const std::filesystem::path& path);

/// Names of the images in a folder; empty if it does not exist. Numbers in them sort as numbers: 2.png is
/// before 10.png.
std::vector<std::string> images_in(const std::filesystem::path& folder);

/// Gives each frame the image of the same name in the folder `right`, and notes how many have none.
void add_right_images(const std::filesystem::path& folder, SequenceIndex& index);

}  // namespace dynfilter::io::detail
