// SPDX-License-Identifier: MIT
#include "verdict.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <dynfilter/detectors/image_encoder.hpp>
#include <dynfilter/hosts/draw_verdict.hpp>
#include <dynfilter/hosts/host_mask.hpp>
#include <optional>
#include <string>

#include "arguments.hpp"
#include "bindings.hpp"

namespace dynfilter::python {
namespace {

constexpr const char* kDrop255 = "255_drops";
constexpr const char* kDrop0 = "0_drops";

MaskPolarity polarity_of(const std::string& name) {
  if (name == kDrop255) return MaskPolarity::NonzeroDrops;
  if (name == kDrop0) return MaskPolarity::ZeroDrops;
  refuse_name("polarity", {"255_drops", "0_drops"}, name);
}

/// Without a radius, that of the sensor.
HostMask host_mask(std::optional<double> radius_px, double keep_radius_px, const std::string& polarity) {
  MaskedImageParams params;
  if (radius_px) params.radius_px = params.radius_without_depth_px = *radius_px;
  params.keep_radius_px = keep_radius_px;
  return HostMask(polarity_of(polarity), params);
}

cv::Size size_of(py::handle shape) {
  if (!py::isinstance<py::sequence>(shape) || py::len(shape) < 2)
    refuse("shape", "(height, width), as image.shape gives it", shape);
  return {shape[py::int_(1)].cast<int>(), shape[py::int_(0)].cast<int>()};
}

py::array mask(const PyVerdict& self, py::handle shape, std::optional<double> radius_px,
               double keep_radius_px, const std::string& polarity, bool rgbd, py::handle right_u) {
  HostMask host = host_mask(radius_px, keep_radius_px, polarity);
  const cv::Size size = size_of(shape);
  if (rgbd) return array_of(host.rgbd_image(self.keypoints, self.verdict, size));
  if (right_u.is_none()) return array_of(host.image(self.keypoints, self.verdict, size));
  const auto columns = array_of<float>("right_u", right_u, static_cast<py::ssize_t>(self.keypoints.size()));
  const Span<const float> right_u_px(columns.data(), self.keypoints.size());
  return array_of(host.right_image(self.keypoints, self.verdict, right_u_px, size));
}

py::array depth(const PyVerdict& self, py::handle depth, std::optional<double> radius_px,
                double keep_radius_px) {
  if (depth.is_none()) refuse("depth", "a float32 or uint16 image", depth);
  Images images;
  const cv::Mat given = images.depth("depth", depth);
  HostMask host = host_mask(radius_px, keep_radius_px, kDrop255);
  return array_of(host.depth(self.keypoints, self.verdict, given));
}

py::array draw(const PyVerdict& self, py::handle image) {
  Images images;
  return array_of(draw_verdict(images.colour("image", image), self.keypoints, self.verdict));
}

/// What is behind the features if the image is gone: as large as they reach.
cv::Mat paper(const std::vector<cv::KeyPoint>& keypoints) {
  constexpr float kMargin_px = 16, kMost_px = 8192;
  constexpr int kDark = 28;
  cv::Point2f corner(64, 48);
  for (const cv::KeyPoint& k : keypoints)
    corner = {std::max(corner.x, std::min(k.pt.x, kMost_px)), std::max(corner.y, std::min(k.pt.y, kMost_px))};
  return {cvCeil(corner.y + kMargin_px), cvCeil(corner.x + kMargin_px), CV_8UC3, cv::Scalar::all(kDark)};
}

py::bytes png(const PyVerdict& self) {
  const py::object alive = self.image.is_none() ? py::none() : self.image();
  Images images;
  const cv::Mat background = alive.is_none() ? paper(self.keypoints) : images.colour("image", alive);
  const std::vector<std::uint8_t> bytes =
      io::encode_png(draw_verdict(background, self.keypoints, self.verdict));
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::vector<std::string> reasons(const PyVerdict& self) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < self.verdict.size(); ++i) texts.push_back(self.verdict.reason(i));
  return texts;
}

std::vector<std::string> stage_names(const FrameReport& report) {
  std::vector<std::string> names;
  for (const StageReport& stage : report.stages) names.push_back(stage.name);
  return names;
}

py::array rejected_by(const PyVerdict& self, const std::string& stage) {
  std::uint64_t bits = 0;
  const std::vector<std::string> names = stage_names(self.verdict.report);
  for (std::size_t k = 0; k < names.size() && k < 64; ++k)
    if (names[k] == stage) bits |= std::uint64_t{1} << k;
  if (bits == 0) refuse_name("stage", names, stage);
  py::array_t<bool> out(static_cast<py::ssize_t>(self.verdict.size()));
  for (std::size_t i = 0; i < self.verdict.size(); ++i)
    out.mutable_data()[i] = !self.verdict.keep(i) && (self.verdict.reasons[i] & bits) != 0;
  return std::move(out);
}

py::array rejected_ids(const PyVerdict& self, py::handle ids) {
  const auto n = static_cast<py::ssize_t>(self.verdict.size());
  const auto given = array_of<std::int64_t>("ids", ids, n);
  std::vector<std::int64_t> rejected;
  dynfilter::rejected_ids(self.verdict, std::vector<std::int64_t>(given.data(), given.data() + n), rejected);
  return copy_of(rejected);
}

void bind_report(py::module_& module) {
  py::class_<StageReport>(module, "StageReport", "What one stage did with one frame.")
      .def_readonly("name", &StageReport::name)
      .def_readonly("path", &StageReport::path, "place in the pipeline file")
      .def_readonly("skipped", &StageReport::skipped, "an input was missing: see note")
      .def_readonly("failed", &StageReport::failed, "it raised: see note; its votes count as unknown")
      .def_readonly("note", &StageReport::note)
      .def_readonly("judged", &StageReport::judged)
      .def_readonly("dynamic", &StageReport::dynamic)
      .def_readonly("unknown", &StageReport::unknown)
      .def_readonly("prior", &StageReport::prior, "suspects, kept out of the fit of models")
      .def_readonly("time_ms", &StageReport::time_ms)
      .def("__repr__", [](const StageReport& s) {
        return "StageReport(" + s.name + ": " + std::to_string(s.dynamic) + " of " +
               std::to_string(s.judged) + " dynamic" + (s.note.empty() ? "" : "; " + s.note) + ")";
      });
  py::class_<FrameReport>(module, "Report", "What the pipeline did with one frame.")
      .def_readonly("frame_id", &FrameReport::frame_id)
      .def_property_readonly("call_point", [](const FrameReport& r) { return to_string(r.call_point); })
      .def_readonly("stages", &FrameReport::stages)
      .def_readonly("notes", &FrameReport::notes, "resets, the floor, inputs that could not be used")
      .def_readonly("features", &FrameReport::features)
      .def_readonly("rejected", &FrameReport::rejected)
      .def_readonly("restored", &FrameReport::restored, "judged dynamic, but brought back by the floor")
      .def_readonly("wait_for_keyframe", &FrameReport::wait_for_keyframe,
                    "before the first keyframe: wait with it")
      .def_readonly("doubts", &FrameReport::doubts, "resets by the self-check so far")
      .def_readonly("correspondence_ms", &FrameReport::correspondence_ms)
      .def_readonly("total_ms", &FrameReport::total_ms, "in C++, without Python's own time")
      .def("__str__", &summary_line)
      .def("__repr__", [](const FrameReport& r) { return "Report(" + summary_line(r) + ")"; });
}

}  // namespace

