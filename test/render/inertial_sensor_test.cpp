// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/pose.hpp>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "doctest/doctest.h"
#include "io/gyro_reader.hpp"
#include "io/tum_folder.hpp"
#include "render/inertial_sensor.hpp"
#include "render/sequence_writer.hpp"

namespace inertial_sensor_test {

using namespace dynfilter;
using namespace dynfilter::render;
using dynfilter_test::read_text;
using dynfilter_test::TemporaryFolder;
using Eigen::Vector3d;
namespace fs = std::filesystem;

namespace {

constexpr double kRadPerDeg = M_PI / 180;

/// A level camera that turns at a constant rate about its own axes.
CameraPath turning(const Vector3d& omega_radps) {
  return [omega_radps](double time_s) {
    Eigen::Isometry3d pose = look_at(Vector3d(1, 2, 1.5), Vector3d(3, 5, 1.5));
    pose.linear() = pose.linear() * exp_so3(time_s * omega_radps);
    return pose;
  };
}

/// What is read without any turn, for the errors alone.
std::vector<InertialSample> no_turn(int seconds) {
  return std::vector<InertialSample>(static_cast<std::size_t>(seconds * kInertialRate_hz) + 1);
}

/// The rate between samples by a cubic through four of them.
Vector3d rate_between(const std::vector<InertialSample>& samples, std::size_t i, double share) {
  const Vector3d &a = samples[i - 1].omega_radps, &b = samples[i].omega_radps,
                 &c = samples[i + 1].omega_radps, &d = samples[i + 2].omega_radps;
  const double s = share;
  return a * (-s * (s - 1) * (s - 2) / 6) + b * ((s + 1) * (s - 1) * (s - 2) / 2) +
         c * (-(s + 1) * s * (s - 2) / 2) + d * ((s + 1) * s * (s - 1) / 6);
}

/// The turn of the camera from time 0 to `end_s`, by twenty small steps per sample.
Eigen::Matrix3d integrated(const std::vector<InertialSample>& samples, double end_s) {
  constexpr int kSteps = 20;
  const Eigen::Matrix3d R_camera_sensor = T_camera_inertial().linear();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (std::size_t i = 1; i + 2 < samples.size(); ++i) {
    if (samples[i].time_s < -1e-9 || samples[i].time_s > end_s - 1e-9) continue;
    for (int step = 0; step < kSteps; ++step) {
      const Vector3d rate = R_camera_sensor * rate_between(samples, i, (step + 0.5) / kSteps);
      R = R * exp_so3(rate / (kSteps * kInertialRate_hz));
    }
  }
  return R;
}

/// Standard deviation of what comes around 0.
double spread(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

std::set<std::string> files_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) names.insert(fs::relative(entry.path(), folder).string());
  return names;
}

}  // namespace

TEST_CASE("a constant rate of the camera is that rate about the sensor's axes") {
  const struct {
    Vector3d camera, sensor;
  } cases[] = {{{0.5, 0, 0}, {0, 0, 0.5}},  // the sensor's z axis is the camera's x
               {{0, -2, 0}, {-2, 0, 0}},
               {{0, 0, 3}, {0, 3, 0}},
               {{0.1, 0.2, 0.3}, {0.2, 0.3, 0.1}}};
  for (const auto& c : cases) {
    const std::vector<InertialSample> samples = inertial_samples(turning(c.camera), -0.1, 0.5);
    REQUIRE(samples.size() == 121);
    CHECK(samples.front().time_s == -0.1);
    CHECK(samples.back().time_s == doctest::Approx(0.5));
    for (const InertialSample& sample : samples) CHECK((sample.omega_radps - c.sensor).norm() < 1e-9);
  }
  CHECK(is_rigid(Pose::from(T_camera_inertial()), 1e-12));
}

