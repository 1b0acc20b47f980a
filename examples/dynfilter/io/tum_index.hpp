// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "io/sequence_index.hpp"

namespace dynfilter::io::detail {

/// True if the folder has one of the lists of a TUM RGB-D recording.
bool is_tum_folder(const std::filesystem::path& folder);

/// Reads associations.txt if it exists, because other systems use it.
/// Otherwise associates rgb.txt and depth.txt.
/// Right images are in `right/`, with the names of the colour images.
SequenceIndex read_tum_index(const std::filesystem::path& folder, double max_gap_s);

}  // namespace dynfilter::io::detail
