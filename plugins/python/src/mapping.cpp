// SPDX-License-Identifier: MIT
#include <pybind11/stl.h>

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/mapping/static_map.hpp>
#include <memory>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "bindings.hpp"
#include "io/ply.hpp"

namespace dynfilter::python {
namespace {

using mapping::MapReport;
using mapping::StaticMap;

std::string yaml_of(py::handle value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::str>(value)) return "\"" + value.cast<std::string>() + "\"";
  if (!py::isinstance<py::sequence>(value)) return py::repr(value).cast<std::string>();
  std::string list;
  for (const py::handle item : value) list += (list.empty() ? "" : ", ") + yaml_of(item);
  return "[" + list + "]";
}

/// Keyword arguments are the keys of a map's YAML.
std::unique_ptr<StaticMap> make_map(const py::kwargs& parameters) {
  std::string text;
  for (const auto& [key, value] : parameters) text += key.cast<std::string>() + ": " + yaml_of(value) + "\n";
  const YamlDocument document = YamlDocument::from_text(text);
  return std::make_unique<StaticMap>(read_parameters<mapping::MappingParams>(document.root()));
}

std::vector<cv::Point2f> pixels_of(const char* name, py::handle value) {
  if (value.is_none()) return {};
  const auto array = array_of<float>(name, value, -1, 2);
  std::vector<cv::Point2f> pixels;
  for (py::ssize_t i = 0; i < array.shape(0); ++i) pixels.emplace_back(array.at(i, 0), array.at(i, 1));
  return pixels;
}

MapReport add(StaticMap& self, std::int64_t id, py::handle pose, py::handle camera, py::handle depth,
              double depth_unit_m, double timestamp, py::handle bgr, py::handle moving_mask,
              py::handle moving_px, py::handle still_px, py::handle boxes) {
  Images images;
  mapping::MapFrame frame;
  frame.id = id, frame.timestamp_s = timestamp, frame.depth_unit_m = depth_unit_m;
  frame.T_world_camera = pose_of("pose", pose);
  frame.camera = camera_of("camera", camera);
  if (depth.is_none()) refuse("depth", "a float32 or uint16 image", depth);
  frame.depth = images.depth("depth", depth);
  frame.bgr = images.colour("bgr", bgr);
  frame.moving_mask = images.mask("moving_mask", moving_mask);
  const std::vector<cv::Point2f> moving = pixels_of("moving_px", moving_px),
                                 still = pixels_of("still_px", still_px);
  const std::vector<Detection> detections = detections_of("boxes", boxes);
  frame.moving_px = moving, frame.still_px = still, frame.detections = detections;
  const py::gil_scoped_release no_gil;
  return self.add(frame);
}

py::tuple cloud(const StaticMap& self) {
  mapping::MapCloud cloud;
  {
    const py::gil_scoped_release no_gil;
    cloud = self.cloud();
  }
  const auto n = static_cast<py::ssize_t>(cloud.size());
  py::array_t<std::uint8_t> colours({n, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c)  // red, green, blue: what viewers take
      colours.mutable_at(i, c) =
          cloud.colours.empty() ? std::uint8_t{128} : cloud.colours[static_cast<std::size_t>(i)][2 - c];
  const py::array_t<int> classes(static_cast<py::ssize_t>(cloud.classes.size()), cloud.classes.data());
  return py::make_tuple(copy_of(cloud.points_m), colours, classes);
}

void write_ply(const StaticMap& self, const std::string& path) {
  const mapping::MapCloud cloud = self.cloud();
  io::write_ply(path, cloud.points_m, cloud.colours, cloud.classes);
}

}  // namespace

void bind_mapping(py::module_& module) {
  py::class_<MapReport>(module, "MapReport", "What the map did with a frame.")
      .def_readonly("used", &MapReport::used)
      .def_readonly("note", &MapReport::note)
      .def_readonly("pixels", &MapReport::pixels, "with usable depth")
      .def_readonly("cut_pixels", &MapReport::cut_pixels, "of these: removed as moving")
      .def_readonly("points", &MapReport::points)
      .def_readonly("new_voxels", &MapReport::new_voxels)
      .def_readonly("time_ms", &MapReport::time_ms);
  py::class_<StaticMap>(module, "StaticMap", "The dense map of the static scene, built from keyframes.")
      .def(py::init(&make_map),
           "Keyword arguments are the map's parameters: leaf_m=0.02, max_depth_m=5, carve=True, ...\n"
           "Raises ConfigError that lists them.")
      .def("add", &add, py::arg("id"), py::arg("pose"), py::kw_only(), py::arg("camera"), py::arg("depth"),
           py::arg("depth_unit_m") = 1.0, py::arg("timestamp") = 0.0, py::arg("bgr") = py::none(),
           py::arg("moving_mask") = py::none(), py::arg("moving_px") = py::none(),
           py::arg("still_px") = py::none(), py::arg("boxes") = py::tuple(),
           "Fuses a keyframe.\n"
           "`pose`: (4, 4) T_world_camera. `depth`: (height, width) float32 or uint16, in depth_unit_m.\n"
           "`bgr`: uint8. `moving_mask`: uint8 or bool, not 0: moving. `moving_px`, `still_px`: (n, 2) "
           "features\n"
           "that a pipeline rejected or called static. `boxes`: list of Detection.")
      .def("remove", &StaticMap::remove, py::arg("id"), "The map is then as if it had never been added.")
      .def(
          "move",
          [](StaticMap& self, std::int64_t id, py::handle pose) {
            return self.move(id, pose_of("pose", pose));
          },
          py::arg("id"), py::arg("pose"), "After a loop closure. False: unknown, or no longer movable.")
      .def("cloud", &cloud,
           "(points_m (n, 3) float32, colours (n, 3) uint8 red green blue, classes (n,) int32)")
      .def("write_ply", &write_ply, "Writes the cloud as a PLY file. Raises IoError.", py::arg("path"))
      .def_property_readonly("leaf_m", &StaticMap::leaf_m);
}

}  // namespace dynfilter::python
