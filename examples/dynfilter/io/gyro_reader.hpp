// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/inertial/gyro_sample.hpp>
#include <filesystem>
#include <optional>

namespace dynfilter::io {

/// Largest file with samples. EuRoC's longest takes 4 MB, an hour at 200 Hz about 80 MB.
inline constexpr std::uintmax_t kMaxGyroBytes = 100'000'000;

/// The gyroscope of a sequence's folder, or nothing if it has none. The first of these files counts:
///  - mav0/imu0/data.csv and imu0/data.csv with sensor.yaml, EuRoC's layout or that of `synth`;
///  - imu.txt, a list as read_gyroscope() reads it.
/// Throws IoError.
std::optional<GyroRecording> find_gyroscope(const std::filesystem::path& folder);

/// Reads lines `timestamp wx wy wz [ax ay az]`: rates in rad/s, separated by blanks, tabs or commas.
/// Stamps are seconds or nanoseconds, which their size and steps tell. They may repeat and go back.
/// `#` starts a comment, and the first line may name the columns.
///
/// A file named data.csv is EuRoC's and has sensor.yaml beside it, whose T_BS takes the sensor to the body.
/// With ../cam0/sensor.yaml R_camera_body leads to the camera of the loaded images, which are rectified if
/// there is cam1. Without it the body is the camera: T_BS is T_camera_imu.
/// Of other files the sensor's axes are the camera's. Noise that no file gives has GyroNoise's defaults.
///
/// Throws IoError with file and line for other content, for numbers that are not finite, for a file without
/// samples and for one above kMaxGyroBytes. TUM's accelerometer.txt is refused: it does not tell the turn.
GyroRecording read_gyroscope(const std::filesystem::path& file);

}  // namespace dynfilter::io
