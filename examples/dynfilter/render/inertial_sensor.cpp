// SPDX-License-Identifier: MIT
#include "render/inertial_sensor.hpp"

#include <cmath>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/pose.hpp>
#include <ostream>

#include "io/atomic_file.hpp"

namespace dynfilter::render {

namespace detail {

struct NamedGrade {
  const char* name;
  GyroGrade grade;
  GyroNoise noise;
};

// Phone: the white noise is that of the ADIS16448 in EuRoC's sensor.yaml (1.6968e-4). Project Aria's right
// gyroscope has as much (0.01 deg/s/sqrt(Hz)), a BMI160 1.2e-4 (0.007 deg/s/sqrt(Hz)). The walk is EuRoC's
// (1.9393e-5). The first bias is a third of a BMI160's zero-rate offset (3 deg/s).
// Good: a quarter of that white noise, a little above the ADIS16495-1's (0.09 deg/sqrt(h), 2.6e-5). The walk
// is a tenth. The first bias is 0.06 deg/s, as after a calibration at rest.
inline const std::vector<NamedGrade>& grades() {
  static const std::vector<NamedGrade> table{{"none", GyroGrade::None, {0, 0, 0}},
                                             {"exact", GyroGrade::Exact, {0, 0, 0}},
                                             {"phone", GyroGrade::Phone, {2e-4, 2e-5, 0.02}},
                                             {"good", GyroGrade::Good, {1.7e-4 / 4, 2e-6, 0.001}}};
  return table;
}

inline InertialSample sample_at(const CameraPath& path, double time_s) {
  constexpr double kHalf_s = 0.0005;
  const Eigen::Isometry3d T_camera_sensor = T_camera_inertial();
  const Eigen::Isometry3d before = path(time_s - kHalf_s) * T_camera_sensor,
                          now = path(time_s) * T_camera_sensor,
                          after = path(time_s + kHalf_s) * T_camera_sensor;
  const Eigen::Vector3d acceleration_mps2 =
      (after.translation() - 2 * now.translation() + before.translation()) / (kHalf_s * kHalf_s);
  InertialSample sample;
  sample.time_s = time_s;
  sample.omega_radps = rotation_vector(before.linear().transpose() * after.linear()) / (2 * kHalf_s);
  sample.force_mps2 =
      now.linear().transpose() * (acceleration_mps2 + kGravity_mps2 * Eigen::Vector3d::UnitZ());
  return sample;
}

/// One draw per axis, in this order with every compiler.
inline Eigen::Vector3d normal(Random& random, double deviation) {
  Eigen::Vector3d out;
  for (int axis = 0; axis < 3; ++axis) out[axis] = deviation * random.gaussian();
  return out;
}

inline void write_samples(std::ostream& out, const InertialRecord& record) {
  out << "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
         "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
  const std::int64_t first_ns = std::llround(1e9 * record.first_frame_s);
  for (const InertialSample& sample : record.samples) {
    out << first_ns + std::llround(1e9 * (sample.time_s + record.stamps_late_s));
    constexpr int kDigits = 9;
    for (const Eigen::Vector3d& vector : {sample.omega_radps, sample.force_mps2})
      for (const double value : vector) out << ',' << number_text(value, kDigits);
    out << '\n';
  }
}

inline void write_sensor(std::ostream& out, const InertialRecord& record) {
  const auto real = [](double value) { return fixed_text(value, 9); };
  const Eigen::Matrix4d T = T_camera_inertial().matrix();
  out << "# Rendered. The body is the camera, so T_BS is T_camera_imu.\n"
      << "# The stamps are late by " << number_text(1e3 * record.stamps_late_s) << " ms.\n"
      << "sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n  data: [";
  for (int row = 0; row < 4; ++row)
    for (int c = 0; c < 4; ++c)
      out << fixed_text(T(row, c), 3) << (c < 3 ? ", " : row < 3 ? ",\n         " : "]\n");
  out << "rate_hz: " << number_text(kInertialRate_hz) << '\n'
      << "gyroscope_noise_density: " << real(record.noise.density_radps_rthz)
      << "  # [rad/s/sqrt(Hz)]; 0: exact\n"
      << "gyroscope_random_walk: " << real(record.noise.bias_walk_radps2_rthz) << "  # [rad/s^2/sqrt(Hz)]\n"
      << "accelerometer_noise_density: " << real(0) << "  # [m/s^2/sqrt(Hz)]; 0: exact\n"
      << "accelerometer_random_walk: " << real(0) << "  # [m/s^3/sqrt(Hz)]\n";
}

}  // namespace detail

std::vector<std::string> gyro_grade_names() {
  std::vector<std::string> names;
  for (const detail::NamedGrade& grade : detail::grades()) names.emplace_back(grade.name);
  return names;
}

GyroGrade gyro_grade(const std::string& name) {
  for (const detail::NamedGrade& grade : detail::grades())
    if (name == grade.name) return grade.grade;
  throw ConfigError("gyro", "expected none, exact, phone or good, got '" + name + "'");
}

GyroNoise gyro_noise(GyroGrade grade) {
  for (const detail::NamedGrade& named : detail::grades())
    if (grade == named.grade) return named.noise;
  return {};
}

Eigen::Isometry3d T_camera_inertial() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  T.translation() = Eigen::Vector3d(0.03, -0.02, 0.005);
  return T;
}

std::vector<InertialSample> inertial_samples(const CameraPath& path, double first_s, double last_s) {
  std::vector<InertialSample> samples;
  const auto steps = static_cast<int>(std::ceil((last_s - first_s) * kInertialRate_hz - 1e-6));
  for (int i = 0; i <= steps; ++i) samples.push_back(detail::sample_at(path, first_s + i / kInertialRate_hz));
  return samples;
}

void add_gyro_noise(const GyroNoise& noise, Random& random, std::vector<InertialSample>& samples) {
  const double white_radps = noise.density_radps_rthz * std::sqrt(kInertialRate_hz);
  const double walk_radps = noise.bias_walk_radps2_rthz / std::sqrt(kInertialRate_hz);
  Eigen::Vector3d bias_radps = detail::normal(random, noise.first_bias_radps);
  for (InertialSample& sample : samples) {
    sample.omega_radps += bias_radps + detail::normal(random, white_radps);
    bias_radps += detail::normal(random, walk_radps);
  }
}

void write_inertial(const std::filesystem::path& folder, const InertialRecord& record) {
  std::filesystem::create_directory(folder);
  io::write_file_atomically(folder / "data.csv",
                            [&](std::ostream& out) { detail::write_samples(out, record); });
  io::write_file_atomically(folder / "sensor.yaml",
                            [&](std::ostream& out) { detail::write_sensor(out, record); });
}

}  // namespace dynfilter::render
