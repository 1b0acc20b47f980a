// SPDX-License-Identifier: MIT
// The reference odometry of `dynfilter run`, and its judge, on frames that Python hands over.
#include "bindings.hpp"
#include "eval/classification.hpp"

#ifdef DYNFILTER_PYTHON_ODOMETRY

#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/pose.hpp>
#include <map>
#include <memory>
#include <odometry/odometry.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <running/motion_priors.hpp>
#include <running/oracle_filter.hpp>
#include <running/pipeline_judge.hpp>
#include <running/run_notes.hpp>
#include <running/sequence_run.hpp>
#include <string>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "pipeline.hpp"
#include "recording.hpp"
#include "registered.hpp"
#include "trajectory.hpp"

namespace dynfilter::python {
namespace {

/// One frame, and what the judge made of its features.
struct Track {
  odometry::TrackResult result;
  std::vector<cv::Point2f> pixels;
  std::vector<std::uint8_t> decision;
  double judge_ms = 0;
};

class Odometry {
 public:
  Odometry(py::handle camera, py::handle pipeline, const std::string& sensor, bool poses)
      : link_(std::make_shared<FilterLink>()),
        labels_(std::make_shared<command::OracleLabels>()),
        judge_(config(pipeline)),
        sensor_(sensor),
        odometry_(camera_of("camera", camera), options_of(sensor, poses), &judge_) {}

  Track process(py::handle grey, double timestamp, py::handle depth, double depth_unit_m, py::handle boxes,
                std::int64_t boxes_frame_id, py::handle mask, py::handle labels, py::handle pose,
                py::handle right, py::handle motion_prior) {
    require_labels("frame " + std::to_string(frames_), !labels.is_none());
    Images images;
    io::SequenceFrame frame;
    frame.timestamp_s = timestamp, frame.depth_unit_m = depth_unit_m;
    frame.grey = images.grey("grey", grey).clone();  // the odometry keeps what it is given
    if (frame.grey.empty()) refuse("grey", "a uint8 image of shape (height, width)", grey);
    frame.depth = images.depth("depth", depth).clone();
    frame.right = images.grey("right", right).clone();
    labels_->labels = images.mask("labels", labels);
    odometry::SemanticInputs inputs;
    const std::vector<Detection> found =
        boxes.is_none() ? std::vector<Detection>() : detections_of("boxes", boxes);
    if (!boxes.is_none()) inputs.detections = DetectionInput{boxes_frame_id, found};
    if (!mask.is_none()) inputs.mask = MaskInput{-1, images.mask("mask", mask)};
    inputs.motion_prior = motion_prior_of("motion_prior", motion_prior);
    std::optional<Pose> known;
    if (!pose.is_none()) known = pose_of("pose", pose);
    Track track;
    {
      const py::gil_scoped_release no_gil;
      track.result = odometry_.process(frame, inputs, known);
    }
    labels_->labels = cv::Mat();
    last_ = track.result;
    ++frames_;
    link_->rethrow_error();
    take_verdict(track);
    return track;
  }

  void require_labels(const std::string& where, bool has_labels) const {
    command::require_labels(judge_.pipeline(), has_labels, where);
  }
  std::string failure() const { return command::failure_of(judge_.totals()); }
  /// What `dynfilter run` notes of the stages.
  std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    if (!judge_.totals().empty() && frames_ > 0 && !any_judged_)
      notes.push_back(command::unknown_note(judge_.totals()));
    for (const auto& [note, times] : stage_notes_)
      notes.push_back(note + " (" + command::counted(times, "frame") + ")");
    return notes;
  }

  /// Frames from now on are recorded for a report of so many runs.
  void record(std::size_t frames, std::size_t runs) {
    recording_.emplace(judge_, frames, std::max<std::size_t>(1, runs));
  }

  /// The frame that was processed last.
  void see(std::size_t index, double timestamp_s, const std::string& sequence, py::handle colour,
           py::handle truth, py::handle boxes, py::handle mask) {
    if (!recording_) return;
    Images images;
    command::OverlayFrame picture;
    picture.colour = images.colour("colour", colour);
    if (picture.colour.channels() == 1) cv::cvtColor(picture.colour, picture.colour, cv::COLOR_GRAY2BGR);
    if (!boxes.is_none()) picture.detections = detections_of("boxes", boxes);
    if (!mask.is_none()) picture.mask = images.mask("mask", mask);
    command::FrameRow row = command::frame_row(index, timestamp_s, last_, judge_.record());
    picture.title = pipeline() + "   " + sequence + "   frame " + std::to_string(index) + "   " + row.state;
    recording_->add(std::move(row), judge_, images.grey("truth", truth), std::move(picture));
  }

