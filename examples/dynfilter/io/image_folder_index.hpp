// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "io/sequence_index.hpp"

namespace dynfilter::io::detail {

/// True if there are images in left/, in images/ or in the folder itself.
bool is_image_folder(const std::filesystem::path& folder);

/// Reads the names of the images, and right images of the same names in right/ beside left/.
/// Stamps are those of times.txt, one line per image and in seconds. Without it they are the images' names if
/// these are seconds or nanoseconds. Else frames are counted with `rate_hz`, Camera.fps of camera.yaml or
/// 30 Hz, the first that is given.
/// The poses are in groundtruth.txt, in TUM's format.
SequenceIndex read_image_folder_index(const std::filesystem::path& folder, std::optional<double> rate_hz);

/// The images whose names fit a pattern of the shell, as frames/img_*.png. Stamps as above, but times.txt is
/// not read.
/// Throws IoError if none fits, or if the folder's name has wildcards.
SequenceIndex read_image_pattern_index(const std::filesystem::path& pattern, std::optional<double> rate_hz);

}  // namespace dynfilter::io::detail
