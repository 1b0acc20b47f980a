// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

namespace dynfilter::odometry {

/// What the odometry takes from a frame beside the grey image.
enum class Sensor {
  Rgbd,    ///< the depth image
  Stereo,  ///< the right image
  Mono     ///< nothing
};

constexpr const char* to_string(Sensor sensor) {
  return sensor == Sensor::Rgbd ? "rgbd" : sensor == Sensor::Stereo ? "stereo" : "mono";
}

inline std::optional<Sensor> sensor_named(const std::string& name) {
  for (const Sensor sensor : {Sensor::Rgbd, Sensor::Stereo, Sensor::Mono})
    if (name == to_string(sensor)) return sensor;
  return std::nullopt;
}

}  // namespace dynfilter::odometry
