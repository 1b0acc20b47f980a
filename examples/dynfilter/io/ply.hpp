// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter::io {

/// Writes a point cloud as binary little-endian PLY, for example for MeshLab or CloudCompare.
/// Points in metres, colours in OpenCV's order (blue, green, red), one class number per point.
/// `colours` and `classes` may be empty; otherwise they have one entry per point.
/// Atomic. Throws IoError, also if the lengths differ.
void write_ply(const std::filesystem::path& path, const std::vector<cv::Point3f>& points_m,
               const std::vector<cv::Vec3b>& colours = {}, const std::vector<int>& classes = {});

}  // namespace dynfilter::io
