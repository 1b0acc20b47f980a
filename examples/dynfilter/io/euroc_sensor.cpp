// SPDX-License-Identifier: MIT
#include "io/euroc_sensor.hpp"

#include <cstddef>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/error.hpp>
#include <string>
#include <system_error>
#include <vector>

namespace dynfilter::io::detail {

inline std::vector<double> numbers_of(const YamlNode& map, const std::string& key, std::size_t n) {
  const auto node = map.find(key);
  if (!node) map.fail("'" + key + "' is missing");
  std::vector<double> values = node->reals();
  if (values.size() != n) node->fail("expected " + std::to_string(n) + " numbers");
  return values;
}

inline std::string word_of(const YamlNode& map, const std::string& key) {
  const auto node = map.find(key);
  return node ? node->text() : "";
}

inline Pose read_T_body_sensor(const YamlNode& root) {
  const auto T = root.find("T_BS");
  if (!T) root.fail("'T_BS' is missing");
  const std::vector<double> n = numbers_of(*T, "data", 16);
  Pose pose;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t c = 0; c < 3; ++c) pose.rotation[3 * row + c] = n[4 * row + c];
    pose.translation_m[row] = n[4 * row + 3];
  }
  if (!is_rigid(pose)) T->fail("is not a rotation and a translation");
  return pose;
}

inline Camera read_euroc_camera(const YamlNode& root) {
  if (word_of(root, "camera_model") != "pinhole") root.fail("only the camera_model pinhole is supported");
  const std::vector<double> size = numbers_of(root, "resolution", 2), f = numbers_of(root, "intrinsics", 4);
  Camera camera;
  camera.fx_px = f[0], camera.fy_px = f[1], camera.cx_px = f[2], camera.cy_px = f[3];
  camera.width_px = static_cast<int>(size[0]), camera.height_px = static_cast<int>(size[1]);
  if (!(f[0] > 0 && f[1] > 0 && size[0] >= 1 && size[1] >= 1))
    root.fail("intrinsics and resolution must be above 0");
  const std::string model = word_of(root, "distortion_model");
  if (model.empty() || model == "none") return camera;
  if (model != "radial-tangential" && model != "radtan")
    root.fail("only the distortion_model radial-tangential is supported, not " + model);
  const std::vector<double> k = numbers_of(root, "distortion_coefficients", 4);
  for (std::size_t i = 0; i < k.size(); ++i) camera.distortion[i] = k[i];
  return camera;
}

/// Nothing if it is missing or 0, which files say of what was not measured.
inline std::optional<double> measured(const YamlNode& root, const char* key) {
  const auto node = root.find(key);
  if (!node) return std::nullopt;
  const double value = node->real();
  if (value < 0) node->fail("must be 0 or more");
  return value > 0 ? std::optional<double>(value) : std::nullopt;
}

/// What `read` makes of the file. Its errors name the file.
template <class Read>
auto read_sensor_file(const std::filesystem::path& path, const Read& read) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw IoError(path.string() + ": no such file");
  try {
    const YamlDocument document = YamlDocument::from_file(path.string());
    return read(document.root());
  } catch (const ConfigError& problem) {
    const std::string what = problem.what();
    throw IoError(what.find(path.string()) == std::string::npos ? path.string() + ": " + what : what);
  }
}

RigCamera read_euroc_sensor(const std::filesystem::path& path) {
  return read_sensor_file(path, [](const YamlNode& root) {
    return RigCamera{read_euroc_camera(root), read_T_body_sensor(root)};
  });
}

RigGyroscope read_euroc_gyroscope(const std::filesystem::path& path) {
  return read_sensor_file(path, [](const YamlNode& root) {
    RigGyroscope gyroscope;
    gyroscope.T_body_sensor = read_T_body_sensor(root);
    GyroNoise& noise = gyroscope.noise;
    noise.density_radps_rthz = measured(root, "gyroscope_noise_density").value_or(noise.density_radps_rthz);
    noise.bias_walk_radps2_rthz =
        measured(root, "gyroscope_random_walk").value_or(noise.bias_walk_radps2_rthz);
    return gyroscope;
  });
}

}  // namespace dynfilter::io::detail
