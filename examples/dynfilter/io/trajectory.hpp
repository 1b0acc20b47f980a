// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/pose.hpp>
#include <filesystem>
#include <vector>

namespace dynfilter::io {

/// A camera pose [m] with its timestamp [s].
struct StampedPose {
  double timestamp_s = 0;
  Pose T_world_camera;
};
using Trajectory = std::vector<StampedPose>;

namespace detail {

using TumNumbers = std::array<double, 8>;  // timestamp, tx ty tz, qx qy qz qw

// Like the TUM tools: NaN or a zero quaternion means no pose.
bool is_pose(const TumNumbers& n);

StampedPose stamped_pose(const TumNumbers& n);

}  // namespace detail

/// Sorts by time. The last of several poses with one timestamp is kept, like in the TUM tools.
Trajectory sorted_by_time(Trajectory trajectory);

/// Irregularities of a trajectory file.
struct TrajectoryOddities {
  std::size_t no_pose = 0;    ///< lines with NaN or an all-zero quaternion
  std::size_t backwards = 0;  ///< timestamps earlier than the one before
  std::size_t repeated = 0;   ///< poses replaced by a later one with the same timestamp
};

/// Reads lines `timestamp[s] tx ty tz[m] qx qy qz qw` and sorts them by time.
/// Separators are blanks, tabs or commas. `#` starts a comment.
/// Lines with NaN or a zero quaternion are skipped, like in the TUM tools.
/// Throws IoError with file and line for other content, and for a file without poses.
Trajectory read_tum_trajectory(const std::filesystem::path& path, TrajectoryOddities& odd);

/// The same without the irregularities.
Trajectory read_tum_trajectory(const std::filesystem::path& path);

/// Writes the TUM format with microseconds and nanometres, and quaternions with qw >= 0.
/// Atomic. Throws IoError.
void write_tum_trajectory(const std::filesystem::path& path, const Trajectory& trajectory);

}  // namespace dynfilter::io
