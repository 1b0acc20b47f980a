// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/io/atomic_file.hpp>
#include <dynfilter/io/text_lines.hpp>
#include <filesystem>
#include <ostream>
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

inline TumNumbers tum_numbers(const TextLine& line, const std::filesystem::path& path) {
  if (line.fields.size() < 8) {
    throw IoError(at_line(path, line.number) + ": expected 'timestamp tx ty tz qx qy qz qw', found " +
                  std::to_string(line.fields.size()) + " fields");
  }
  TumNumbers numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = number_at(line, i, path);
  return numbers;
}

// Like the TUM tools: NaN or a zero quaternion means no pose.
inline bool is_pose(const TumNumbers& n) {
  return std::all_of(n.begin(), n.end(), [](double v) { return std::isfinite(v); }) &&
         n[4] * n[4] + n[5] * n[5] + n[6] * n[6] + n[7] * n[7] > 1e-12;
}

inline StampedPose stamped_pose(const TumNumbers& n) {
  const Eigen::Quaterniond q(n[7], n[4], n[5], n[6]);
  return {n[0], Pose::from(q.normalized().toRotationMatrix(), {n[1], n[2], n[3]})};
}

}  // namespace detail

/// Sorts by time. The last of several poses with one timestamp is kept, like in the TUM tools.
inline Trajectory sorted_by_time(Trajectory trajectory) {
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.timestamp_s < b.timestamp_s; });
  const auto kept = std::unique(trajectory.rbegin(), trajectory.rend(),
                                [](const auto& a, const auto& b) { return a.timestamp_s == b.timestamp_s; });
  trajectory.erase(trajectory.begin(), kept.base());
  return trajectory;
}

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
inline Trajectory read_tum_trajectory(const std::filesystem::path& path, TrajectoryOddities& odd) {
  Trajectory trajectory;
  odd = TrajectoryOddities();
  for (const TextLine& line : read_text_lines(path)) {
    const detail::TumNumbers numbers = detail::tum_numbers(line, path);
    if (!detail::is_pose(numbers)) {
      ++odd.no_pose;
      continue;
    }
    odd.backwards += !trajectory.empty() && numbers[0] < trajectory.back().timestamp_s ? 1U : 0U;
    trajectory.push_back(detail::stamped_pose(numbers));
  }
  if (trajectory.empty()) throw IoError(path.string() + ": contains no pose");
  const std::size_t poses = trajectory.size();
  trajectory = sorted_by_time(std::move(trajectory));
  odd.repeated = poses - trajectory.size();
  return trajectory;
}

/// The same without the irregularities.
inline Trajectory read_tum_trajectory(const std::filesystem::path& path) {
  TrajectoryOddities unused;
  return read_tum_trajectory(path, unused);
}

/// Writes the TUM format with microseconds and nanometres, and quaternions with qw >= 0.
/// Atomic. Throws IoError.
inline void write_tum_trajectory(const std::filesystem::path& path, const Trajectory& trajectory) {
  write_file_atomically(path, [&](std::ostream& out) {
    out << "# timestamp tx ty tz qx qy qz qw\n" << std::fixed;
    for (const StampedPose& pose : trajectory) {
      Eigen::Quaterniond q(pose.T_world_camera.R());
      q.normalize();
      if (q.w() < 0) q.coeffs() *= -1;
      const auto& t = pose.T_world_camera.translation_m;
      out.precision(6);
      out << pose.timestamp_s;
      out.precision(9);
      for (const double value : {t[0], t[1], t[2], q.x(), q.y(), q.z(), q.w()}) out << ' ' << value;
      out << '\n';
    }
  });
}

}  // namespace dynfilter::io