  command::report::RunRecord recorded(py::handle run, py::handle trajectory, py::handle truth,
                                      bool verdicts_only) {
    std::optional<io::Trajectory> true_poses;
    if (!truth.is_none()) true_poses = trajectory_of("truth", truth);
    return recording_.value().finish(run, judge_, trajectory_of("trajectory", trajectory), true_poses,
                                     sensor_, verdicts_only);
  }

  py::tuple trajectory() const { return arrays_of(odometry_.trajectory()); }
  const std::string& pipeline() const { return judge_.pipeline().name(); }

 private:
  static odometry::OdometryOptions options_of(const std::string& sensor, bool poses) {
    const auto named = odometry::sensor_named(sensor);
    if (!named) refuse_name("sensor", {"rgbd", "stereo", "mono"}, sensor);
    odometry::OdometryOptions options;
    options.poses = poses;
    options.sensor = *named;
    return options;
  }

  PipelineConfig config(py::handle source) { return config_of(source, link_, labels_); }

  void take_verdict(Track& track) {
    const command::FrameVerdict& verdict = judge_.record();
    any_judged_ =
        any_judged_ || verdict.count(Vote::Unknown) < verdict.features.size() || verdict.restored() > 0;
    for (const std::string& note : verdict.stage_notes) ++stage_notes_[note];
    for (const command::MarkedFeature& feature : verdict.features) {
      track.pixels.push_back(feature.pixel);
      track.decision.push_back(static_cast<std::uint8_t>(feature.decision));
    }
    track.judge_ms = track.result.ms.judge;
  }

  std::shared_ptr<FilterLink> link_;
  std::shared_ptr<command::OracleLabels> labels_;
  command::PipelineJudge judge_;
  std::string sensor_;
  odometry::Odometry odometry_;
  odometry::TrackResult last_;
  std::optional<Recording> recording_;
  std::size_t frames_ = 0;
  bool any_judged_ = false;
  std::map<std::string, std::size_t> stage_notes_;
};

/// The priors of a run with `imu` and `wheel_odometry`, as the command makes them.
class RunPriors {
 public:
  RunPriors(const std::string& folder, const std::string& imu, const std::string& wheel_odometry)
      : priors_(options_of(folder, imu, wheel_odometry), notes_) {}

  std::optional<MotionPrior> next(double timestamp_s) { return priors_.next(timestamp_s); }
  void tracked(py::handle pose) {
    priors_.tracked(pose.is_none() ? std::optional<Pose>() : pose_of("pose", pose));
  }
  std::vector<std::string> notes() const {
    std::vector<std::string> notes = notes_;
    if (const std::string learned = priors_.summary(); !learned.empty()) notes.push_back(learned);
    return notes;
  }

 private:
  static command::RunOptions options_of(const std::string& folder, const std::string& imu,
                                        const std::string& wheel_odometry) {
    command::RunOptions options;
    options.sequence = folder, options.imu = imu, options.wheel_odometry = wheel_odometry;
    return options;
  }

  std::vector<std::string> notes_;  ///< first: the next one fills it
  command::MotionPriors priors_;
};

void bind_priors(py::module_& module) {
  py::class_<RunPriors>(module, "_MotionPriors")
      .def(py::init<const std::string&, const std::string&, const std::string&>(), py::arg("folder"),
           py::arg("imu"), py::arg("wheel_odometry"))
      .def("next", &RunPriors::next, py::arg("timestamp"))
      .def("tracked", &RunPriors::tracked, py::arg("pose"))
      .def_property_readonly("notes", &RunPriors::notes);
}

void bind_track(py::module_& module) {
  py::class_<Track>(module, "Track", "What the odometry did with one frame.")
      .def_property_readonly(
          "state", [](const Track& t) { return to_string(t.result.state); }, "tracked, lost or no_map")
      .def_property_readonly(
          "pose",
          [](const Track& t) {
            const auto& pose = t.result.T_world_camera;
            return pose ? py::object(matrix_of(*pose)) : py::object(py::none());
          },
          "(4, 4) T_world_camera; the world is the first camera. None unless tracked")
      .def_property_readonly("keyframe", [](const Track& t) { return t.result.keyframe; })
      .def_property_readonly("rejected", [](const Track& t) { return t.result.rejected; })
      .def_property_readonly(
          "keypoints", [](const Track& t) { return copy_of(t.pixels); },
          "(n, 2) float32, all extracted features [px]")
      .def_property_readonly(
          "decision", [](const Track& t) { return copy_of(t.decision); },
          "(n,) uint8: 0 unknown, 1 static, 2 dynamic, over all call points")
      .def_readonly("judge_ms", &Track::judge_ms, "all calls of the pipeline")
      .def_property_readonly("total_ms", [](const Track& t) { return t.result.ms.total(); })
      .def_property_readonly(
          "cpu_ms", [](const Track& t) { return t.result.cpu_ms.total(); }, "CPU time of all threads");
}

/// Truth images have 0 static, 128 don't care, 255 dynamic.
void classify(eval::Classification& self, py::handle truth, py::handle pixels, py::handle rejected) {
  Images images;
  const cv::Mat image = images.grey("truth", truth);
  const auto px = array_of<float>("pixels", pixels, -1, 2);
  if (!py::isinstance<py::array_t<bool>>(rejected)) refuse("rejected", "bool of shape (n,)", rejected);
  const auto out = py::reinterpret_borrow<py::array_t<bool>>(rejected);
  if (out.ndim() != 1 || out.shape(0) != px.shape(0)) refuse("rejected", "one flag per pixel", rejected);
  for (py::ssize_t i = 0; i < px.shape(0); ++i)
    self.add(eval::truth_at(image, {px.at(i, 0), px.at(i, 1)}), out.at(i));
}

}  // namespace

