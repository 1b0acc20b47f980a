// SPDX-License-Identifier: MIT
#include "io/camera_writer.hpp"

#include <cmath>
#include <ostream>

#include "io/atomic_file.hpp"

namespace dynfilter::io {

void write_camera(const std::filesystem::path& path, const Camera& camera, double depth_units_per_m) {
  CameraFile file;
  file.camera = camera;
  file.depth_units_per_m = depth_units_per_m;
  write_camera(path, file);
}

void write_camera(const std::filesystem::path& path, const CameraFile& file) {
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

}  // namespace dynfilter::io
