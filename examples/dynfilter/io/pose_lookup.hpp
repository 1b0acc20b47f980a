// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/pose.hpp>
#include <optional>
#include <utility>

#include "io/trajectory.hpp"

namespace dynfilter::io {

/// Interpolates a trajectory at any time.
class PoseLookup {
 public:
  /// Requires a trajectory sorted by time without duplicates (sorted_by_time).
  /// Gaps longer than `max_gap_s` are not interpolated.
  explicit PoseLookup(Trajectory trajectory, double max_gap_s = 0.12)
      : trajectory_(std::move(trajectory)), max_gap_s_(max_gap_s) {}

  /// The pose with this timestamp, within half a millisecond.
  /// Otherwise interpolates between the neighbouring poses:
  /// the position linearly, the rotation at constant speed.
  /// Nothing outside the trajectory and inside gaps.
  std::optional<Pose> at(double timestamp_s) const;

  /// Number of gaps, and the longest one [s].
  std::pair<std::size_t, double> gaps() const;

 private:
  static constexpr double kSameS = 5e-4;
  Trajectory trajectory_;
  double max_gap_s_;
};

/// Rigid motion that maps the poses of one trajectory to those of another.
/// It averages rotations as well as positions.
/// It is therefore also valid for a static camera, unlike an alignment of positions.
/// Poses are paired by timestamp. Nothing without a pair.
std::optional<Pose> align_poses(const Trajectory& to, const Trajectory& from);

}  // namespace dynfilter::io
