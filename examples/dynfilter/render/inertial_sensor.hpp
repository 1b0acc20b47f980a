// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <dynfilter/core/random.hpp>
#include <dynfilter/inertial/gyro_sample.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace dynfilter::render {

/// How large a rendered gyroscope's errors are. None: there is no gyroscope.
enum class GyroGrade { None, Exact, Phone, Good };

/// Names that gyro_grade() accepts.
std::vector<std::string> gyro_grade_names();

/// Throws ConfigError for an unknown name.
GyroGrade gyro_grade(const std::string& name);

GyroNoise gyro_noise(GyroGrade grade);

/// A reading without its stamp's delay, in the sensor's axes.
struct InertialSample {
  double time_s = 0;  ///< since frame 0
  Eigen::Vector3d omega_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_mps2 = Eigen::Vector3d::Zero();  ///< acceleration minus gravity: 9.81 up at rest
};

constexpr double kInertialRate_hz = 200;          ///< EuRoC's
constexpr double kGravity_mps2 = 9.81;            ///< along the world's -z
constexpr std::uint64_t kInertialStream = 0x617;  ///< of the random numbers of a seed

/// Where the sensor is on the camera. Its x, y and z axes are the camera's y, z and x: down, ahead, right.
/// This turn of 120 degrees differs from its inverse, so that exchanging both shows.
Eigen::Isometry3d T_camera_inertial();

/// Pose of the camera in the world at a time [s] since frame 0.
using CameraPath = std::function<Eigen::Isometry3d(double)>;

/// What an exact sensor reads from `first_s` to `last_s` or up to one step later.
/// Rates and accelerations are differences over 1 ms of the path, which must be smooth.
std::vector<InertialSample> inertial_samples(const CameraPath& path, double first_s, double last_s);

/// Adds white noise, and a bias that begins anywhere and walks. The forces stay exact.
void add_gyro_noise(const GyroNoise& noise, Random& random, std::vector<InertialSample>& samples);

struct InertialRecord {
  std::vector<InertialSample> samples;
  GyroNoise noise;           ///< only written, not added
  double first_frame_s = 0;  ///< stamp of frame 0
  double stamps_late_s = 0;  ///< delay of the stamps
};

/// Writes data.csv and sensor.yaml in EuRoC's layout into a new folder. T_BS is T_camera_inertial().
/// Throws IoError.
void write_inertial(const std::filesystem::path& folder, const InertialRecord& record);

}  // namespace dynfilter::render
