// SPDX-License-Identifier: MIT
#include <pybind11/stl.h>

#include <dynfilter/detectors/image_file.hpp>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "arguments.hpp"
#include "bindings.hpp"
#include "io/sequence.hpp"
#include "render/scene_file.hpp"
#include "render/scenes.hpp"
#include "render/sequence_renderer.hpp"
#include "trajectory.hpp"

namespace dynfilter::python {
namespace {

py::object array_or_none(const cv::Mat& image) {
  return image.empty() ? py::object(py::none()) : py::object(array_of(image));
}

std::size_t checked_index(std::int64_t i, std::size_t size) {
  const auto n = static_cast<std::int64_t>(size);
  if (i < -n || i >= n) throw py::index_error("frame " + std::to_string(i) + " of " + std::to_string(n));
  return static_cast<std::size_t>(i < 0 ? i + n : i);
}

/// Arguments of dynfilter.sequences.Frame; None where a video or a camera ended.
py::object read(const io::Sequence& sequence, std::int64_t index) {
  const std::size_t i = checked_index(index, sequence.size());
  std::optional<io::SequenceFrame> found;
  cv::Mat truth, labels;
  {
    const py::gil_scoped_release no_gil;
    found = sequence.read(i);
    if (found && sequence.has_labels()) truth = sequence.load_truth(i), labels = sequence.load_labels(i);
  }
  if (!found) return py::none();
  const io::SequenceFrame& frame = *found;
  py::dict out;
  out["timestamp"] = frame.timestamp_s;
  out["colour"] = array_of(frame.colour);
  out["grey"] = array_of(frame.grey);
  out["right"] = array_or_none(frame.right);
  out["depth"] = array_or_none(frame.depth);
  out["depth_unit_m"] = frame.depth_unit_m;
  out["truth"] = array_or_none(truth);
  out["labels"] = array_or_none(labels);
  return out;
}

py::object loaded(const io::Sequence& sequence, std::int64_t index) {
  py::object frame = read(sequence, index);
  if (frame.is_none()) throw py::index_error("frame " + std::to_string(index) + ": the video ended before");
  return frame;
}

py::dict rendered(render::SequenceRenderer& renderer, std::int64_t index) {
  const std::size_t i = checked_index(index, static_cast<std::size_t>(renderer.size()));
  render::RenderedFrame frame;
  cv::Mat grey, right;
  {
    const py::gil_scoped_release no_gil;
    frame = renderer.frame(static_cast<int>(i));
    cv::cvtColor(frame.colour, grey, cv::COLOR_BGR2GRAY);
    if (!frame.right.empty()) cv::cvtColor(frame.right, right, cv::COLOR_BGR2GRAY);
  }
  py::dict out;
  out["timestamp"] = frame.timestamp_s;
  out["colour"] = array_of(frame.colour);
  out["grey"] = array_of(grey);
  out["depth"] = array_of(frame.depth);
  out["right"] = array_or_none(right);
  out["depth_unit_m"] = 1 / renderer.scene().camera_model.depth_units_per_m;
  out["truth"] = array_of(frame.truth.dynamic);
  out["labels"] = array_of(frame.truth.labels);
  out["mask"] = array_of(frame.truth.person);
  out["pose"] = matrix_of(frame.T_world_camera);
  if (frame.detections) {
    out["boxes"] = py::cast(*frame.detections);
    out["boxes_frame_id"] = frame.detected_on_frame;
  }
  return out;
}

std::unique_ptr<render::SequenceRenderer> make_renderer(const std::string& scene, int frames,
                                                        std::uint64_t seed, std::optional<double> rate_hz,
                                                        bool motion_blur, bool exposure_variation,
                                                        double image_noise, bool perfect_depth,
                                                        int late_boxes, bool right_images) {
  render::SequenceOptions options;
  options.scene = scene, options.frames = frames, options.seed = seed, options.rate_hz = rate_hz;
  options.motion_blur = motion_blur, options.exposure_variation = exposure_variation;
  options.image_noise = image_noise, options.perfect_depth = perfect_depth;
  options.detector.late_frames = late_boxes;
  options.right_images = right_images;
  return std::make_unique<render::SequenceRenderer>(options);
}

io::Sequence open_recording(const std::string& source, const std::optional<Camera>& camera,
                            std::optional<double> rate_hz, double scale) {
  if (!(scale > 0 && scale <= 1)) refuse("scale", "a number above 0 and at most 1", py::float_(scale));
  io::SequenceOptions options;
  options.camera = camera, options.rate_hz = rate_hz, options.scale = scale;
  return io::Sequence::open(source, options);
}

std::string sensor_of(const io::Sequence& sequence) {
  if (!sequence.sensor().empty()) return sequence.sensor();
  return sequence.has_depth() ? "rgbd" : sequence.has_stereo() ? "stereo" : "mono";
}

/// "" for what `synth` did not write.
std::string scene_of(const io::Sequence& sequence) {
  const auto rendered = render::read_scene_name(sequence.folder());
  return rendered ? rendered->scene : "";
}

}  // namespace

void bind_sequences(py::module_& module) {
  py::class_<io::Sequence>(module, "_Reader")
      .def(py::init(&open_recording), py::arg("source"), py::arg("camera") = py::none(),
           py::arg("rate_hz") = py::none(), py::arg("scale") = 1.0)
      .def("__len__", &io::Sequence::size)
      .def("load", &loaded, py::arg("i"))
      .def("read", &read, py::arg("i"))
      .def(
          "timestamp", [](const io::Sequence& s, std::size_t i) { return s.timestamp_s(i); }, py::arg("i"))
      .def("image_name", &io::Sequence::image_name, py::arg("i"))
      .def("ground_truth",
           [](const io::Sequence& s) {
             const auto truth = s.ground_truth();
             return truth ? py::object(arrays_of(*truth)) : py::object(py::none());
           })
      .def_property_readonly("camera", &io::Sequence::camera)
      .def_property_readonly("name", &io::Sequence::name)
      .def_property_readonly("sensor", &sensor_of)
      .def_property_readonly("has_labels", &io::Sequence::has_labels)
      .def_property_readonly("scene", &scene_of)
      .def_property_readonly("is_stream", &io::Sequence::is_stream)
      .def_property_readonly("camera_is_guessed", &io::Sequence::camera_is_guessed)
      .def_property_readonly("notes", &io::Sequence::notes);
  py::class_<render::SequenceRenderer>(module, "_Renderer")
      .def(py::init(&make_renderer), py::arg("scene"), py::arg("frames"), py::arg("seed"), py::arg("rate_hz"),
           py::arg("motion_blur"), py::arg("exposure_variation"), py::arg("image_noise"),
           py::arg("perfect_depth"), py::arg("late_boxes"), py::arg("right_images"))
      .def("__len__", &render::SequenceRenderer::size)
      .def("load", &rendered, py::arg("i"))
      .def(
          "timestamp", [](const render::SequenceRenderer& r, int i) { return r.timestamp_s(i); },
          py::arg("i"))
      .def(
          "pose", [](const render::SequenceRenderer& r, int i) { return matrix_of(r.pose(i)); }, py::arg("i"))
      .def_property_readonly("camera", &render::SequenceRenderer::calibration);
  module.def("scene_names", &render::scene_names, "Scenes that render() draws.");
  module.def(
      "_read_mask", [](const std::string& path) { return array_of(io::read_label_image(path)); },
      py::arg("path"));
}

}  // namespace dynfilter::python
