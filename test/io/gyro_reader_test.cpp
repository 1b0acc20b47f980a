// SPDX-License-Identifier: MIT
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/pose.hpp>
#include <filesystem>
#include <sstream>
#include <string>

#include "doctest/doctest.h"
#include "io/euroc_index.hpp"
#include "io/gyro_reader.hpp"
#include "io/tum_folder.hpp"

namespace gyro_reader_test {

using namespace dynfilter;
using namespace dynfilter_test;
using Eigen::Matrix3d;
using Eigen::Vector3d;
namespace fs = std::filesystem;

namespace {

const std::string kHeader = "#timestamp [ns],w_RS_S_x [rad s^-1],w_y,w_z,a_x,a_y,a_z\n";
const std::string kSamples =
    kHeader + "1403636579758555392,-0.1,0.2,0.3,9.8,0,-3\r\n1403636579763555328,0.4,0.5,0.6,9,0,1\r\n";

std::string T_BS(const Matrix3d& R, double x_m = 0) {
  std::ostringstream out;
  out.precision(17);
  out << "T_BS:\n  cols: 4\n  rows: 4\n  data: [";
  for (int row = 0; row < 3; ++row)
    out << R(row, 0) << ", " << R(row, 1) << ", " << R(row, 2) << ", " << (row == 0 ? x_m : 0) << ",\n    ";
  out << "0.0, 0.0, 0.0, 1.0]\n";
  return out.str();
}

std::string gyroscope_yaml(const Matrix3d& R_body_sensor) {
  return "#Default imu sensor yaml file\nsensor_type: imu\n" + T_BS(R_body_sensor) +
         "rate_hz: 200\ngyroscope_noise_density: 1.6968e-04     # [ rad / s / sqrt(Hz) ]\n"
         "gyroscope_random_walk: 1.9393e-05\naccelerometer_noise_density: 2.0000e-3\n";
}

std::string camera_yaml(const Matrix3d& R_body_camera, double x_m) {
  return "sensor_type: camera\n" + T_BS(R_body_camera, x_m) +
         "resolution: [32, 24]\ncamera_model: pinhole\nintrinsics: [30, 30, 16, 12]\n"
         "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n";
}

void write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  write_text(path, text);
}

/// A turn about all axes, which differs from its inverse.
Matrix3d turn(double x_rad, double y_rad, double z_rad) {
  return exp_so3(Vector3d(x_rad, y_rad, z_rad));
}

std::string complaint(const fs::path& file) {
  try {
    io::read_gyroscope(file);
    return "";
  } catch (const IoError& error) {
    CHECK(std::string(error.what()).find('\n') == std::string::npos);
    return error.what();
  }
}

}  // namespace

TEST_CASE("lists of a gyroscope: separators, headers, seconds and nanoseconds") {
  const struct {
    const char* what;
    std::string text;
    double first_s;
  } cases[] = {
      {"blanks", "12.5 0.1 -0.2 3e-1\n12.505 1 2 3\n", 12.5},
      {"commas, accelerations and a header",
       "t,gx,gy,gz,ax,ay,az\n12.5,0.1,-0.2,0.3,0,9,1\n12.51,1,2,3,0,9,1", 12.5},
      {"comments", "# a phone\n\n12.5\t0.1\t-0.2\t0.3\n# more\n12.505 1 2 3\n", 12.5},
      {"nanoseconds since 1970", "1700000000500000000 0.1 -0.2 0.3\n1700000000505000000 1 2 3\n",
       1700000000.5},
      {"nanoseconds since the phone began", "12500000000 0.1 -0.2 0.3\n12505000000 1 2 3\n", 12.5},
      {"seconds since 1970", "1700000000.5 0.1 -0.2 0.3 x y z\n1700000000.505 1 2 3\n", 1700000000.5},
      {"repeats and disorder", "12.5 0.1 -0.2 0.3\n12.5 1 2 3\n12.4 0 0 0\n12.51 0 0 0\n", 12.5},
      {"one sample", "12.5 0.1 -0.2 0.3", 12.5},
  };
  for (const auto& c : cases) {
    CAPTURE(c.what);
    const TemporaryFolder folder;
    write(folder.path() / "imu.txt", c.text);
    const auto recording = io::find_gyroscope(folder.path());
    REQUIRE(recording.has_value());
    REQUIRE_FALSE(recording->samples.empty());
    CHECK(recording->samples[0].timestamp_s == doctest::Approx(c.first_s).epsilon(1e-12));
    CHECK(recording->samples[0].omega_radps == Vector3d(0.1, -0.2, 0.3));
    if (recording->samples.size() > 1) CHECK(recording->samples[1].omega_radps == Vector3d(1, 2, 3));
    CHECK(recording->R_camera_body == Matrix3d::Identity());
    CHECK(recording->noise.density_radps_rthz == GyroNoise().density_radps_rthz);
  }
}

