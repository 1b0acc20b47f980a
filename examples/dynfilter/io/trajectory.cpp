// SPDX-License-Identifier: MIT
#include "io/trajectory.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <ostream>
#include <string>
#include <utility>

#include "io/atomic_file.hpp"

namespace dynfilter::io {

namespace detail {

inline TumNumbers tum_numbers(const TextLine& line, const std::filesystem::path& path) {
  if (line.fields.size() < 8) {
    throw IoError(at_line(path, line.number) + ": expected 'timestamp tx ty tz qx qy qz qw', found " +
                  std::to_string(line.fields.size()) + " fields");
  }
  TumNumbers numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = number_at(line, i, path);
  return numbers;
}

bool is_pose(const TumNumbers& n) {
  return std::all_of(n.begin(), n.end(), [](double v) { return std::isfinite(v); }) &&
         n[4] * n[4] + n[5] * n[5] + n[6] * n[6] + n[7] * n[7] > 1e-12;
}

StampedPose stamped_pose(const TumNumbers& n) {
  const Eigen::Quaterniond q(n[7], n[4], n[5], n[6]);
  return {n[0], Pose::from(q.normalized().toRotationMatrix(), {n[1], n[2], n[3]})};
}

}  // namespace detail

Trajectory sorted_by_time(Trajectory trajectory) {
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.timestamp_s < b.timestamp_s; });
  const auto kept = std::unique(trajectory.rbegin(), trajectory.rend(),
                                [](const auto& a, const auto& b) { return a.timestamp_s == b.timestamp_s; });
  trajectory.erase(trajectory.begin(), kept.base());
  return trajectory;
}

Trajectory read_tum_trajectory(const std::filesystem::path& path, TrajectoryOddities& odd) {
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

Trajectory read_tum_trajectory(const std::filesystem::path& path) {
  TrajectoryOddities unused;
  return read_tum_trajectory(path, unused);
}

void write_tum_trajectory(const std::filesystem::path& path, const Trajectory& trajectory) {
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