void bind_odometry(py::module_& module) {
  module.attr("has_odometry") = true;
  bind_recording(module);
  bind_track(module);
  bind_priors(module);
  py::class_<Odometry>(module, "Odometry",
                       "Odometry as ORB-SLAM's tracking and local mapping, without loop closing: the "
                       "SLAM of `dynfilter run`.")
      .def(py::init<py::handle, py::handle, const std::string&, bool>(), py::arg("camera"),
           py::arg("pipeline") = "none", py::kw_only(), py::arg("sensor") = "rgbd", py::arg("poses") = true,
           "`pipeline`: as for Pipeline; also \"oracle\", which rejects what `labels` say.\n"
           "`sensor`: rgbd, stereo or mono. A mono map has a unit of its own.\n"
           "`poses`: False, if the camera is a guess: then frames are judged only.")
      .def("process", &Odometry::process, py::arg("grey"), py::kw_only(), py::arg("timestamp"),
           py::arg("depth") = py::none(), py::arg("depth_unit_m") = 1.0, py::arg("boxes") = py::none(),
           py::arg("boxes_frame_id") = -1, py::arg("mask") = py::none(), py::arg("labels") = py::none(),
           py::arg("pose") = py::none(), py::arg("right") = py::none(), py::arg("motion_prior") = py::none(),
           "One frame. Frames are counted from 0, which `boxes_frame_id` refers to.\n"
           "`labels`: (height, width) uint8, not 0 on movers. `pose`: (4, 4), replaces the estimate.\n"
           "`right`: (height, width) uint8, rectified, for stereo.\n"
           "`motion_prior`: MotionPrior since an earlier frame.")
      .def("trajectory", &Odometry::trajectory,
           "(timestamps (n,) [s], poses (n, 4, 4)) of the tracked frames, refined since.")
      .def("_record", &Odometry::record, py::arg("frames"), py::arg("runs"))
      .def("_see", &Odometry::see, py::arg("index"), py::arg("timestamp"), py::arg("sequence"),
           py::arg("colour"), py::arg("truth"), py::arg("boxes"), py::arg("mask"))
      .def("_recorded", &Odometry::recorded, py::arg("run"), py::arg("trajectory"), py::arg("truth"),
           py::arg("verdicts_only"))
      .def("_require_labels", &Odometry::require_labels, py::arg("where"), py::arg("has_labels"))
      .def_property_readonly(
          "failure", &Odometry::failure,
          "Why no frame was judged as the pipeline says: a stage that failed in all; \"\" if "
          "there is none.")
      .def_property_readonly("notes", &Odometry::notes,
                             "Of all frames so far: stages that were skipped or failed, and why.")
      .def_property_readonly("pipeline", &Odometry::pipeline, "the pipeline's name");
  py::class_<eval::Classification>(module, "Classification",
                                   "Features rejected and kept, compared with a truth image.")
      .def(py::init<>())
      .def("add", &classify, py::arg("truth"), py::arg("pixels"), py::arg("rejected"),
           "`truth`: uint8 image, 0 static, 128 don't care, 255 dynamic. `pixels`: (n, 2). `rejected`: (n,) "
           "bool.")
      .def_property_readonly("precision", &eval::Classification::precision)
      .def_property_readonly("recall", &eval::Classification::recall)
      .def_property_readonly("static_kept", &eval::Classification::static_kept)
      .def_property_readonly_static("first_frame",
                                    [](py::object) { return eval::Classification::kFirstFrame; });
  module.def(
      "_set_threads", [](int n) { cv::setNumThreads(n); }, py::arg("n"));
}

}  // namespace dynfilter::python

#else

namespace dynfilter::python {

void bind_odometry(pybind11::module_& module) {
  module.attr("has_odometry") = false;
}

}  // namespace dynfilter::python

#endif
