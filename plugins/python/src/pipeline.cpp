// SPDX-License-Identifier: MIT
#include "pipeline.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <dynfilter/core/error.hpp>
#include <dynfilter/pipeline/compose.hpp>
#include <dynfilter/pipeline/frame_observer.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <dynfilter/pipeline/stage.hpp>
#include <limits>
#include <optional>
#include <running/distinct_names.hpp>
#include <running/oracle_filter.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "registered.hpp"
#include "verdict.hpp"

namespace dynfilter::python {
namespace {

PoseProvenance provenance_of(py::handle kind, CallPoint point) {
  if (kind.is_none())
    return point == CallPoint::BeforePose ? PoseProvenance::Predicted : PoseProvenance::Estimated;
  const auto name = py::str(kind).cast<std::string>();
  if (name == "predicted") return PoseProvenance::Predicted;
  if (name == "estimated") return PoseProvenance::Estimated;
  if (name == "refined") return PoseProvenance::Refined;
  refuse_name("pose_kind", {"predicted", "estimated", "refined"}, name);
}

int min_features_of(py::handle given) {
  const std::int64_t n = integer_of("min_features", given);
  if (n < 0 || n > std::numeric_limits<int>::max())
    throw py::value_error("min_features: expected 0 or more, got " + std::to_string(n));
  return static_cast<int>(n);
}

/// A keyframe that shares map points with the current frame.
struct Keyframe {
  std::int64_t id;
  Pose T_world_camera;
  std::vector<cv::KeyPoint> keypoints;
  std::vector<float> depth_m;
  std::vector<std::int64_t> map_point_ids;

  KeyframeView view() const { return {id, T_world_camera, keypoints, depth_m, map_point_ids}; }
};

template <class T>
std::vector<T> vector_of(const py::array_t<T>& array) {
  return {array.data(), array.data() + array.size()};
}

Keyframe make_keyframe(std::int64_t id, py::handle pose, py::handle keypoints, py::handle depth_m,
                       py::handle map_point_ids) {
  Keyframe keyframe{id, pose_of("pose", pose), {}, {}, {}};
  Keypoints features;
  features.assign("keypoints", keypoints, py::none());
  keyframe.keypoints.assign(features.data(), features.data() + features.size());
  const auto n = static_cast<py::ssize_t>(features.size());
  if (!depth_m.is_none()) keyframe.depth_m = vector_of(array_of<float>("depth_m", depth_m, n));
  if (!map_point_ids.is_none())
    keyframe.map_point_ids = vector_of(array_of<std::int64_t>("map_point_ids", map_point_ids, n));
  return keyframe;
}

/// The arguments of one call, which the frame view refers to.
struct FrameData {
  FrameView view;
  Keypoints keypoints, undistorted;
  Images images;
  std::vector<py::object> kept;
  std::vector<Detection> boxes;
  std::vector<KeyframeView> keyframe_views;

  template <class T>
  Span<const T> per_feature(const char* name, py::handle value, py::ssize_t columns = 0) {
    const auto array = python::array_of<T>(name, value, static_cast<py::ssize_t>(keypoints.size()), columns);
    kept.push_back(array);
    return {array.data(), keypoints.size()};
  }
};

/// The arguments of before_pose(), in their order.
struct FrameArguments {
  py::handle keypoints, timestamp, frame_id, octaves, keypoints_undistorted, descriptors, depth_m, right_u_px,
      grey, depth, depth_unit_m, camera, pose, pose_kind, boxes, boxes_frame_id, mask, mask_frame_id, matches,
      matches_frame_id, map_point_ids, map_points_m, keyframes, min_features, motion_prior, right_grey;
};

class PyPipeline {
 public:
  explicit PyPipeline(py::handle source)
      : link_(std::make_shared<FilterLink>()), pipeline_(config_of(source, link_)) {}

  std::unique_ptr<PyVerdict> process(const FrameArguments& a, CallPoint point) {
    if (busy_.exchange(true))
      throw std::runtime_error("a pipeline judges one camera stream, from one thread at a time");
    const Release release{*this};
    fill(a, point);
    const HostLimits limits{min_features_of(a.min_features)};
    link_->images = &data_.images;
    auto result = std::make_unique<PyVerdict>();
    {
      const py::gil_scoped_release no_gil;
      result->verdict = pipeline_.process(data_.view, point, limits);
      result->keypoints.assign(data_.keypoints.data(), data_.keypoints.data() + data_.keypoints.size());
      result->keep.resize(result->verdict.size());
      result->weight.resize(result->verdict.size());
      for (std::size_t i = 0; i < result->keep.size(); ++i) {
        result->keep[i] = result->verdict.keep(i) ? 1 : 0;
        result->weight[i] = result->verdict.weight(i);
      }
    }
    link_->rethrow_error();
    if (py::isinstance<py::array>(a.grey)) result->image = py::weakref(a.grey);
    return result;
  }

