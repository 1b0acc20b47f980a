// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/core/camera.hpp>
#include <filesystem>

#include "io/camera_writer.hpp"

namespace dynfilter::io {

/// Writes what read_camera() reads. cv::FileStorage can read it too. Atomic. Throws IoError.
void write_camera(const std::filesystem::path& path, const CameraFile& file);
void write_camera(const std::filesystem::path& path, const Camera& camera, double depth_units_per_m);

}  // namespace dynfilter::io
