// SPDX-License-Identifier: MIT
#include "io/known_camera.hpp"

#include <array>
#include <cctype>

namespace dynfilter::io {

std::optional<Camera> known_camera(const std::string& name) {
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
