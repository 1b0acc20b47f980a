// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/sequence_index.hpp>
#include <filesystem>

namespace dynfilter::io::detail {

/// True if there are images in left/, in images/ or in the folder itself.
bool is_image_folder(const std::filesystem::path& folder);

/// Reads the names of the images, and right images of the same names in right/ beside left/.
/// Stamps are those of times.txt, one line per image and in seconds, else the images' names where these
/// are numbers of seconds or nanoseconds, else counted with `rate_hz`, else with Camera.fps of
/// camera.yaml, else with 30 Hz.
/// The poses are in groundtruth.txt, in TUM's format.
SequenceIndex read_image_folder_index(const std::filesystem::path& folder, std::optional<double> rate_hz);

}  // namespace dynfilter::io::detail

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/io/detail/image_folder_index-inl.hpp>
#endif