  void prepare(py::handle grey, double timestamp) {
    if (busy_.exchange(true)) throw std::runtime_error("prepare() runs before before_pose(), not beside it");
    const Release release{*this};
    Images images;
    const cv::Mat image = images.grey("grey", grey);
    const py::gil_scoped_release no_gil;
    pipeline_.prepare(image, timestamp);
  }
  void update_pose(std::int64_t frame_id, py::handle pose, py::handle kind, py::handle keypoints,
                   py::handle map_point_ids, std::size_t inliers, std::size_t outliers) {
    Keypoints features;
    if (!keypoints.is_none()) features.assign("keypoints", keypoints, py::none());
    std::vector<std::int64_t> ids;
    if (!map_point_ids.is_none())
      ids = vector_of(
          array_of<std::int64_t>("map_point_ids", map_point_ids, static_cast<py::ssize_t>(features.size())));
    pipeline_.update_pose(frame_id, pose_of("pose", pose), provenance_of(kind, CallPoint::AfterPose),
                          {{features.data(), features.size()}, ids, inliers, outliers});
  }
  void lost() { pipeline_.lost(); }
  std::vector<std::int64_t> moved_map_points() const { return pipeline_.moved_map_points(); }
  void reset() {
    pipeline_.reset();
    last_id_.reset();
  }
  void record(const std::string& file, int max_mb, bool images) {
    const py::gil_scoped_release no_gil;  // the last recording may have images to write
    pipeline_.set_observer(nullptr);
    if (file.empty()) return;
    RecordingParams params;
    params.max_mb = max_mb, params.images = images;
    pipeline_.set_observer(open_recording(file, params));
  }
  const std::string& name() const { return pipeline_.name(); }
  std::string needs() const { return to_string(pipeline_.needs().required | pipeline_.needs().optional); }
  std::string tree() const {
    std::string text;
    for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
      const Stage* root = pipeline_.stages(point);
      if (root == nullptr) continue;
      text += std::string(to_string(point)) + "\n";
      root->for_each([&](const Stage& stage, int depth) {
        text += std::string(2 * static_cast<std::size_t>(depth + 1), ' ') + stage.name() + "\n";
      });
    }
    return text;
  }

 private:
  /// Lets go of the caller's arrays at the end of a call.
  struct Release {
    PyPipeline& owner;
    ~Release() {
      owner.data_.images.clear(), owner.data_.kept.clear();
      owner.link_->images = nullptr;
      owner.busy_ = false;
    }
  };

  void fill(const FrameArguments& a, CallPoint point) {
    FrameView& view = data_.view = FrameView();
    data_.keypoints.assign("keypoints", a.keypoints, a.octaves);
    view.keypoints = {data_.keypoints.data(), data_.keypoints.size()};
    view.timestamp_s = number_of("timestamp", a.timestamp);
    view.id = frame_id(a.frame_id, view.timestamp_s);
    fill_features(a);
    fill_images(a);
    fill_camera(a, point);
    fill_semantics(a);
    fill_matches(a);
  }

  /// A new timestamp is a new frame.
  std::int64_t frame_id(py::handle given, double timestamp_s) {
    const std::int64_t same = last_id_.value_or(0);
    const bool is_new = !last_id_ || timestamp_s != last_timestamp_s_;
    const std::int64_t id = !given.is_none()     ? integer_of("frame_id", given)
                            : last_id_ && is_new ? same + 1
                                                 : same;
    if (!last_id_ || id != *last_id_) previous_id_ = last_id_;
    last_id_ = id, last_timestamp_s_ = timestamp_s;
    return id;
  }

