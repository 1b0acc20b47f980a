// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>

#include "arguments.hpp"

namespace dynfilter::python {
namespace {

/// Entries of a camera matrix that products of matrices leave instead of 0 and 1.
constexpr double kRoundoff = 1e-6;

}  // namespace

const Camera& checked_camera(const std::string& argument, const Camera& camera) {
  const auto expected = [&](const char* what, const std::string& a, const std::string& b) {
    return py::value_error(argument + ": expected " + what + ", got " + a + ", " + b);
  };
  const auto inside = [](double c_px, int side_px) {
    return std::isfinite(c_px) && c_px > 0 && (side_px == 0 || c_px < side_px);
  };
  if (camera.width_px < 0 || camera.height_px < 0)
    throw expected("an image size of 0 (any) or more", std::to_string(camera.width_px),
                   std::to_string(camera.height_px));
  if (!camera.valid() || !std::isfinite(camera.fx_px) || !std::isfinite(camera.fy_px))
    throw expected("focal lengths fx, fy above 0 [px]", number_text(camera.fx_px), number_text(camera.fy_px));
  if (!inside(camera.cx_px, camera.width_px) || !inside(camera.cy_px, camera.height_px))
    throw expected("a principal point cx, cy inside the image [px]", number_text(camera.cx_px),
                   number_text(camera.cy_px));
  return camera;
}

Camera camera_of(const std::string& argument, py::handle value) {
  if (py::isinstance<Camera>(value)) return value.cast<Camera>();
  const py::array any = any_array(argument, value);
  if (!any || any.ndim() != 2) refuse(argument, "a dynfilter.Camera or a (3, 3) matrix", value);
  const auto K = array_of<double>(argument, any, 3, 3);
  Camera camera;
  camera.fx_px = K.at(0, 0), camera.fy_px = K.at(1, 1), camera.cx_px = K.at(0, 2), camera.cy_px = K.at(1, 2);
  const auto zero = [](double entry) { return std::abs(entry) <= kRoundoff; };
  if (!zero(K.at(2, 0)) || !zero(K.at(2, 1)) || !zero(K.at(2, 2) - 1))
    throw py::value_error(argument + ": expected a matrix with the bottom row 0 0 1, got " +
                          number_text(K.at(2, 0)) + " " + number_text(K.at(2, 1)) + " " +
                          number_text(K.at(2, 2)));
  checked_camera(argument, camera);
  if (!zero(K.at(0, 1) / camera.fx_px) || !zero(K.at(1, 0) / camera.fx_px))
    throw py::value_error(argument + ": expected a matrix without skew, got " + number_text(K.at(0, 1)) +
                          " in row 0 and " + number_text(K.at(1, 0)) + " in row 1");
  return camera;
}

std::array<double, 5> distortion_of(const std::string& argument, py::handle value) {
  const char* wanted = "0, 4 or 5 numbers k1 k2 p1 p2 k3";
  py::array any = any_array(argument, value);
  if (!any) refuse(argument, wanted, value);
  if (any.ndim() == 2 && std::min(any.shape(0), any.shape(1)) == 1) any = any.attr("ravel")();
  const auto given = array_of<double>(argument, any, -1);
  const auto n = static_cast<std::size_t>(given.size());
  std::array<double, 5> distortion{};
  if (n != 0 && n != 4 && n != 5)
    throw py::value_error(argument + ": expected " + wanted + ", got " + std::to_string(n));
  std::copy_n(given.data(), n, distortion.begin());
  if (!std::all_of(distortion.begin(), distortion.end(), [](double k) { return std::isfinite(k); }))
    throw py::value_error(argument + ": expected finite numbers, got NaN or infinity");
  return distortion;
}

}  // namespace dynfilter::python
