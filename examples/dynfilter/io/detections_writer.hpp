// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/detectors/detections.hpp>
#include <filesystem>
#include <vector>

#include "io/detections_writer.hpp"

namespace dynfilter::io {

/// Writes what read_detections() reads, with boxes rounded to 0.001 px.
/// A detection without a class name is written as `object`. Throws IoError.
void write_detections(const std::filesystem::path& path, const std::vector<StampedDetections>& images);

}  // namespace dynfilter::io