  void fill_features(const FrameArguments& a) {
    FrameView& view = data_.view;
    const auto n = static_cast<py::ssize_t>(data_.keypoints.size());
    if (!a.keypoints_undistorted.is_none()) {
      data_.undistorted.assign("keypoints_undistorted", a.keypoints_undistorted, a.octaves, n);
      view.keypoints_undistorted = {data_.undistorted.data(), data_.undistorted.size()};
    }
    if (!a.depth_m.is_none()) view.depth_m = data_.per_feature<float>("depth_m", a.depth_m);
    if (!a.right_u_px.is_none()) view.right_u_px = data_.per_feature<float>("right_u_px", a.right_u_px);
    if (!a.map_point_ids.is_none())
      view.map_point_ids = data_.per_feature<std::int64_t>("map_point_ids", a.map_point_ids);
    if (!a.map_points_m.is_none()) {
      const Span<const float> points = data_.per_feature<float>("map_points_m", a.map_points_m, 3);
      view.map_points_world_m = {reinterpret_cast<const cv::Point3f*>(points.data()),  // NOLINT: three floats
                                 points.size()};
    }
    view.descriptors = data_.images.grey("descriptors", a.descriptors);
    if (!a.descriptors.is_none() && view.descriptors.rows != n)
      refuse("descriptors", "uint8 of shape (" + std::to_string(n) + ", bytes)", a.descriptors);
    data_.keyframe_views.clear();
    if (!py::isinstance<py::sequence>(a.keyframes))
      refuse("keyframes", "a list of dynfilter.Keyframe", a.keyframes);
    for (const py::handle keyframe : a.keyframes) {
      if (!py::isinstance<Keyframe>(keyframe)) refuse("keyframes", "a list of dynfilter.Keyframe", keyframe);
      data_.keyframe_views.push_back(keyframe.cast<const Keyframe&>().view());
    }
    view.covisible_keyframes = data_.keyframe_views;
  }

  void fill_images(const FrameArguments& a) {
    FrameView& view = data_.view;
    view.grey = data_.images.grey("grey", a.grey);
    view.depth = data_.images.depth("depth", a.depth);
    if (!a.depth_unit_m.is_none()) view.depth_unit_m = positive_of("depth_unit_m", a.depth_unit_m);
    if (view.depth.type() == CV_16UC1 && !view.depth.empty() && a.depth_unit_m.is_none())
      throw py::value_error(
          "depth_unit_m: needed for a uint16 depth image: 1/5000 for TUM, 0.001 for millimetres");
    if (!view.depth.empty() && !view.grey.empty() && view.depth.size() != view.grey.size())
      refuse("depth", "the size of `grey`", a.depth);
    view.right_grey = data_.images.grey("right_grey", a.right_grey);
    if (!view.right_grey.empty() && view.right_grey.size() != view.grey.size())
      refuse("right_grey", "the size of `grey`", a.right_grey);
  }

  void fill_camera(const FrameArguments& a, CallPoint point) {
    FrameView& view = data_.view;
    if (!a.camera.is_none()) {
      Camera camera = camera_of("camera", a.camera);
      view.camera = camera;
      const cv::Size image = view.grey.empty() ? view.depth.size() : view.grey.size();
      if (camera.width_px == 0) camera.width_px = image.width;
      if (camera.height_px == 0) camera.height_px = image.height;
      checked_camera("camera", camera);
    }
    view.motion_prior = motion_prior_of("motion_prior", a.motion_prior);
    if (a.pose.is_none()) return;
    view.T_world_camera = pose_of("pose", a.pose);
    view.pose_provenance = provenance_of(a.pose_kind, point);
  }

  void fill_semantics(const FrameArguments& a) {
    FrameView& view = data_.view;
    const auto id = [](const char* name, py::handle given) {
      return given.is_none() ? -1 : integer_of(name, given);
    };
    if (!a.boxes.is_none()) {
      data_.boxes = detections_of("boxes", a.boxes);
      view.detections = DetectionInput{id("boxes_frame_id", a.boxes_frame_id), data_.boxes};
    }
    if (!a.mask.is_none())
      view.mask = MaskInput{id("mask_frame_id", a.mask_frame_id), data_.images.mask("mask", a.mask)};
  }

  void fill_matches(const FrameArguments& a) {
    if (a.matches.is_none()) return;
    const Span<const std::int32_t> index = data_.per_feature<std::int32_t>("matches", a.matches);
    const std::int64_t reference = !a.matches_frame_id.is_none()
                                       ? integer_of("matches_frame_id", a.matches_frame_id)
                                       : previous_id_.value_or(-1);
    data_.view.matches = HostMatches{reference, index};
  }

