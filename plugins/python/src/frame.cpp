// SPDX-License-Identifier: MIT
// Camera and Detection.
#include <pybind11/stl.h>

#include <cmath>
#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/detectors/detections.hpp>
#include <utility>

#include "arguments.hpp"
#include "bindings.hpp"

namespace dynfilter::python {
namespace {

Camera make_camera(double fx_px, double fy_px, double cx_px, double cy_px, py::handle distortion,
                   int width_px, int height_px, double baseline_fx_px_m) {
  Camera camera;
  camera.fx_px = fx_px, camera.fy_px = fy_px, camera.cx_px = cx_px, camera.cy_px = cy_px;
  camera.width_px = width_px, camera.height_px = height_px, camera.baseline_fx_px_m = baseline_fx_px_m;
  if (!std::isfinite(baseline_fx_px_m) || baseline_fx_px_m < 0)
    throw py::value_error("baseline_fx_px_m: expected a finite number, 0 or more");
  camera.distortion = distortion_of("distortion", distortion);
  return checked_camera("Camera", camera);
}

Detection make_detection(py::handle box, std::string class_name, float score, int class_id, int track_id,
                         py::handle mask) {
  const auto sides = array_of<float>("box", box, 4);
  Detection detection;
  detection.box = {sides.at(0), sides.at(1), sides.at(2), sides.at(3)};
  detection.class_name = std::move(class_name);
  detection.score = score, detection.class_id = class_id, detection.track_id = track_id;
  Images images;
  detection.mask = images.mask("mask", mask).clone();
  return detection;
}

py::tuple box_of(const Detection& d) {
  return py::make_tuple(d.box.x, d.box.y, d.box.width, d.box.height);
}

py::object mask_of(const Detection& d) {
  return d.mask.empty() ? py::object(py::none()) : py::object(array_of(d.mask));
}

std::string text_of(const Detection& d) {
  return py::str("Detection({}, {!r}, score={:.2f})").format(box_of(d), d.class_name, d.score);
}

void bind_camera(py::module_& module) {
  py::class_<Camera>(module, "Camera",
                     "Pinhole camera with OpenCV's radial-tangential distortion. Focal lengths and centre in "
                     "pixels.")
      .def(py::init(&make_camera), py::arg("fx_px"), py::arg("fy_px"), py::arg("cx_px"), py::arg("cy_px"),
           py::kw_only(), py::arg("distortion") = py::tuple(), py::arg("width_px") = 0,
           py::arg("height_px") = 0, py::arg("baseline_fx_px_m") = 0.0,
           "`distortion`: 0, 4 or 5 numbers k1 k2 p1 p2 k3. `width_px`, `height_px`: 0 for any size.\n"
           "`baseline_fx_px_m`: stereo baseline [m] times fx; 0 for no stereo camera.")
      .def_readonly("fx_px", &Camera::fx_px)
      .def_readonly("fy_px", &Camera::fy_px)
      .def_readonly("cx_px", &Camera::cx_px)
      .def_readonly("cy_px", &Camera::cy_px)
      .def_readonly("width_px", &Camera::width_px)
      .def_readonly("height_px", &Camera::height_px)
      .def_readonly("baseline_fx_px_m", &Camera::baseline_fx_px_m)
      .def_property_readonly("distortion", [](const Camera& c) { return py::tuple(py::cast(c.distortion)); })
      .def_property_readonly(
          "matrix",
          [](const Camera& c) {
            py::array_t<double> K({3, 3});
            const double values[] = {c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1};
            std::copy(std::begin(values), std::end(values), K.mutable_data());
            return K;
          },
          "(3, 3) float64: K of pixel = K (x/z, y/z, 1)")
      .def("__eq__", [](const Camera& a, const Camera& b) { return a == b; })
      .def("__repr__", [](const Camera& c) {
        return py::str("Camera(fx_px={:g}, fy_px={:g}, cx_px={:g}, cy_px={:g}, width_px={}, height_px={})")
            .format(c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.width_px, c.height_px);
      });
}

}  // namespace

void bind_frame(py::module_& module) {
  bind_camera(module);
  py::class_<Detection>(module, "Detection", "One detected object, in pixels of the distorted image.")
      .def(py::init(&make_detection), py::arg("box"), py::arg("class_name") = "", py::arg("score") = 1.0F,
           py::kw_only(), py::arg("class_id") = -1, py::arg("track_id") = -1, py::arg("mask") = py::none(),
           "`box`: x and y of the top left corner, width, height [px]. `score`: in [0, 1].\n"
           "`class_name`: pipelines choose classes by name, such as \"person\".\n"
           "`mask`: (height, width) uint8 or bool of the whole image, 0 outside; copied.")
      .def_property_readonly("box", &box_of, "x, y, width, height [px]")
      .def_readonly("class_name", &Detection::class_name)
      .def_readonly("score", &Detection::score)
      .def_readonly("class_id", &Detection::class_id)
      .def_readonly("track_id", &Detection::track_id)
      .def_property_readonly("mask", &mask_of, "(height, width) uint8, or None")
      .def("__repr__", &text_of);

  module.attr("keypoint_type") = keypoint_type();
  module.def(
      "read_camera",
      [](const std::string& path) {
        const io::CameraFile file = io::read_camera(path);
        return py::make_tuple(file.camera, file.depth_units_per_m);
      },
      py::arg("path"), "A camera file with the keys of ORB-SLAM settings: (Camera, DepthMapFactor or None).");
  module.def(
      "read_detections",
      [](const std::string& path) {
        std::vector<std::pair<double, std::vector<Detection>>> images;
        for (io::StampedDetections& image : io::read_detections(path).images)
          images.emplace_back(image.timestamp_s, std::move(image.detections));
        return images;
      },
      py::arg("path"), "The boxes of a detections.txt: (timestamp [s], detections) per image.");
}

}  // namespace dynfilter::python
