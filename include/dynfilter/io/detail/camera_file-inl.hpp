// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/camera_file.hpp>

#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/numbers.hpp>
#include <dynfilter/io/atomic_file.hpp>
#include <dynfilter/io/text_lines.hpp>
#include <map>
#include <ostream>

namespace dynfilter::io {

namespace detail {

/// Reads only the flat `key: value` lines at the left margin. The rest of the file is ignored.
inline std::map<std::string, TextLine> flat_keys(const std::filesystem::path& path) {
  LineReader reader(path);
  std::map<std::string, TextLine> keys;
  for (std::string text; reader.next(text);) {
    const int number = reader.number();
    text = text.substr(0, text.find('#'));
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos || text[0] == '%' || std::isspace(static_cast<unsigned char>(text[0])))
      continue;
    const std::size_t begin = text.find_first_not_of(" \t\r", colon + 1);
    const std::size_t end = text.find_last_not_of(" \t\r");
    const std::string value = begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
    std::string key = text.substr(0, colon);
    if (key.rfind("Camera1.", 0) == 0) key.erase(6, 1);
    if (!keys.emplace(key, TextLine{number, {value}}).second) {
      throw IoError(at_line(path, number) + ": '" + key + "' is given twice");
    }
  }
  return keys;
}

class CameraKeys {
 public:
  explicit CameraKeys(const std::filesystem::path& path) : path_(path), keys_(flat_keys(path)) {}

  std::optional<double> number(const std::string& key) const {
    const auto found = keys_.find(key);
    if (found == keys_.end()) return std::nullopt;
    const auto value = parse_number(found->second.fields[0]);
    if (!value || !std::isfinite(*value)) {
      throw IoError(at_line(path_, found->second.number) + ": '" + key + "' is not a number");
    }
    return value;
  }
  double required_positive(const std::string& key) const {
    const auto value = number(key);
    if (!value) throw IoError(path_.string() + ": '" + key + "' is missing");
    if (*value <= 0) throw IoError(path_.string() + ": '" + key + "' must be above 0");
    return *value;
  }
  std::string sensor() const {
    const auto found = keys_.find("Camera.sensor");
    if (found == keys_.end()) return "";
    const std::string& name = found->second.fields[0];
    if (name == "rgbd" || name == "stereo" || name == "mono") return name;
    throw IoError(at_line(path_, found->second.number) + ": 'Camera.sensor' must be rgbd, stereo or mono");
  }
  int size_px(const std::string& key) const {
    const double value = number(key).value_or(0);
    if (value < 0 || value > 1e5) throw IoError(path_.string() + ": '" + key + "' is out of range");
    return static_cast<int>(value);
  }
  void check_type() const {
    const auto type = keys_.find("Camera.type");
    if (type == keys_.end()) return;
    const std::string& value = type->second.fields[0];
    if (value.find("PinHole") != std::string::npos || value.find("Pinhole") != std::string::npos) return;
    throw IoError(at_line(path_, type->second.number) + ": only PinHole cameras are supported, not " + value);
  }

 private:
  std::filesystem::path path_;
  std::map<std::string, TextLine> keys_;
};

}  // namespace detail

DYNFILTER_INLINE CameraFile read_camera(const std::filesystem::path& path) {
  const detail::CameraKeys keys(path);
  keys.check_type();
  CameraFile file;
  file.camera.fx_px = keys.required_positive("Camera.fx");
  file.camera.fy_px = keys.required_positive("Camera.fy");
  file.camera.cx_px = keys.required_positive("Camera.cx");
  file.camera.cy_px = keys.required_positive("Camera.cy");
  const char* const names[5] = {"Camera.k1", "Camera.k2", "Camera.p1", "Camera.p2", "Camera.k3"};
  for (std::size_t i = 0; i < 5; ++i) file.camera.distortion[i] = keys.number(names[i]).value_or(0);
  file.camera.baseline_fx_px_m = keys.number("Camera.bf").value_or(0);
  file.camera.width_px = keys.size_px("Camera.width");
  file.camera.height_px = keys.size_px("Camera.height");
  file.sensor = keys.sensor();
  if (keys.number("Camera.fps")) file.rate_hz = keys.required_positive("Camera.fps");
  if (keys.number("DepthMapFactor")) file.depth_units_per_m = keys.required_positive("DepthMapFactor");
  if (!file.depth_units_per_m && keys.number("RGBD.DepthMapFactor")) {
    file.depth_units_per_m = keys.required_positive("RGBD.DepthMapFactor");
  }
  return file;
}