  std::shared_ptr<FilterLink> link_;
  Pipeline pipeline_;
  FrameData data_;
  std::optional<std::int64_t> last_id_, previous_id_;
  double last_timestamp_s_ = 0;
  std::atomic<bool> busy_{false};
};

template <CallPoint kPoint>
std::unique_ptr<PyVerdict> call(PyPipeline& self, py::handle keypoints, py::handle timestamp,
                                py::handle frame_id, py::handle octaves, py::handle keypoints_undistorted,
                                py::handle descriptors, py::handle depth_m, py::handle right_u_px,
                                py::handle grey, py::handle depth, py::handle depth_unit_m, py::handle camera,
                                py::handle pose, py::handle pose_kind, py::handle boxes,
                                py::handle boxes_frame_id, py::handle mask, py::handle mask_frame_id,
                                py::handle matches, py::handle matches_frame_id, py::handle map_point_ids,
                                py::handle map_points_m, py::handle keyframes, py::handle min_features,
                                py::handle motion_prior, py::handle right_grey) {
  return self.process({keypoints,      timestamp,    frame_id,      octaves,      keypoints_undistorted,
                       descriptors,    depth_m,      right_u_px,    grey,         depth,
                       depth_unit_m,   camera,       pose,          pose_kind,    boxes,
                       boxes_frame_id, mask,         mask_frame_id, matches,      matches_frame_id,
                       map_point_ids,  map_points_m, keyframes,     min_features, motion_prior,
                       right_grey},
                      kPoint);
}

constexpr const char* kCallDoc =
    "Judges the features of one frame.\n\n"
    "keypoints: (n, 2) float32 distorted pixels, a list of cv2.KeyPoint, or an array of `keypoint_type`.\n"
    "timestamp: [s], grows from frame to frame.\n"
    "frame_id: by default frames are counted: a new timestamp is a new frame.\n"
    "octaves: (n,) integers. keypoints_undistorted: as keypoints; computed from the camera without.\n"
    "descriptors: (n, bytes) uint8. depth_m: (n,) float32 [m]; NaN, 0 and less: none.\n"
    "right_u_px: (n,) float32, stereo: column of the match in the rectified right image; NaN: none.\n"
    "grey: (height, width) uint8. depth: (height, width) float32 or uint16, in units of depth_unit_m [m].\n"
    "right_grey: (height, width) uint8, stereo: the rectified right image, to find missing columns in.\n"
    "camera: Camera or (3, 3) matrix. pose: (4, 4) T_world_camera.\n"
    "pose_kind: \"predicted\" (default before the pose), \"estimated\" (default later) or \"refined\".\n"
    "motion_prior: MotionPrior of the camera since an earlier frame, from a gyroscope or wheels.\n"
    "boxes: list of Detection; [] means that the detector found nothing, None that no result came.\n"
    "mask: (height, width) uint8 or bool, 0: background.\n"
    "boxes_frame_id, mask_frame_id: the frame that they were computed on; by default this one.\n"
    "matches: (n,) integers, index of each feature in frame matches_frame_id (by default the one before); "
    "-1: "
    "none.\n"
    "map_point_ids: (n,) integers, -1: none. map_points_m: (n, 3) in the world.\n"
    "keyframes: list of Keyframe that share map points, at a keyframe.\n"
    "min_features: fewer are never left.\n\n"
    "Arrays and images are not copied if type and layout fit, and not kept after the call.\n"
    "Raises ValueError with the argument's name. An exception of a filter written in Python is raised again.";

template <CallPoint kPoint>
void def_call(py::class_<PyPipeline>& type, const char* name) {
  const py::none none;
  type.def(name, &call<kPoint>, py::arg("keypoints"), py::kw_only(), py::arg("timestamp"),
           py::arg("frame_id") = none, py::arg("octaves") = none, py::arg("keypoints_undistorted") = none,
           py::arg("descriptors") = none, py::arg("depth_m") = none, py::arg("right_u_px") = none,
           py::arg("grey") = none, py::arg("depth") = none, py::arg("depth_unit_m") = none,
           py::arg("camera") = none, py::arg("pose") = none, py::arg("pose_kind") = none,
           py::arg("boxes") = none, py::arg("boxes_frame_id") = none, py::arg("mask") = none,
           py::arg("mask_frame_id") = none, py::arg("matches") = none, py::arg("matches_frame_id") = none,
           py::arg("map_point_ids") = none, py::arg("map_points_m") = none,
           py::arg("keyframes") = py::tuple(), py::arg("min_features") = 0, py::arg("motion_prior") = none,
           py::arg("right_grey") = none, kCallDoc);
}

}  // namespace

PipelineConfig config_of(const std::string& source, const Registry& registry) {
  const std::vector<std::string> presets = preset_names(preset_folders());
  const bool is_preset = std::find(presets.begin(), presets.end(), source) != presets.end();
  const Registry::Entry* filter = is_preset ? nullptr : registry.find(source);
  if (filter == nullptr) return load_pipeline(source, registry, preset_folders());
  PipelineConfig config;
  config.name = source;
  config.before_pose = stage(filter->make(YamlNode()));
  return config;
}