TEST_CASE("the sensor reads gravity, the camera's acceleration and that of its own place") {
  constexpr double kRate_radps = 2, kAcceleration_mps2 = 3, kTolerance_mps2 = 1e-6;
  // Up is the camera's -y, which is the sensor's -x.
  const Vector3d gravity(-kGravity_mps2, 0, 0);
  CHECK((inertial_samples(turning(Vector3d::Zero()), 0, 0)[0].force_mps2 - gravity).norm() < kTolerance_mps2);

  const auto ahead = [](double time_s) {
    Eigen::Isometry3d pose = look_at(Vector3d::Zero(), Vector3d::UnitX());
    pose.translation().x() = 0.5 * kAcceleration_mps2 * time_s * time_s;
    return pose;
  };
  CHECK((inertial_samples(ahead, 1, 1)[0].force_mps2 - gravity - Vector3d(0, kAcceleration_mps2, 0)).norm() <
        kTolerance_mps2);

  // About the vertical: towards the axis, with the square of the rate.
  const Vector3d arm = T_camera_inertial().translation();
  const Vector3d inwards = -kRate_radps * kRate_radps * Vector3d(0, arm.z(), arm.x());
  for (const InertialSample& sample : inertial_samples(turning({0, kRate_radps, 0}), 0, 0.1))
    CHECK((sample.force_mps2 - gravity - inwards).norm() < kTolerance_mps2);
}

TEST_CASE("exact samples lead from the first frame's rotation to the last one's") {
  for (const char* scene : {"walking_rpy", "walking_shake"}) {
    CAPTURE(scene);
    SequenceOptions options;
    options.scene = scene;
    options.frames = 61;  // 2 s
    const SequenceRenderer renderer(options);
    const double end_s = renderer.time_s(60);
    const std::vector<InertialSample> samples = inertial_samples(
        [&](double time_s) { return renderer.scene().camera->pose(time_s); }, -0.1, end_s + 0.1);
    const Eigen::Matrix3d expected = renderer.pose(0).R().transpose() * renderer.pose(60).R();
    CHECK(rotation_vector(expected).norm() > 3 * kRadPerDeg);
    CHECK(rotation_vector(expected.transpose() * integrated(samples, end_s)).norm() < 0.02 * kRadPerDeg);
  }
}

TEST_CASE("the white noise has the stated density, whatever the rate of the samples") {
  const GyroNoise noise{2e-4, 0, 0};
  std::vector<InertialSample> samples = no_turn(1000);
  Random random(1, kInertialStream);
  add_gyro_noise(noise, random, samples);
  std::vector<double> each, means;
  constexpr std::size_t kSecond = 200;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i + kSecond <= samples.size(); i += kSecond) {
      double sum = 0;
      for (std::size_t k = i; k < i + kSecond; ++k) {
        each.push_back(samples[k].omega_radps[axis]);
        sum += each.back();
      }
      means.push_back(sum / kSecond);
    }
  CHECK(spread(each) == doctest::Approx(noise.density_radps_rthz * std::sqrt(200.0)).epsilon(0.005));
  CHECK(spread(means) == doctest::Approx(noise.density_radps_rthz).epsilon(0.05));  // a bandwidth of 1 Hz
}

TEST_CASE("the bias walks with the square root of the time, from a first one of the stated spread") {
  const GyroNoise walk{0, 2e-5, 0}, first{0, 0, 0.02};
  std::vector<double> after_1_s, begin;
  constexpr std::size_t kSecond = 200;
  std::vector<InertialSample> samples = no_turn(1000);
  Random random(2, kInertialStream);
  add_gyro_noise(walk, random, samples);
  CHECK(samples[0].omega_radps.norm() < 1e-12);
  for (std::size_t i = kSecond; i < samples.size(); i += kSecond)
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      after_1_s.push_back(samples[i].omega_radps[axis] - samples[i - kSecond].omega_radps[axis]);
  CHECK(spread(after_1_s) == doctest::Approx(walk.bias_walk_radps2_rthz).epsilon(0.05));

  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    std::vector<InertialSample> two(2);
    Random other(seed, kInertialStream);
    add_gyro_noise(first, other, two);
    CHECK((two[1].omega_radps - two[0].omega_radps).norm() < 1e-12);
    for (const double value : two[0].omega_radps) begin.push_back(value);
  }
  CHECK(spread(begin) == doctest::Approx(first.first_bias_radps).epsilon(0.04));
}