TEST_CASE("stamps that repeat or go back are kept as they are") {
  const TemporaryFolder folder;
  write(folder.path() / "any.csv", "12.5 0 0 0\n12.5 0 0 0\n12.4 0 0 0\n12.6 0 0 0\n");
  const GyroRecording recording = io::read_gyroscope(folder.path() / "any.csv");
  REQUIRE(recording.samples.size() == 4);
  for (std::size_t i = 0; i < 4; ++i)
    CHECK(recording.samples[i].timestamp_s ==
          doctest::Approx(std::vector<double>{12.5, 12.5, 12.4, 12.6}[i]));
}

TEST_CASE("a folder in TUM's layout: T_BS of imu0 leads to the camera") {
  const TemporaryFolder folder;
  write_tum_folder(folder.path(), 1);
  CHECK_FALSE(io::find_gyroscope(folder.path()).has_value());
  CHECK_FALSE(io::find_gyroscope(folder.path() / "missing").has_value());
  const Matrix3d R_camera_sensor = turn(0.3, -1.2, 2.0);
  write(folder.path() / "imu0" / "data.csv", kSamples);
  write(folder.path() / "imu0" / "sensor.yaml", gyroscope_yaml(R_camera_sensor));
  write(folder.path() / "imu.txt", "12.5 9 9 9\n");  // comes second
  const auto recording = io::find_gyroscope(folder.path());
  REQUIRE(recording.has_value());
  CHECK((recording->R_camera_body - R_camera_sensor).norm() < 1e-12);
  CHECK(recording->noise.density_radps_rthz == 1.6968e-4);
  CHECK(recording->noise.bias_walk_radps2_rthz == 1.9393e-5);
  CHECK(recording->noise.first_bias_radps == GyroNoise().first_bias_radps);
  REQUIRE(recording->samples.size() == 2);
  CHECK(recording->samples[0].timestamp_s == 1e-9 * 1403636579758555392.0);
  CHECK(recording->samples[1].omega_radps == Vector3d(0.4, 0.5, 0.6));
}

TEST_CASE("EuRoC: the camera's place on the body counts, with cam1 that of the rectified one") {
  const TemporaryFolder folder;
  const fs::path root = folder.path() / "mav0";
  const Matrix3d R_body_sensor = turn(0.1, 0.2, -0.3), R_body_camera = turn(0.02, -0.4, 1.5);
  write(root / "imu0" / "data.csv", kSamples);
  write(root / "imu0" / "sensor.yaml", gyroscope_yaml(R_body_sensor));
  write(root / "cam0" / "sensor.yaml", camera_yaml(R_body_camera, 0));
  const auto mono = io::find_gyroscope(folder.path());
  REQUIRE(mono.has_value());
  // An axis of the body, as the sensor and as the camera see it.
  const Vector3d body(1, -2, 0.5);
  CHECK((mono->R_camera_body * (R_body_sensor.transpose() * body) - R_body_camera.transpose() * body).norm() <
        1e-9);
  CHECK((io::find_gyroscope(root)->R_camera_body - mono->R_camera_body).norm() == 0);

  // The right camera is 0.2 m along the left one's x axis, and 0.01 m ahead: rectified images are turned.
  const Pose T_left_right = Pose::from(turn(0.01, -0.02, 0.01), Vector3d(0.2, 0, 0.01));
  const Pose T_body_right = Pose::from(R_body_camera, Vector3d::Zero()) * T_left_right;
  std::string right = camera_yaml(T_body_right.R(), 0);
  std::ostringstream T;
  T.precision(17);
  for (int row = 0; row < 3; ++row)
    for (int c = 0; c < 4; ++c) T << (c < 3 ? T_body_right.R()(row, c) : T_body_right.t()[row]) << ", ";
  const std::size_t from = right.find("data: [") + 7, to = right.find("0.0, 0.0, 0.0, 1.0]");
  right.replace(from, to - from, T.str());
  write(root / "cam1" / "sensor.yaml", right);
  write(root / "cam1" / "data.csv", "#timestamp [ns],filename\n1403636579763555328,a.png\n");
  const Matrix3d R_camera_body = io::find_gyroscope(folder.path())->R_camera_body;
  // Rows of rectified images follow the baseline, so that is the camera's x axis.
  const Vector3d baseline = T_body_right.t().normalized();
  CHECK((R_camera_body * (R_body_sensor.transpose() * baseline) - Vector3d::UnitX()).norm() < 1e-9);
  CHECK((R_camera_body - mono->R_camera_body).norm() > 0.01);

  write(root / "cam0" / "data" / "a.png", "");
  write(root / "cam1" / "data" / "a.png", "");
  write(root / "cam0" / "data.csv", "#timestamp [ns],filename\n1403636579763555328,a.png\n");
  const Pose T_body_loaded = io::detail::read_euroc_index(folder.path(), 0.01).T_body_camera;
  CHECK((R_camera_body - T_body_loaded.R().transpose() * R_body_sensor).norm() < 1e-12);
}