PipelineConfig config_of(py::handle source, const std::shared_ptr<FilterLink>& link,
                         const std::shared_ptr<const command::OracleLabels>& labels) {
  if (py::hasattr(source, "__fspath__")) return config_of(source.attr("__fspath__")(), link, labels);
  if (py::isinstance<py::str>(source)) {
    Registry all = registry(link);
    if (labels) command::add_oracle(all, labels);
    return config_of(source.cast<std::string>(), all);
  }
  if (!py::isinstance(source, py::module_::import("dynfilter.filters").attr("Filter")))
    refuse("source", "a preset, a filter's name, a file, YAML text or a dynfilter.Filter", source);
  PipelineConfig config;
  config.before_pose =
      stage(std::make_unique<PythonFilter>(py::reinterpret_borrow<py::object>(source), link));
  config.name = source.attr("name").cast<std::string>();
  return config;
}

namespace {

std::string pipeline_name(py::handle source) {
  return config_of(source, std::make_shared<FilterLink>(), std::make_shared<command::OracleLabels>()).name;
}

/// As the command checks its own.
void check_distinct(const std::vector<std::pair<std::string, std::string>>& names_and_sources) {
  std::vector<command::NamedSource> all;
  for (const auto& [name, source] : names_and_sources) all.push_back({name, source});
  command::check_distinct(all);
}

}  // namespace

void bind_pipeline(py::module_& module) {
  module.def("_pipeline_name", &pipeline_name, py::arg("source"));
  module.def("_check_distinct", &check_distinct, py::arg("names_and_sources"));
  module.def("_distinct_names", &command::distinct_names, py::arg("folders"));
  py::class_<Keyframe>(module, "Keyframe", "A keyframe that shares map points with the current frame.")
      .def(py::init(&make_keyframe), py::arg("id"), py::arg("pose"), py::arg("keypoints"), py::kw_only(),
           py::arg("depth_m") = py::none(), py::arg("map_point_ids") = py::none(),
           "`pose`: (4, 4) T_world_camera. `keypoints`: (n, 2) undistorted pixels; all are copied.")
      .def_readonly("id", &Keyframe::id);
  py::class_<PyPipeline> type(module, "Pipeline",
                              "Judges the features of one camera stream, from one thread at a time. The GIL "
                              "is released.");
  type.def(py::init<py::handle>(), py::arg("source"),
           "`source`: a preset's name, a filter's name, the path of a file, YAML text, or an object of "
           "dynfilter.Filter.\n"
           "Raises ConfigError with the YAML path.");
  def_call<CallPoint::BeforePose>(type, "before_pose");
  def_call<CallPoint::AfterPose>(type, "after_pose");
  def_call<CallPoint::AtKeyframe>(type, "at_keyframe");
  type.def("reset", &PyPipeline::reset, "Forgets all earlier frames: on loss of tracking or at a new scene.")
      .def("update_pose", &PyPipeline::update_pose, py::arg("frame_id"), py::arg("pose"),
           py::arg("pose_kind") = "refined", py::arg("keypoints") = py::none(),
           py::arg("map_point_ids") = py::none(), py::arg("inliers") = 0, py::arg("outliers") = 0,
           "A better (4, 4) T_world_camera of an earlier frame. `keypoints` that were kept, the map point of "
           "each (-1: none), and how many matches agree with the host's map.")
      .def("prepare", &PyPipeline::prepare, py::arg("grey"), py::arg("timestamp"),
           "Does what needs no keypoints of the next frame, in a thread beside the host's own work.")
      .def("lost", &PyPipeline::lost, "The host lost its pose: forgets the poses of earlier frames.")
      .def(
          "record",
          [](PyPipeline& self, py::handle file, int max_mb, bool images) {
            self.record(py::module_::import("os").attr("fspath")(file).cast<std::string>(), max_mb, images);
          },
          py::arg("file"), py::kw_only(), py::arg("max_mb") = 4096, py::arg("images") = true,
          "Writes each frame and verdict from now on to this file, for `dynfilter replay`. Replaces the "
          "file. It "
          "ends at `max_mb` megabytes, with the pipeline, and with \"\".")
      .def_property_readonly("moved_map_points", &PyPipeline::moved_map_points,
                             "ids of those whose features move, by all frames")
      .def_property_readonly("name", &PyPipeline::name)
      .def_property_readonly("needs", &PyPipeline::needs, "inputs that its stages can use")
      .def("__str__", &PyPipeline::tree)
      .def("__repr__", [](const PyPipeline& self) { return "Pipeline(" + self.name() + ")"; });
}

}  // namespace dynfilter::python
