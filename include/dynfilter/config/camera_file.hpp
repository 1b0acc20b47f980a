// SPDX-License-Identifier: MIT
#pragma once

#include <cctype>
#include <cmath>
#include <cstddef>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace dynfilter::io {

/// A camera as a file describes it. The keys are those of ORB-SLAM settings (`Camera.fx`, in ORB-SLAM3 also
/// `Camera1.fx`), so such a file can be used directly.
struct CameraFile {
  Camera camera;
  std::optional<double> depth_units_per_m;  ///< `DepthMapFactor`
  std::optional<double> rate_hz;            ///< `Camera.fps`
  /// `Camera.sensor`: "rgbd", "stereo" or "mono", what an odometry uses unless told otherwise; "": not said.
  std::string sensor;
};

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

/// Reads `Camera.fx fy cx cy` [px]. Optional keys are `k1 k2 p1 p2 k3`, `bf` [px m], `width`, `height` [px],
/// `fps`, `sensor` and `DepthMapFactor`. Other keys are ignored. Throws IoError.
inline CameraFile read_camera(const std::filesystem::path& path) {
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

}  // namespace dynfilter::io