TEST_CASE("noise that sensor.yaml does not give, or gives as 0, is the default") {
  const TemporaryFolder folder;
  write(folder.path() / "data.csv", kSamples);
  for (const std::string noise : {"", "gyroscope_noise_density: 0.0\ngyroscope_random_walk: 0\n"}) {
    write(folder.path() / "sensor.yaml", T_BS(Matrix3d::Identity()) + noise);
    const GyroNoise read = io::read_gyroscope(folder.path() / "data.csv").noise;
    CHECK(read.density_radps_rthz == GyroNoise().density_radps_rthz);
    CHECK(read.bias_walk_radps2_rthz == GyroNoise().bias_walk_radps2_rthz);
  }
}

TEST_CASE("files that are no gyroscope are refused with file, line and what was expected") {
  const std::string line = "12.5 1 2 3\n", yaml = gyroscope_yaml(Matrix3d::Identity());
  const struct {
    const char* file;
    std::string text, yaml, message;
  } cases[] = {
      {"imu.txt", "", "", "imu.txt: contains no sample: expected 'timestamp wx wy wz [ax ay az]'"},
      {"imu.txt", "# nothing\nt,x,y,z\n", "", "imu.txt: contains no sample"},
      {"imu.txt", line + "12.6 1 2\n", "", "imu.txt:2: expected 'timestamp wx wy wz"},
      {"imu.txt", line + "12.6 1 2\n", "", "found 3 fields"},
      {"imu.txt", line + "12.6 1 fast 3\n", "", "imu.txt:2: 'fast' is not a number"},
      {"imu.txt", line + "t wx wy wz\n", "", "imu.txt:2: 't' is not a timestamp"},
      {"imu.txt", line + "12.6 1 nan 3\n", "", "imu.txt:2: 'nan' is not a finite rate"},
      {"imu.txt", line + "12.6 1 2 -inf\n", "", "imu.txt:2: '-inf' is not a finite rate"},
      {"imu.txt", line + "inf 1 2 3\n", "", "imu.txt:2: 'inf' is not a timestamp"},
      {"imu.txt", "t ax ay az gx gy gz\n12.5 0 9 1 0 0 0\n", "", "imu.txt:1: expected 'timestamp wx wy wz"},
      {"imu.txt", "t ax ay az gx gy gz\n12.5 0 9 1 0 0 0\n", "", "but the first column is 'ax'"},
      {"imu.txt", "1700000000000000 1 2 3\n1700000000005000 1 2 3\n", "", "seconds or nanoseconds"},
      {"imu.txt", "1700000000000 1 2 3\n1700000000005 1 2 3\n", "", "seconds or nanoseconds"},
      {"accelerometer.txt", "1305031098.6 0 9 1\n", "", "accelerometer alone does not tell the turn"},
      {"data.csv", kSamples, "", "sensor.yaml: no such file"},
      {"data.csv", kSamples, "rate_hz: 200\n", "sensor.yaml: 'T_BS' is missing"},
      {"data.csv", kSamples, T_BS(2 * Matrix3d::Identity()), "T_BS: is not a rotation and a translation"},
      {"data.csv", kSamples, "T_BS: 3\n", "sensor.yaml: "},
      {"data.csv", kSamples, T_BS(Matrix3d::Identity()) + "gyroscope_noise_density: -1\n",
       "gyroscope_noise_density: must be 0 or more"},
      {"data.csv", kSamples, T_BS(Matrix3d::Identity()) + "gyroscope_random_walk: low\n",
       "gyroscope_random_walk"},
      {"data.csv", kHeader, yaml, "data.csv: contains no sample"},
  };
  for (const auto& c : cases) {
    const TemporaryFolder folder;
    write(folder.path() / c.file, c.text);
    if (!c.yaml.empty()) write(folder.path() / "sensor.yaml", c.yaml);
    const std::string got = complaint(folder.path() / c.file);
    CAPTURE(got);
    CAPTURE(c.message);
    CHECK(got.find(c.message) != std::string::npos);
    CHECK(got.find(folder.path().string()) == 0);
  }
  const TemporaryFolder folder;
  CHECK(complaint(folder.path() / "imu.txt").find("no such file") != std::string::npos);
  CHECK(complaint(folder.path()).find("no such file") != std::string::npos);
}

TEST_CASE("a file that is too large is refused before it is read") {
  const TemporaryFolder folder;
  write(folder.path() / "imu.txt", "12.5 1 2 3\n");
  fs::resize_file(folder.path() / "imu.txt", io::kMaxGyroBytes + 1);  // takes no space
  CHECK(complaint(folder.path() / "imu.txt").find("imu.txt: has more than 100 MB") != std::string::npos);
}

}  // namespace gyro_reader_test