TEST_CASE("the reader reads what the writer wrote, late stamps included") {
  const TemporaryFolder folder;
  InertialRecord record;
  record.samples = inertial_samples(turning({0.3, -0.2, 0.1}), -0.1, 0.2);
  record.noise = gyro_noise(GyroGrade::Phone);
  record.first_frame_s = SequenceRenderer::first_timestamp_s();
  record.stamps_late_s = 0.02;
  write_inertial(folder.path() / "imu0", record);
  const auto read = io::find_gyroscope(folder.path());
  REQUIRE(read.has_value());
  CHECK((read->R_camera_body - T_camera_inertial().linear()).norm() == 0);
  CHECK(read->noise.density_radps_rthz == record.noise.density_radps_rthz);
  CHECK(read->noise.bias_walk_radps2_rthz == record.noise.bias_walk_radps2_rthz);
  REQUIRE(read->samples.size() == record.samples.size());
  for (std::size_t i = 0; i < read->samples.size(); ++i) {
    const double stamp_s = record.first_frame_s + record.samples[i].time_s + record.stamps_late_s;
    CHECK(std::abs(read->samples[i].timestamp_s - stamp_s) < 1e-6);
    CHECK((read->samples[i].omega_radps - record.samples[i].omega_radps).norm() < 1e-8);
    CHECK((read->R_camera_body * read->samples[i].omega_radps - Vector3d(0.3, -0.2, 0.1)).norm() < 1e-8);
  }
}

TEST_CASE("a gyroscope changes no other file of a sequence, and begins before its frames") {
  const TemporaryFolder folder;
  SequenceOptions options;
  options.scene = "walking_shake";
  options.frames = 1;
  options.exposure_ms = 0;  // faster
  const auto written = [&](const char* name, GyroGrade grade) {
    options.gyro = grade;
    write_sequence(options, folder.path() / name);
    return folder.path() / name;
  };
  const fs::path without = written("none", GyroGrade::None), phone = written("phone", GyroGrade::Phone);
  const std::set<std::string> files = files_in(without);
  CHECK(files.count("imu0/data.csv") == 0);
  CHECK(files.size() + 2 == files_in(phone).size());
  for (const std::string& file : files) {
    CAPTURE(file);
    CHECK((read_text(without / file) == read_text(phone / file)));
  }
  CHECK_FALSE(io::find_gyroscope(without).has_value());

  const auto noisy = io::find_gyroscope(phone);
  REQUIRE(noisy.has_value());
  const double stamp_s = SequenceRenderer::first_timestamp_s();
  CHECK(std::abs(noisy->samples.front().timestamp_s - (stamp_s - 0.1)) < 1e-6);
  CHECK(std::abs(noisy->samples.back().timestamp_s - (stamp_s + 0.1)) < 1e-6);
  // The bias of a phone is within five standard deviations, and is not 0.
  const SequenceRenderer renderer(options);
  const auto exact =
      inertial_samples([&](double time_s) { return renderer.scene().camera->pose(time_s); }, -0.1, 0.1);
  REQUIRE(exact.size() == noisy->samples.size());
  const Vector3d error_radps = noisy->samples[20].omega_radps - exact[20].omega_radps;
  CHECK(error_radps.cwiseAbs().maxCoeff() < 0.1);
  CHECK(error_radps.norm() > 1e-4);
  CHECK((read_text(phone / "imu0/data.csv") ==
         read_text(written("again", GyroGrade::Phone) / "imu0/data.csv")));
}

TEST_CASE("grades of gyroscopes have names") {
  for (const std::string& name : gyro_grade_names()) CHECK_NOTHROW(gyro_grade(name));
  CHECK(gyro_noise(gyro_grade("good")).density_radps_rthz < gyro_noise(GyroGrade::Phone).density_radps_rthz);
  CHECK_THROWS_WITH_AS(gyro_grade("best"), doctest::Contains("expected none, exact, phone or good"),
                       ConfigError);
  SequenceOptions options;
  options.gyro_offset_ms = 101;
  CHECK_THROWS_WITH_AS(SequenceRenderer{options}, doctest::Contains("gyro_offset_ms"), ConfigError);
}

}  // namespace inertial_sensor_test
