// SPDX-License-Identifier: MIT
#pragma once

/// The functions of the shared library's C++11 interface. Only its own source includes them.

#include <dlfcn.h>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/pipeline.hpp>

#include <dynfilter/facade/facade.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/frame_observer.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <dynfilter/version.hpp>
#include <filesystem>
#include <optional>
#include <utility>

namespace dynfilter::facade {

namespace {

dynfilter::Camera camera_of(const Camera& from) {
  dynfilter::Camera camera;
  camera.fx_px = from.fx_px, camera.fy_px = from.fy_px;
  camera.cx_px = from.cx_px, camera.cy_px = from.cy_px;
  std::copy(std::begin(from.distortion), std::end(from.distortion), camera.distortion.begin());
  camera.baseline_fx_px_m = from.baseline_fx_px_m;
  camera.width_px = from.width_px, camera.height_px = from.height_px;
  return camera;
}

Pose pose_of(const Transform& from) {
  Pose pose;
  std::copy(std::begin(from.rotation), std::end(from.rotation), pose.rotation.begin());
  std::copy(std::begin(from.translation_m), std::end(from.translation_m), pose.translation_m.begin());
  return pose;
}

PoseProvenance provenance_of(PoseKind kind) {
  return kind == PoseKind::Predicted   ? PoseProvenance::Predicted
         : kind == PoseKind::Estimated ? PoseProvenance::Estimated
         : kind == PoseKind::Refined   ? PoseProvenance::Refined
                                       : PoseProvenance::None;
}

MotionPrior motion_prior_of(const Frame& frame) {
  MotionPrior prior;
  prior.reference_frame_id = frame.motion_frame_id;
  prior.T_current_reference = pose_of(frame.T_current_reference);
  std::copy(std::begin(frame.motion_covariance), std::end(frame.motion_covariance), prior.covariance.begin());
  prior.has_translation = frame.motion_kind == MotionKind::TurnAndTranslation;
  return prior;
}

dynfilter::CallPoint call_point_of(CallPoint point) {
  return point == CallPoint::AfterPose    ? dynfilter::CallPoint::AfterPose
         : point == CallPoint::AtKeyframe ? dynfilter::CallPoint::AtKeyframe
                                          : dynfilter::CallPoint::BeforePose;
}

void copy_boxes(const std::vector<Box>& boxes, std::vector<Detection>& out) {
  out.clear();
  for (const Box& box : boxes)
    out.push_back({box.box, box.class_id, box.class_name, box.score, box.track_id, box.mask});
}

FrameView view_of(const Frame& frame, const std::vector<Detection>& detections) {
  FrameView view;
  view.id = frame.id;
  view.timestamp_s = frame.timestamp_s;
  view.keypoints = frame.keypoints;
  view.keypoints_undistorted = frame.keypoints_undistorted;
  view.descriptors = frame.descriptors;
  view.depth_m = frame.depth_m;
  view.right_u_px = frame.right_u_px;
  view.grey = frame.grey, view.right_grey = frame.right_grey;
  view.depth = frame.depth;
  view.depth_unit_m = frame.depth_unit_m;
  if (frame.has_camera) view.camera = camera_of(frame.camera);
  view.T_world_camera = pose_of(frame.T_world_camera);
  view.pose_provenance = provenance_of(frame.pose_kind);
  if (frame.motion_kind != MotionKind::None) view.motion_prior = motion_prior_of(frame);
  view.map_point_ids = frame.map_point_ids;
  view.map_points_world_m = frame.map_points_world_m;
  if (frame.has_boxes) view.detections = DetectionInput{frame.boxes_frame_id, detections};
  if (!frame.mask.empty()) view.mask = MaskInput{frame.mask_frame_id, frame.mask};
  if (frame.has_matches) view.matches = HostMatches{frame.match_frame_id, frame.match_index};
  return view;
}

void copy_verdict(const Verdict& from, Verdicts& to) {
  const std::size_t n = from.size();
  to.keep.resize(n), to.decision.resize(n), to.weight.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    to.keep[i] = from.keep(i) ? 1 : 0;
    to.weight[i] = from.weight(i);
    to.decision[i] = from.decision[i] == Vote::Dynamic ? 1 : from.decision[i] == Vote::Static ? -1 : 0;
  }
  to.suspicion = from.suspicion;
  to.restored = from.restored;
  to.reasons = from.reasons;
  to.stages.clear();
  for (const dynfilter::StageReport& stage : from.report.stages) to.stages.push_back(stage.name);
  to.notes = from.report.notes;
  to.rejected = from.report.rejected;
  to.wait_for_keyframe = from.report.wait_for_keyframe;
  to.correspondence_ms = from.report.correspondence_ms;
  to.total_ms = from.report.total_ms;
}

void copy_reports(const FrameReport& from, std::vector<StageReport>& to) {
  to.resize(from.stages.size());
  for (std::size_t k = 0; k < to.size(); ++k) {
    const dynfilter::StageReport& stage = from.stages[k];
    to[k].name = stage.name, to[k].path = stage.path, to[k].note = stage.note;
    to[k].skipped = stage.skipped, to[k].failed = stage.failed;
    to[k].judged = stage.judged, to[k].dynamic = stage.dynamic;
    to[k].unknown = stage.unknown, to[k].prior = stage.prior;
    to[k].time_ms = stage.time_ms;
  }
}

/// share/dynfilter of the installation that this library belongs to.
PresetFolders installed_presets() {
  PresetFolders folders;
  Dl_info library{};
  if (dladdr(reinterpret_cast<const void*>(&version), &library) == 0 || library.dli_fname == nullptr)
    return folders;
  std::error_code error;
  const std::filesystem::path file = std::filesystem::canonical(library.dli_fname, error);
  if (!error)
    folders.installed.push_back(
        (file.parent_path() / DYNFILTER_DATA_FROM_LIB / kPipelinePresets.folder).lexically_normal());
  return folders;
}

}  // namespace