void bind_verdict(py::module_& module) {
  module.attr("UNKNOWN") = static_cast<int>(Vote::Unknown);
  module.attr("STATIC") = static_cast<int>(Vote::Static);
  module.attr("DYNAMIC") = static_cast<int>(Vote::Dynamic);
  bind_report(module);
  const auto bytes = [](std::vector<std::uint8_t> Verdict::*member) {
    return [member](py::object self) {
      const auto& values = self.cast<const PyVerdict&>().verdict.*member;
      return shown(py::dtype::of<bool>(), values.data(), values.size(), self);
    };
  };
  py::class_<PyVerdict>(
      module, "Verdict",
      "The decision per feature, in the order of the keypoints. Arrays are read-only views.")
      .def("__len__", [](const PyVerdict& v) { return v.verdict.size(); })
      .def_property_readonly(
          "keep",
          [](py::object self) {
            const auto& keep = self.cast<const PyVerdict&>().keep;
            return shown(py::dtype::of<bool>(), keep.data(), keep.size(), self);
          },
          "(n,) bool: False on something that moves. Unknown features are kept.")
      .def_property_readonly(
          "decision",
          [](py::object self) {
            const auto& decision = self.cast<const PyVerdict&>().verdict.decision;
            return shown(py::dtype::of<std::uint8_t>(), decision.data(), decision.size(), self);
          },
          "(n,) uint8: 0 unknown, 1 static, 2 dynamic")
      .def_property_readonly(
          "suspicion",
          [](py::object self) {
            const auto& suspicion = self.cast<const PyVerdict&>().verdict.suspicion;
            return shown(py::dtype::of<float>(), suspicion.data(), suspicion.size(), self);
          },
          "(n,) float32 in [0, 1]; 0.5: no stage has an idea")
      .def_property_readonly(
          "weight",
          [](py::object self) {
            const auto& weight = self.cast<const PyVerdict&>().weight;
            return shown(py::dtype::of<float>(), weight.data(), weight.size(), self);
          },
          "(n,) float32 in [0, 1]: what an optimiser multiplies the feature's information (1 / sigma^2) "
          "with;\n"
          "the probability that it stands still, times how well its match is determined")
      .def_property_readonly("prior", bytes(&Verdict::prior), "(n,) bool: a semantic stage suspects it")
      .def_property_readonly("restored", bytes(&Verdict::restored),
                             "(n,) bool: judged dynamic, but brought back by the floor")
      .def_property_readonly(
          "reason_bits",
          [](py::object self) {
            const auto& reasons = self.cast<const PyVerdict&>().verdict.reasons;
            return shown(py::dtype::of<std::uint64_t>(), reasons.data(), reasons.size(), self);
          },
          "(n,) uint64: bit k means that stages[k] judged it dynamic")
      .def_property_readonly("reasons", &reasons,
                             "list of n texts such as \"epipolar+semantic_box\"; \"\": none")
      .def_property_readonly(
          "stages", [](const PyVerdict& v) { return stage_names(v.verdict.report); }, "names of the stages")
      .def_property_readonly(
          "report", [](const PyVerdict& v) -> const FrameReport& { return v.verdict.report; },
          py::return_value_policy::reference_internal)
      .def_property_readonly(
          "map_points",
          [](const PyVerdict& v) {
            py::list list;
            for (const MapPointVerdict& p : v.verdict.map_points)
              list.append(py::make_tuple(p.map_point_id, static_cast<int>(p.vote), p.suspicion));
            return list;
          },
          "at a keyframe: (map point id, decision, suspicion) of each feature with a map point")
      .def("rejected_by", &rejected_by, py::arg("stage"), "(n,) bool: rejected, and this stage said so.")
      .def("rejected_ids", &rejected_ids, py::arg("ids"),
           "The ids of rejected features, int64. `ids`: (n,) integers of the host.")
      .def("mask", &mask, py::arg("shape"), py::kw_only(), py::arg("radius_px") = py::none(),
           py::arg("keep_radius_px") = 7.0, py::arg("polarity") = kDrop255, py::arg("rgbd") = false,
           py::arg("right_u") = py::none(),
           "(height, width) uint8 for hosts that take a mask: discs around rejected features, none of a kept "
           "one."
           "\n`shape`: image.shape. `radius_px`: of a disc at octave 0, 1.2 times more per octave.\n"
           "None: 14 for a host with depth images (`rgbd=True`), else 7.\n"
           "`right_u`: columns of the features in the right image, for a mask of that; -1: no match.\n"
           "`keep_radius_px`: a kept feature protects its surroundings up to here.\n"
           "`polarity`: \"255_drops\" (OpenVINS, cuVSLAM) or \"0_drops\" (stella_vslam, pySLAM, Kimera-VIO).")
      .def("depth", &depth, py::arg("depth"), py::kw_only(), py::arg("radius_px") = py::none(),
           py::arg("keep_radius_px") = 7.0,
           "A copy of a depth image with zero on the discs of mask(rgbd=True), for hosts that drop features "
           "without depth.")
      .def("draw", &draw, py::arg("image"),
           "A colour copy (BGR) of a uint8 image: green kept, red rejected, yellow restored.")
      .def("_repr_png_", &png, "The picture that a notebook shows: on the frame's image while that exists.")
      .def("__repr__", [](const PyVerdict& v) { return "Verdict(" + summary_line(v.verdict.report) + ")"; });
}

}  // namespace dynfilter::python
