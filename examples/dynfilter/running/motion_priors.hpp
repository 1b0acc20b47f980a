// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/pose.hpp>
#include <dynfilter/inertial/gyroscope.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/pose_lookup.hpp"
#include "sequence_run.hpp"

namespace dynfilter::command {

/// What a recording's gyroscope or wheel odometry says of the camera's motion from frame to frame. Stamps are
/// the recording's own, also where it is played in reverse: a gyroscope tells a turn both ways.
class MotionPriors {
 public:
  /// Reads the files of --imu and --wheel-odometry. Throws IoError.
  MotionPriors(const RunOptions& options, std::vector<std::string>& notes);

  /// Since the last frame. None without sensors, and where they do not cover the time.
  std::optional<MotionPrior> next(double stamp_s);
  /// The pose of the frame of next(), if it was tracked: the gyroscope's bias and clock are learned from it.
  void tracked(const std::optional<Pose>& T_world_camera);
  /// What was learned of the gyroscope, for people. Empty: there is none.
  std::string summary() const;

 private:
  std::optional<MotionPrior> by_gyroscope(double from_s, double to_s) const;
  std::optional<MotionPrior> by_wheels(double from_s, double to_s) const;

  std::optional<Gyroscope> gyroscope_;
  std::optional<io::PoseLookup> wheels_;
  std::optional<double> last_s_, now_s_;
  std::optional<Pose> last_pose_;
};

}  // namespace dynfilter::command