struct DynFilter::Impl {
  std::optional<Pipeline> pipeline;
  std::vector<Detection> detections;
  std::vector<StageReport> reports;
  std::string error;

  /// Runs what may throw; nothing gets out of here.
  template <class Work>
  bool guarded(const Work& work) noexcept {
    try {
      try {
        work();
        return true;
      } catch (const std::exception& e) {
        error = e.what();
      } catch (...) {
        error = "unknown error";
      }
    } catch (...) {  // no memory even for the message
    }
    return false;
  }
  void need_pipeline() const {
    if (!pipeline) throw Error("no pipeline is loaded");
  }
};

int abi_version() noexcept {
  return kAbiVersion;
}
const char* version() noexcept {
  return DYNFILTER_VERSION;
}

DynFilter::DynFilter() noexcept : impl_(new (std::nothrow) Impl) {}
DynFilter::~DynFilter() = default;
DynFilter::DynFilter(DynFilter&& other) noexcept = default;
DynFilter& DynFilter::operator=(DynFilter&& other) noexcept = default;

bool DynFilter::load(const std::string& source) noexcept {
  return impl_ && impl_->guarded([&] {
    PipelineConfig config = load_pipeline(source, builtin_filters(), installed_presets());
    impl_->pipeline.emplace(std::move(config));
  });
}

bool DynFilter::load_file(const std::string& path) noexcept {
  return impl_ && impl_->guarded([&] {
    PipelineConfig config = pipeline_from_file(path, builtin_filters());
    impl_->pipeline.emplace(std::move(config));
  });
}

bool DynFilter::load_text(const std::string& yaml) noexcept {
  return impl_ && impl_->guarded([&] {
    PipelineConfig config = pipeline_from_text(yaml, builtin_filters());
    impl_->pipeline.emplace(std::move(config));
  });
}

bool DynFilter::loaded() const noexcept {
  return impl_ && impl_->pipeline.has_value();
}

bool DynFilter::prepare(const cv::Mat& grey, double timestamp_s) noexcept {
  return impl_ && impl_->guarded([&] {
    impl_->need_pipeline();
    impl_->pipeline->prepare(grey, timestamp_s);
  });
}

bool DynFilter::process(const Frame& frame, CallPoint call_point, Verdicts& verdicts) noexcept {
  return impl_ && impl_->guarded([&] {
    impl_->need_pipeline();
    copy_boxes(frame.boxes, impl_->detections);
    const Verdict& verdict =
        impl_->pipeline->process(view_of(frame, impl_->detections), call_point_of(call_point));
    impl_->detections.clear();  // the host's masks
    copy_verdict(verdict, verdicts);
    copy_reports(verdict.report, impl_->reports);
  });
}

bool DynFilter::update_pose(std::int64_t frame_id, const Transform& T_world_camera, PoseKind kind,
                            const Tracking& tracking) noexcept {
  return impl_ && impl_->guarded([&] {
    impl_->need_pipeline();
    impl_->pipeline->update_pose(
        frame_id, pose_of(T_world_camera), provenance_of(kind),
        {tracking.keypoints, tracking.map_point_ids, tracking.inliers, tracking.outliers});
  });
}

bool DynFilter::lost() noexcept {
  return impl_ && impl_->guarded([&] {
    impl_->need_pipeline();
    impl_->pipeline->lost();
  });
}

std::vector<std::int64_t> DynFilter::moved_map_points() const noexcept {
  try {
    if (loaded()) return impl_->pipeline->moved_map_points();
  } catch (...) {  // no memory
  }
  return {};
}

bool DynFilter::reset() noexcept {
  return impl_ && impl_->guarded([&] {
    impl_->need_pipeline();
    impl_->pipeline->reset();
  });
}

bool DynFilter::record(const std::string& file, int max_mb) noexcept {
  return impl_ && impl_->guarded([&] {
    impl_->need_pipeline();
    impl_->pipeline->set_observer(nullptr);  // its file may be the same
    if (!file.empty()) impl_->pipeline->set_observer(open_recording(file, {max_mb}));
  });
}

const std::vector<StageReport>& DynFilter::reports() const noexcept {
  static const std::vector<StageReport> none;
  return impl_ ? impl_->reports : none;
}

const std::string& DynFilter::error() const noexcept {
  static const std::string gone = "this object has been moved from";
  return impl_ ? impl_->error : gone;
}

}  // namespace dynfilter::facade
