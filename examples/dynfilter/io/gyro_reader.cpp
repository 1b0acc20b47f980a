// SPDX-License-Identifier: MIT
#include "io/gyro_reader.hpp"

#include <cctype>
#include <cmath>
#include <cstddef>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "io/euroc_index.hpp"
#include "io/euroc_sensor.hpp"
#include "io/sequence_index.hpp"

namespace dynfilter::io {

namespace detail {

constexpr const char* kGyroLine = "expected 'timestamp wx wy wz [ax ay az]' in rad/s";

inline bool is_file(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error);
}

inline void check_gyro_file(const std::filesystem::path& file) {
  if (file.stem() == "accelerometer")
    throw IoError(file.string() +
                  ": an accelerometer alone does not tell the turn of the camera: " + kGyroLine);
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  if (!error && bytes > kMaxGyroBytes)
    throw IoError(file.string() + ": has more than " + std::to_string(kMaxGyroBytes / 1'000'000) + " MB");
}

/// True for a line that names the columns. Throws IoError if the first one is not that of a gyroscope.
inline bool names_columns(const TextLine& line, const std::filesystem::path& file) {
  if (parse_number(line.fields[0])) return false;
  const bool accelerations_first =
      line.fields.size() > 1 && std::tolower(static_cast<unsigned char>(line.fields[1][0])) == 'a';
  if (accelerations_first)
    throw IoError(at_line(file, line.number) + ": " + kGyroLine + ", but the first column is '" +
                  line.fields[1] + "'");
  return true;
}

inline GyroSample gyro_sample(const TextLine& line, const std::filesystem::path& file) {
  if (line.fields.size() < 4)
    throw IoError(at_line(file, line.number) + ": " + kGyroLine + ", found " +
                  counted(line.fields.size(), "field", "fields"));
  GyroSample sample;
  sample.timestamp_s = stamp_of(line, 0, file);
  for (std::size_t i = 0; i < 3; ++i) {
    const double rate = number_at(line, i + 1, file);
    if (!std::isfinite(rate))
      throw IoError(at_line(file, line.number) + ": '" + line.fields[i + 1] + "' is not a finite rate");
    sample.omega_radps[static_cast<Eigen::Index>(i)] = rate;
  }
  return sample;
}

/// The usual time between samples; 0: there are no two.
inline double usual_step(const std::vector<GyroSample>& samples) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double step = samples[i].timestamp_s - samples[i - 1].timestamp_s;
    if (step > 0) steps.push_back(step);
  }
  return steps.empty() ? 0 : median_in_place(steps);
}

/// Converts nanoseconds. Android's clocks begin when the phone does, so the stamps may be small.
inline void stamps_to_seconds(std::vector<GyroSample>& samples, const std::filesystem::path& file) {
  constexpr double kLeast_ns = 1e15;     // 11 days in nanoseconds, 32 million years in seconds
  constexpr double kLeastStep_ns = 1e5;  // 10 kHz in nanoseconds, a day in seconds
  constexpr double kShortest_s = 2e-5, kLongest_s = 1;
  double step_s = usual_step(samples);
  if (samples[0].timestamp_s > kLeast_ns || step_s > kLeastStep_ns) {
    for (GyroSample& sample : samples) sample.timestamp_s *= 1e-9;
    step_s *= 1e-9;
  }
  if (step_s > 0 && (step_s < kShortest_s || step_s > kLongest_s))
    throw IoError(file.string() + ": timestamps are expected in seconds or nanoseconds, but would be " +
                  std::to_string(step_s) + " s apart");
}

inline std::vector<GyroSample> read_gyro_samples(const std::filesystem::path& file) {
  check_gyro_file(file);
  std::vector<GyroSample> samples;
  bool first = true;
  for (const TextLine& line : read_text_lines(file)) {
    const bool named = first && names_columns(line, file);
    first = false;
    if (!named) samples.push_back(gyro_sample(line, file));
  }
  if (samples.empty()) throw IoError(file.string() + ": contains no sample: " + kGyroLine);
  stamps_to_seconds(samples, file);
  return samples;
}

}  // namespace detail

std::optional<GyroRecording> find_gyroscope(const std::filesystem::path& folder) {
  for (const char* name : {"mav0/imu0/data.csv", "imu0/data.csv", "imu.txt"})
    if (detail::is_file(folder / name)) return read_gyroscope(folder / name);
  return std::nullopt;
}

GyroRecording read_gyroscope(const std::filesystem::path& file) {
  GyroRecording recording;
  recording.samples = detail::read_gyro_samples(file);
  if (file.filename() != "data.csv") return recording;
  const detail::RigGyroscope gyroscope = detail::read_euroc_gyroscope(file.parent_path() / "sensor.yaml");
  recording.noise = gyroscope.noise;
  recording.R_camera_body = gyroscope.T_body_sensor.R();
  const std::filesystem::path root = std::filesystem::absolute(file).parent_path().parent_path();
  if (detail::is_file(root / "cam0" / "sensor.yaml"))
    recording.R_camera_body =
        detail::read_euroc_T_body_camera(root).R().transpose() * recording.R_camera_body;
  return recording;
}

}  // namespace dynfilter::io
