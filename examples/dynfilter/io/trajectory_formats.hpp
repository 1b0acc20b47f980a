// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <optional>
#include <vector>

#include "io/trajectory.hpp"

namespace dynfilter::io {

enum class TrajectoryFormat {
  Tum,    ///< timestamp tx ty tz qx qy qz qw
  Kitti,  ///< the 12 numbers of a 3x4 matrix, row by row, one line per frame
  Euroc   ///< timestamp [ns], tx, ty, tz, qw, qx, qy, qz, ...: ground truth of the EuRoC MAV data set
};

struct TrajectoryFile {
  Trajectory trajectory;
  TrajectoryFormat format = TrajectoryFormat::Tum;
  bool nanoseconds = false;  ///< a TUM file with stamps in nanoseconds, converted to seconds
};

/// Reads one number per line, like KITTI's times.txt. Throws IoError.
std::vector<double> read_times_s(const std::filesystem::path& path);

/// Reads a trajectory, sorted by time. Without `format`, the first line decides:
/// 12 fields are KITTI; commas with more than 10 fields or with nanoseconds are EuRoC; all else is TUM.
/// `times_s`: stamps of KITTI's lines; empty: 10 Hz from 0 s. Throws IoError with file and line.
TrajectoryFile read_trajectory(const std::filesystem::path& path,
                               std::optional<TrajectoryFormat> format = std::nullopt,
                               const std::vector<double>& times_s = {});

}  // namespace dynfilter::io