DYNFILTER_INLINE void write_camera(const std::filesystem::path& path, const Camera& camera,
                                   double depth_units_per_m) {
  CameraFile file;
  file.camera = camera;
  file.depth_units_per_m = depth_units_per_m;
  write_camera(path, file);
}

DYNFILTER_INLINE void write_camera(const std::filesystem::path& path, const CameraFile& file) {
  const Camera& camera = file.camera;
  write_file_atomically(path, [&](std::ostream& out) {
    out.precision(17);
    const auto& k = camera.distortion;
    // OpenCV's YAML distinguishes reals from integers by the decimal point.
    const auto real = [&](const char* key, double value) {
      out << key << ": " << value << (value == std::floor(value) && std::abs(value) < 1e15 ? ".0\n" : "\n");
    };
    out << "%YAML:1.0\n---\n# pixels; distortion as OpenCV's radial-tangential model\n";
    real("Camera.fx", camera.fx_px), real("Camera.fy", camera.fy_px);
    real("Camera.cx", camera.cx_px), real("Camera.cy", camera.cy_px);
    real("Camera.k1", k[0]), real("Camera.k2", k[1]), real("Camera.p1", k[2]), real("Camera.p2", k[3]);
    real("Camera.k3", k[4]);
    if (camera.baseline_fx_px_m > 0) real("Camera.bf", camera.baseline_fx_px_m);
    out << "Camera.width: " << camera.width_px << "\nCamera.height: " << camera.height_px << '\n';
    if (file.rate_hz) real("Camera.fps", *file.rate_hz);
    if (!file.sensor.empty()) out << "Camera.sensor: " << file.sensor << '\n';
    if (!file.depth_units_per_m) return;
    out << "# depth image values per metre\n";
    real("DepthMapFactor", *file.depth_units_per_m);
  });
}

DYNFILTER_INLINE std::optional<Camera> known_camera(const std::string& name) {
  const auto has = [&](const std::string& word) {
    for (std::size_t at = name.find(word); at != std::string::npos; at = name.find(word, at + 1)) {
      const std::size_t end = at + word.size();
      const bool starts = at == 0 || !std::isalnum(static_cast<unsigned char>(name[at - 1]));
      if (starts && (end == name.size() || !std::isdigit(static_cast<unsigned char>(name[end])))) return true;
    }
    return false;
  };
  const auto camera = [](double fx, double fy, double cx, double cy, std::array<double, 5> k) {
    Camera c;
    c.fx_px = fx, c.fy_px = fy, c.cx_px = cx, c.cy_px = cy, c.distortion = k;
    c.width_px = 640, c.height_px = 480;
    return c;
  };
  if (has("freiburg1") || has("fr1")) {
    return camera(517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633});
  }
  if (has("freiburg2") || has("fr2")) {
    return camera(520.9, 521.0, 325.1, 249.7, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172});
  }
  if (has("freiburg3") || has("fr3")) return camera(535.4, 539.2, 320.1, 247.6, {});
  if (has("bonn")) {
    return camera(542.822841, 542.576870, 315.593520, 237.756098,
                  {0.039903, -0.099343, -0.000730, -0.000144, 0});
  }
  return std::nullopt;
}

}  // namespace dynfilter::io
