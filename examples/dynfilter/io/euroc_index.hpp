// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/pose.hpp>
#include <filesystem>

#include "io/sequence_index.hpp"

namespace dynfilter::io::detail {

/// True if the folder has mav0/cam0/data.csv or cam0/data.csv.
bool is_euroc_folder(const std::filesystem::path& folder);

/// Reads the lists and sensor.yaml of cam0 and cam1, and where state_groundtruth_estimate0 is.
/// Without cam1 the images are not rectified. Left and right stamps differ by at most `max_gap_s`.
SequenceIndex read_euroc_index(const std::filesystem::path& folder, double max_gap_s);

/// Where the camera of the loaded images is on the body: with cam1 that is the rectified left one.
/// `root` is the folder of cam0. Throws IoError.
Pose read_euroc_T_body_camera(const std::filesystem::path& root);

}  // namespace dynfilter::io::detail
