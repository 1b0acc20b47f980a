// SPDX-License-Identifier: MIT
#include "io/trajectory_formats.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/pose.hpp>
#include <string>
#include <utility>

namespace dynfilter::io {

namespace detail {

/// True for the ground truth of EuRoC, which has 17 columns separated by commas.
/// TUM files may also contain commas, so fewer columns must have stamps in nanoseconds.
inline bool is_euroc(const TextLine& first) {
  const bool nanoseconds = parse_number(first.fields[0]).value_or(0) > 1e14;
  return first.has_commas && (first.fields.size() > 10 || nanoseconds);
}

/// True for stamps in nanoseconds. ORB-SLAM3 writes them into files in TUM's format.
inline bool in_nanoseconds(const Trajectory& trajectory) {
  constexpr double kLeastStep = 1e6;  // 1 ms in nanoseconds; 1e6 s would be eleven days
  std::vector<double> steps;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    steps.push_back(trajectory[i].timestamp_s - trajectory[i - 1].timestamp_s);
  if (steps.empty()) return trajectory[0].timestamp_s > 1e17;
  return median_in_place(steps) >= kLeastStep;
}

inline Trajectory read_kitti(const std::filesystem::path& path, const std::vector<TextLine>& lines,
                             const std::vector<double>& times_s) {
  if (!times_s.empty() && times_s.size() < lines.size())
    throw IoError(path.string() + ": " + std::to_string(lines.size()) + " poses, but only " +
                  std::to_string(times_s.size()) + " times");
  Trajectory trajectory;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (lines[k].fields.size() != 12)
      throw IoError(at_line(path, lines[k].number) + ": expected the 12 numbers of a KITTI pose, found " +
                    std::to_string(lines[k].fields.size()) + " fields");
    const auto n = [&](std::size_t i) { return number_at(lines[k], i, path); };
    StampedPose pose;
    constexpr double kStep_s = 0.1;  // KITTI's 10 Hz
    pose.timestamp_s = times_s.empty() ? kStep_s * static_cast<double>(k) : times_s[k];
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t c = 0; c < 3; ++c) pose.T_world_camera.rotation[3 * row + c] = n(4 * row + c);
      pose.T_world_camera.translation_m[row] = n(4 * row + 3);
    }
    if (!is_rigid(pose.T_world_camera, 0.01))
      throw IoError(at_line(path, lines[k].number) + ": is not a rotation and a translation");
    const Eigen::Quaterniond q(pose.T_world_camera.R());  // files have few digits
    pose.T_world_camera = Pose::from(q.normalized().toRotationMatrix(), pose.T_world_camera.t());
    trajectory.push_back(pose);
  }
  return trajectory;
}

inline Trajectory read_euroc(const std::filesystem::path& path, const std::vector<TextLine>& lines) {
  Trajectory trajectory;
  for (const TextLine& line : lines) {
    if (line.fields.size() < 8)
      throw IoError(at_line(path, line.number) + ": expected 'timestamp[ns],tx,ty,tz,qw,qx,qy,qz', found " +
                    std::to_string(line.fields.size()) + " fields");
    const auto n = [&](std::size_t i) { return number_at(line, i, path); };
    const TumNumbers tum{1e-9 * n(0), n(1), n(2), n(3), n(5), n(6), n(7), n(4)};
    if (is_pose(tum)) trajectory.push_back(stamped_pose(tum));
  }
  return sorted_by_time(std::move(trajectory));
}

}  // namespace detail

std::vector<double> read_times_s(const std::filesystem::path& path) {
  std::vector<double> times_s;
  for (const TextLine& line : read_text_lines(path)) times_s.push_back(number_at(line, 0, path));
  if (times_s.empty()) throw IoError(path.string() + ": contains no time");
  return times_s;
}

TrajectoryFile read_trajectory(const std::filesystem::path& path, std::optional<TrajectoryFormat> format,
                               const std::vector<double>& times_s) {
  const std::vector<TextLine> lines = read_text_lines(path);
  if (lines.empty()) throw IoError(path.string() + ": contains no pose");
  TrajectoryFile file;
  file.format = format.value_or(lines[0].fields.size() == 12 ? TrajectoryFormat::Kitti
                                : detail::is_euroc(lines[0]) ? TrajectoryFormat::Euroc
                                                             : TrajectoryFormat::Tum);
  if (file.format == TrajectoryFormat::Kitti) {
    file.trajectory = detail::read_kitti(path, lines, times_s);
  } else if (file.format == TrajectoryFormat::Euroc) {
    file.trajectory = detail::read_euroc(path, lines);
  } else {
    file.trajectory = read_tum_trajectory(path);
    file.nanoseconds = detail::in_nanoseconds(file.trajectory);
    if (file.nanoseconds)
      for (StampedPose& pose : file.trajectory) pose.timestamp_s *= 1e-9;
  }
  if (file.trajectory.empty()) throw IoError(path.string() + ": contains no pose");
  return file;
}

}  // namespace dynfilter::io
