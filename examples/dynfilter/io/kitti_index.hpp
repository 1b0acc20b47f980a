// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "io/sequence_index.hpp"

namespace dynfilter::io::detail {

/// True for a sequence of KITTI odometry: calib.txt beside image_0/ or image_2/.
bool is_kitti_folder(const std::filesystem::path& folder);

/// Reads calib.txt and times.txt. Images are image_0/ and image_1/, or else the colour images 2 and 3.
/// The poses are in poses.txt, or where the download has them: ../../poses/NAME.txt.
SequenceIndex read_kitti_index(const std::filesystem::path& folder);

}  // namespace dynfilter::io::detail
