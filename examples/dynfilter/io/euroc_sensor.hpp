// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/pose.hpp>
#include <dynfilter/inertial/gyro_sample.hpp>
#include <filesystem>

#include "io/rectifier.hpp"

namespace dynfilter::io::detail {

/// Reads sensor.yaml of a camera in EuRoC's layout. Throws IoError.
RigCamera read_euroc_sensor(const std::filesystem::path& path);

/// A gyroscope of a rig. `noise` has the defaults for what the file does not say, or says to be 0.
struct RigGyroscope {
  Pose T_body_sensor;
  GyroNoise noise;
};

/// Reads sensor.yaml of an inertial sensor in EuRoC's layout. Throws IoError.
RigGyroscope read_euroc_gyroscope(const std::filesystem::path& path);

}  // namespace dynfilter::io::detail
