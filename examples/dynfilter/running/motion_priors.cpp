// SPDX-License-Identifier: MIT
#include "motion_priors.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <utility>

#include "given_poses.hpp"
#include "io/gyro_reader.hpp"
#include "io/trajectory.hpp"

namespace dynfilter::command {

namespace {

GyroRecording recording_of(const RunOptions& options) {
  if (options.imu != "auto") return io::read_gyroscope(options.imu);
  std::optional<GyroRecording> found = io::find_gyroscope(options.sequence);
  if (!found)
    throw IoError(options.sequence +
                  ": has neither imu0/data.csv nor imu.txt: give the gyroscope's file instead of `auto`");
  return std::move(*found);
}

// Wheels slip: 2 % of the way and 2 mm, 2 % of the turn and 0.1 degrees, from frame to frame.
constexpr double kSlip = 0.02, kLeast_m = 0.002, kLeast_rad = 0.1 * M_PI / 180;

}  // namespace

MotionPriors::MotionPriors(const RunOptions& options, std::vector<std::string>& notes) {
  if (!options.imu.empty()) {
    const GyroRecording recording = recording_of(options);
    gyroscope_.emplace(Gyroscope::Options{recording.R_camera_body, recording.noise, HUGE_VAL});
    for (const GyroSample& sample : recording.samples) gyroscope_->add(sample);
  }
  if (options.wheel_odometry.empty()) return;
  io::TrajectoryOddities odd;
  wheels_.emplace(io::read_tum_trajectory(options.wheel_odometry, odd), options.max_gap_s);
  for (std::string& note : notes_of(odd, options.wheel_odometry)) notes.push_back(std::move(note));
}

std::optional<MotionPrior> MotionPriors::next(double stamp_s) {
  last_s_ = std::exchange(now_s_, stamp_s);
  if (!last_s_) return std::nullopt;
  const std::optional<MotionPrior> wheels = by_wheels(*last_s_, stamp_s);
  return wheels ? wheels : by_gyroscope(*last_s_, stamp_s);
}

std::optional<MotionPrior> MotionPriors::by_gyroscope(double from_s, double to_s) const {
  if (!gyroscope_) return std::nullopt;
  if (from_s < to_s) return gyroscope_->prior(from_s, to_s);
  std::optional<MotionPrior> back = gyroscope_->prior(to_s, from_s);
  if (back) back->T_current_reference = inverse(back->T_current_reference);
  return back;
}

std::optional<MotionPrior> MotionPriors::by_wheels(double from_s, double to_s) const {
  if (!wheels_) return std::nullopt;
  const std::optional<Pose> from = wheels_->at(from_s), to = wheels_->at(to_s);
  if (!from || !to) return std::nullopt;
  MotionPrior prior;
  prior.T_current_reference = inverse(*to) * *from;
  prior.has_translation = true;
  const double way_m = kLeast_m + kSlip * prior.T_current_reference.t().norm(),
               turn_rad = kLeast_rad + kSlip * rotation_vector(prior.T_current_reference.R()).norm();
  for (std::size_t k = 0; k < 6; ++k) prior.covariance[7 * k] = k < 3 ? way_m * way_m : turn_rad * turn_rad;
  return prior;
}

void MotionPriors::tracked(const std::optional<Pose>& T_world_camera) {
  const std::optional<Pose> last = std::exchange(last_pose_, T_world_camera);
  if (!gyroscope_ || !last || !T_world_camera || !last_s_) return;
  const Eigen::Matrix3d R = (inverse(*T_world_camera) * *last).R();
  if (*last_s_ < *now_s_)
    gyroscope_->observe(*last_s_, *now_s_, R);
  else
    gyroscope_->observe(*now_s_, *last_s_, R.transpose());
}

std::string MotionPriors::summary() const {
  if (!gyroscope_) return "";
  if (!gyroscope_->axes_fit())
    return "gyroscope: not used, other axes than the given ones fit the camera's turns far better";
  const Eigen::Vector3d bias = gyroscope_->bias_radps() * (180 / M_PI);
  return fmt::format("gyroscope: bias {:.2f} {:.2f} {:.2f} deg/s, clock {:.1f} ms late", bias.x(), bias.y(),
                     bias.z(), 1000 * gyroscope_->offset_s());
}

}  // namespace dynfilter::command
