// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

namespace dynfilter {

/// One reading of a gyroscope.
struct GyroSample {
  double timestamp_s = 0;                                 ///< of the clock of the images
  Eigen::Vector3d omega_radps = Eigen::Vector3d::Zero();  ///< rate of turn about the sensor's own axes
};

/// What a gyroscope's data sheet, or Kalibr, says of its errors.
struct GyroNoise {
  double density_radps_rthz = 0.002;    ///< white noise per square root of the bandwidth [rad/s/sqrt(Hz)]
  double bias_walk_radps2_rthz = 2e-4;  ///< random walk of the bias [rad/s^2/sqrt(Hz)]
  double first_bias_radps = 0.02;       ///< standard deviation of the bias before any was measured
};

/// A recording's gyroscope.
struct GyroRecording {
  std::vector<GyroSample> samples;
  Eigen::Matrix3d R_camera_body = Eigen::Matrix3d::Identity();  ///< takes the sensor's axes to the camera's
  GyroNoise noise;
};

}  // namespace dynfilter
