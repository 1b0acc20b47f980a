// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/orb_slam.hpp>

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <exception>
#include <limits>

namespace dynfilter {

DYNFILTER_INLINE std::unique_ptr<OrbSlam> OrbSlam::start(const std::string& settings_file, int sensor,
                                                         LineSink sink, const Registry& registry,
                                                         const ProviderRegistry& providers) {
  const HostSensor kind = host_sensor(sensor);
  try {
    auto made = std::make_unique<OrbSlam>(read_orb_slam_settings(settings_file, registry, providers), kind,
                                          sink);  // a copy: the error needs it
    made->print(made->start_line());
    return made;
  } catch (const std::exception& error) {
    return after_error(settings_file, kind, std::move(sink), error.what());
  }
}

DYNFILTER_INLINE OrbSlam::OrbSlam(OrbSlamSettings settings, HostSensor sensor, LineSink sink)
    : params_(settings.params),
      sensor_(sensor),
      sink_(std::move(sink)),
      pipeline_file_(std::move(settings.pipeline_file)),
      semantics_(std::move(settings.semantics)),
      pipeline_(configured_pipeline(settings)),
      watch_(pipeline_) {
  check_parameters(params_, "DynFilter");
  start_recording(params_, pipeline_);
}

DYNFILTER_INLINE void OrbSlam::reset() {
  pipeline_.reset();
  semantics_.reset();
  grey_.release(), depth_.release();
  last_id_.reset();
  first_frame_ = true;
  lost_ = false;
}

inline std::unique_ptr<OrbSlam> OrbSlam::after_error(const std::string& settings_file, HostSensor sensor,
                                                     LineSink sink, const std::string& what) {
  const bool off = read_on_error(settings_file) == OnError::Off;
  if (sink) sink("dynfilter: " + std::string(off ? "off, every feature is kept: " : "") + what);
  if (!off) return nullptr;
  OrbSlamSettings nothing;
  nothing.params.enabled = false;
  return std::make_unique<OrbSlam>(std::move(nothing), sensor, std::move(sink));
}

inline void OrbSlam::warn(const std::string& line) {
  if (line.empty()) return;
  warning_ = "dynfilter: warning: " + line;
  print(warning_);
}

DYNFILTER_INLINE Input OrbSlam::given_inputs() const {
  Input given = Input::GreyImage | Input::Camera | Input::Pose | Input::Descriptors | Input::MapPoints |
                Input::Keyframes | Input::Correspondence;
  if (sensor_ != HostSensor::Monocular) given = given | Input::Depth;
  return given | semantic_inputs(params_);
}

DYNFILTER_INLINE int OrbSlam::min_features(bool map_exists) const {
  if (map_exists) return params_.min_features;
  return first_frame_ && params_.keep_first_frame ? std::numeric_limits<int>::max()
                                                  : params_.floor_before_map(sensor_);
}

DYNFILTER_INLINE void OrbSlam::take_pose(const orb_slam::HostPose& pose, bool map_exists, FrameView& view) {
  if (std::exchange(lost_, false)) return;
  HostTracking tracking;
  if (map_exists && pose.tracking) tracking = pose.tracking(point_ids_);
  if (pose.has_last)
    pipeline_.update_pose(pose.last_frame_id, pose.last_T_world_camera, PoseProvenance::Estimated, tracking);
  if (pose.has_prediction)
    view.T_world_camera = pose.predicted_T_world_camera, view.pose_provenance = PoseProvenance::Predicted;
}

DYNFILTER_INLINE void OrbSlam::submit_to_detector(const FrameView& view) {
  SemanticImage image;
  image.frame_id = view.id;
  image.timestamp_s = view.timestamp_s;
  image.pixels = has_detector_image_ && !detector_image_.empty() ? detector_image_ : grey_;
  if (!depth_.empty() && depth_.size() == image.pixels.size())
    image.depth = depth_, image.depth_unit_m = depth_unit_m_;
  semantics_.begin(image);
  has_detector_image_ = false;
  const std::string error = semantics_.take_error();
  if (!error.empty()) warn("the detector failed: " + error);
}

DYNFILTER_INLINE void OrbSlam::note_restart(std::int64_t id) {
  if (last_id_ && id < *last_id_) reset();
  last_id_ = id;
}

DYNFILTER_INLINE void OrbSlam::judge(const FrameView& view, CallPoint point, int min_features) {
  keypoints_.assign(view.keypoints.begin(), view.keypoints.end());
  verdict_ = pipeline_.process(view, point, {min_features});
  if (point == CallPoint::AtKeyframe) reject_moved_points(view);
  if (point == CallPoint::BeforePose) weights_.assign(verdict_.size(), 1);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < weights_.size() && i < verdict_.size(); ++i)
    if (verdict_.keep(i))
      weights_[kept++] = point == CallPoint::BeforePose ? verdict_.weight(i) : weights_[i];
  weights_.resize(kept);
  watch_.saw(verdict_.report, pipeline_.inputs(), verdict_.report.rejected + verdict_.report.restored);
  warn(watch_.take_warning());
}

DYNFILTER_INLINE void OrbSlam::reject_moved_points(const FrameView& view) {
  std::size_t k = 0;
  for (std::size_t i = 0; i < view.map_point_ids.size() && k < verdict_.map_points.size(); ++i) {
    if (view.map_point_ids[i] < 0 || verdict_.map_points[k++].vote != Vote::Dynamic) continue;
    if (verdict_.keep(i)) ++verdict_.report.rejected;
    verdict_.decision[i] = Vote::Dynamic;
  }
}

DYNFILTER_INLINE const Verdict& OrbSlam::nothing_judged() {
  verdict_ = Verdict();
  keypoints_.clear();
  weights_.clear();
  return verdict_;
}

}  // namespace dynfilter
