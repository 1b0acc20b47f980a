// SPDX-License-Identifier: MIT
#include <pybind11/stl.h>

#include <Eigen/Core>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <dynfilter/testing/judge.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "bindings.hpp"
#include "python_filter.hpp"

namespace dynfilter::python {
namespace {

using testing::ExactFrame;
using testing::ExactScene;
using testing::MovingBox;

std::vector<std::string> scene_preset_names() {
  std::vector<std::string> names;
  for (const testing::Preset preset : testing::all_presets()) names.push_back(to_string(preset));
  return names;
}

ExactScene preset_scene(const std::string& name) {
  for (const testing::Preset preset : testing::all_presets())
    if (to_string(preset) == name) return testing::preset(preset);
  refuse_name("preset", scene_preset_names(), name);
}

testing::CameraStep camera_step(const std::string& name) {
  const std::pair<const char*, testing::CameraStep> steps[] = {
      {"none", testing::CameraStep::None},
      {"general", testing::CameraStep::General},
      {"sideways", testing::CameraStep::Sideways},
      {"forward", testing::CameraStep::Forward},
      {"pure_rotation", testing::CameraStep::PureRotation},
      {"small_baseline", testing::CameraStep::SmallBaseline}};
  std::vector<std::string> known;
  for (const auto& [word, step] : steps) {
    if (name == word) return step;
    known.emplace_back(word);
  }
  refuse_name("camera_motion", known, name);
}

using Number = std::optional<double>;

struct SceneOptions {
  std::optional<int> points, late_boxes, gap;
  std::optional<std::uint64_t> seed;
  std::optional<std::string> camera_motion;
  std::optional<std::vector<MovingBox>> movers;
  Number pixel_noise_px, depth_noise_m, missing_depth, mismatches, missing_matches, stereo_baseline_m;
  bool planar, mono, boxes, poses, descriptors, map_points, matches;
};

ExactScene make_scene(const std::optional<std::string>& preset, const SceneOptions& o) {
  ExactScene scene = preset ? preset_scene(*preset) : ExactScene();
  if (o.points) scene.points(*o.points);
  if (o.seed) scene.seed(*o.seed);
  if (o.gap) scene.gap(*o.gap);
  if (o.camera_motion) scene.camera_motion(camera_step(*o.camera_motion));
  if (o.movers)
    for (const MovingBox& mover : *o.movers) scene.mover(mover);
  if (o.pixel_noise_px) scene.pixel_noise(*o.pixel_noise_px);
  if (o.depth_noise_m) scene.depth_noise(*o.depth_noise_m);
  if (o.missing_depth) scene.missing_depth(*o.missing_depth);
  if (o.mismatches) scene.mismatches(*o.mismatches);
  if (o.missing_matches) scene.missing_matches(*o.missing_matches);
  if (o.stereo_baseline_m) scene.stereo(*o.stereo_baseline_m);
  if (o.planar) scene.planar();
  if (o.mono) scene.mono();
  if (o.boxes) scene.with_detections(o.late_boxes.value_or(0));
  if (o.poses) scene.with_poses();
  if (o.descriptors) scene.with_descriptors();
  if (o.map_points) scene.with_map_points();
  if (!o.matches) scene.without_matches();
  return scene;
}

Eigen::Vector3d vector_of(const char* name, py::handle value) {
  const auto v = array_of<double>(name, value, 3);
  return {v.at(0), v.at(1), v.at(2)};
}

MovingBox make_mover(int points, py::handle at_m, py::handle step_m, py::handle turn_rad,
                     py::handle half_size_m, int still_until, const std::string& class_name) {
  MovingBox box(points);
  box.at(vector_of("at_m", at_m))
      .moving(vector_of("step_m", step_m))
      .turning(vector_of("turn_rad", turn_rad));
  return box.half_size(vector_of("half_size_m", half_size_m)).still_until(still_until).named(class_name);
}

py::array keypoints_of(const std::vector<cv::KeyPoint>& keypoints) {
  py::array array(keypoint_type(), static_cast<py::ssize_t>(keypoints.size()));
  std::copy(keypoints.begin(), keypoints.end(), static_cast<cv::KeyPoint*>(array.mutable_data()));
  return array;
}

/// The arguments of Pipeline.before_pose().
py::dict arguments_of(const ExactFrame& f) {
  py::dict a;
  a["keypoints"] = keypoints_of(f.keypoints);
  a["timestamp"] = f.timestamp_s;
  a["frame_id"] = f.id;
  a["camera"] = f.camera;
  if (!f.keypoints_undistorted.empty()) a["keypoints_undistorted"] = keypoints_of(f.keypoints_undistorted);
  if (!f.depth_m.empty()) a["depth_m"] = copy_of(f.depth_m);
  if (!f.right_u_px.empty()) a["right_u_px"] = copy_of(f.right_u_px);
  if (!f.descriptors.empty()) a["descriptors"] = array_of(f.descriptors);
  if (f.pose_provenance != PoseProvenance::None) {
    a["pose"] = matrix_of(f.T_world_camera);
    a["pose_kind"] = "estimated";
  }
  if (f.reference_frame_id >= 0) {
    a["matches"] = copy_of(f.reference_index);
    a["matches_frame_id"] = f.reference_frame_id;
  }
  if (!f.map_point_ids.empty()) {
    a["map_point_ids"] = copy_of(f.map_point_ids);
    a["map_points_m"] = copy_of(f.map_points_world_m);
  }
  if (f.detections) {
    a["boxes"] = py::cast(*f.detections);
    a["boxes_frame_id"] = f.detections_frame_id;
  }
  return a;
}

py::array truth_is(const ExactFrame& f, testing::Truth truth) {
  py::array_t<bool> out(static_cast<py::ssize_t>(f.size()));
  for (std::size_t i = 0; i < f.size(); ++i) out.mutable_data()[i] = f.truth[i] == truth;
  return std::move(out);
}

/// (votes, score) of a filter's object, or of a compiled filter with its default parameters.
py::tuple judged(py::handle filter, const ExactScene& scene, int frame) {
  const auto link = std::make_shared<FilterLink>();
  std::unique_ptr<Filter> judged;
  if (py::isinstance<py::str>(filter)) {
    const Registry all = registry(link);
    const Registry::Entry* entry = all.find(filter.cast<std::string>());
    if (entry == nullptr)
      throw py::value_error(unknown_name("filter", filter.cast<std::string>(), all.names()));
    judged = entry->make(YamlNode());
  } else {
    judged = std::make_unique<PythonFilter>(py::reinterpret_borrow<py::object>(filter), link);
  }
  Votes votes;
  try {
    votes = testing::judge(*judged, scene, frame);
  } catch (const std::exception&) {
    link->rethrow_error();
    throw;
  }
  py::array_t<std::uint8_t> decisions(static_cast<py::ssize_t>(votes.size()));
  for (std::size_t i = 0; i < votes.size(); ++i)
    decisions.mutable_data()[i] = static_cast<std::uint8_t>(votes[i]);
  return py::make_tuple(decisions, testing::Score(votes, scene.frame(frame)));
}

void bind_score(py::module_& module) {
  using testing::Score;
  py::class_<Score>(module, "Score", "Votes compared with the truth. Features in between are not counted.")
      .def(py::init<>())
      .def_readonly("dynamic_count", &Score::dynamic_count)
      .def_readonly("dynamic_found", &Score::dynamic_found)
      .def_readonly("dynamic_missed", &Score::dynamic_missed, "dynamic features that were voted static")
      .def_readonly("static_count", &Score::static_count)
      .def_readonly("static_lost", &Score::static_lost, "static features that were voted dynamic")
      .def_property_readonly("recall", &Score::recall, "share of the dynamic features that are found")
      .def_property_readonly("precision", &Score::precision,
                             "share of the rejected features that are dynamic")
      .def_property_readonly("static_kept", &Score::static_kept, "share of the static features that are kept")
      .def(
          "add",
          [](Score& self, py::handle decision, const ExactFrame& frame) {
            const auto given =
                array_of<std::uint8_t>("decision", decision, static_cast<py::ssize_t>(frame.size()));
            Votes votes;
            votes.reset(frame.size());
            for (std::size_t i = 0; i < frame.size(); ++i)
              votes.cast(i, given.data()[i] == 2   ? Vote::Dynamic
                            : given.data()[i] == 1 ? Vote::Static
                                                   : Vote::Unknown);
            self.add(votes, frame);
          },
          py::arg("decision"), py::arg("frame"), "Adds a frame. `decision`: as Verdict.decision.")
      .def("__repr__", [](const Score& s) {
        return py::str("Score(recall={:.3f}, precision={:.3f}, static_kept={:.3f})")
            .format(s.recall(), s.precision(), s.static_kept());
      });
}

void bind_exact_frame(py::module_& module) {
  py::class_<ExactFrame>(module, "ExactFrame", "One frame of an exact scene: inputs and truth per feature.")
      .def("__len__", &ExactFrame::size)
      .def_readonly("id", &ExactFrame::id)
      .def_readonly("timestamp", &ExactFrame::timestamp_s, "[s]")
      .def_readonly("camera", &ExactFrame::camera)
      .def_property_readonly(
          "pose", [](const ExactFrame& f) { return matrix_of(f.T_world_camera); },
          "(4, 4) true T_world_camera")
      .def_property_readonly(
          "keypoints", [](const ExactFrame& f) { return points_of(f.keypoints.data(), f.size()); },
          "(n, 2) float32, distorted pixels")
      .def_property_readonly(
          "depth_m", [](const ExactFrame& f) { return copy_of(f.depth_m); },
          "(n,) float32 [m]; empty for a mono scene")
      .def_property_readonly(
          "point", [](const ExactFrame& f) { return copy_of(f.point); },
          "(n,) int32, point of the scene, the same in all frames")
      .def_property_readonly(
          "label", [](const ExactFrame& f) { return copy_of(f.label); },
          "(n,) int32: 0 static background, k: mover k, moving or not")
      .def_property_readonly(
          "dynamic", [](const ExactFrame& f) { return truth_is(f, testing::Truth::Dynamic); },
          "(n,) bool: moved more than 10 mm and 1 px over the last frames")
      .def_property_readonly(
          "static", [](const ExactFrame& f) { return truth_is(f, testing::Truth::Static); },
          "(n,) bool: did not move at all")
      .def_property_readonly(
          "mismatched",
          [](const ExactFrame& f) {
            return py::array(py::dtype::of<bool>(), {static_cast<py::ssize_t>(f.mismatched.size())}, {},
                             f.mismatched.data());
          },
          "(n,) bool: the match is wrong")
      .def("arguments", &arguments_of, "All inputs as arguments: pipeline.before_pose(**frame.arguments()).");
}

}  // namespace

void bind_exact_scene(py::module_& module) {
  const py::tuple none = py::make_tuple(0, 0, 0);
  py::class_<MovingBox>(module, "MovingBox", "A rigid box of points that moves.")
      .def(py::init(&make_mover), py::arg("points") = 60, py::kw_only(),
           py::arg("at_m") = py::make_tuple(0.3, 0, 2.5), py::arg("step_m") = none,
           py::arg("turn_rad") = none, py::arg("half_size_m") = py::make_tuple(0.25, 0.5, 0.15),
           py::arg("still_until") = 0, py::arg("class_name") = "person",
           "`at_m`: centre at frame 0 in the world (x right, y down, z forward).\n"
           "`step_m`, `turn_rad`: motion per frame, which begins after frame `still_until`.\n"
           "`class_name`: what a detector calls it.");
  bind_exact_frame(module);
  bind_score(module);
  py::class_<ExactScene>(module, "ExactScene",
                         "A small scene without images and with exact truth. Deterministic per seed.")
      .def(py::init([](std::optional<std::string> preset, std::optional<int> points,
                       std::optional<std::uint64_t> seed, std::optional<std::vector<MovingBox>> movers,
                       std::optional<std::string> camera_motion, std::optional<int> gap,
                       Number pixel_noise_px, Number depth_noise_m, Number missing_depth, Number mismatches,
                       Number missing_matches, Number stereo_baseline_m, bool planar, bool mono, bool boxes,
                       std::optional<int> late_boxes, bool poses, bool descriptors, bool map_points,
                       bool matches) {
             return make_scene(
                 preset, {points, late_boxes, gap, seed, std::move(camera_motion), std::move(movers),
                          pixel_noise_px, depth_noise_m, missing_depth, mismatches, missing_matches,
                          stereo_baseline_m, planar, mono, boxes, poses, descriptors, map_points, matches});
           }),
           py::arg("preset") = py::none(), py::kw_only(), py::arg("points") = py::none(),
           py::arg("seed") = py::none(), py::arg("movers") = py::none(),
           py::arg("camera_motion") = py::none(), py::arg("gap") = py::none(),
           py::arg("pixel_noise_px") = py::none(), py::arg("depth_noise_m") = py::none(),
           py::arg("missing_depth") = py::none(), py::arg("mismatches") = py::none(),
           py::arg("missing_matches") = py::none(), py::arg("stereo_baseline_m") = py::none(),
           py::arg("planar") = false, py::arg("mono") = false, py::arg("boxes") = false,
           py::arg("late_boxes") = py::none(), py::arg("poses") = false, py::arg("descriptors") = false,
           py::arg("map_points") = false, py::arg("matches") = true,
           "`preset`: one of exact_scene_names(), or None for 300 static points.\n"
           "`movers`: are added. `gap`: frames between a frame and the reference of its matches.\n"
           "`camera_motion`: none, general, sideways, forward, pure_rotation or small_baseline.\n"
           "`depth_noise_m`: sigma at 1 m, grows with the square of the depth; 0.0014 for a Kinect.\n"
           "`stereo_baseline_m`: a stereo camera, with columns in the right image instead of depths.\n"
           "`missing_depth`, `mismatches`, `missing_matches`: shares in [0, 1].\n"
           "`boxes`, `poses`, `descriptors`, `map_points`: inputs that frames then have.\n"
           "`late_boxes`: boxes are of that many frames before.")
      .def(
          "frame",
          [](const ExactScene& scene, int k) {
            if (k < 0) throw py::value_error("k: expected 0 or more");
            return scene.frame(k);
          },
          py::arg("k"), "Frame k, 0 or more. Frames can be asked for in any order.")
      .def_property_readonly("camera", [](const ExactScene& scene) { return scene.camera(); });
  module.def("exact_scene_names", &scene_preset_names, "Scenes that are known to be difficult.");
  module.def("_judge", &judged, py::arg("filter"), py::arg("scene"), py::arg("frame"));
}

}  // namespace dynfilter::python
