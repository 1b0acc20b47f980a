// SPDX-License-Identifier: MIT
#pragma once

/// The functions of the shared library's C interface. Only its own source includes them.

#include <dynfilter/facade/dynfilter.h>

#include <algorithm>
#include <cstring>
#include <dynfilter/facade/facade.hpp>
#include <exception>
#include <limits>
#include <new>
#include <string>
#include <vector>

using namespace dynfilter::facade;

// The C name is the handle's type; what it holds is the C++ facade and the memory behind the last answers.
struct dynfilter_filter {  // NOLINT(readability-identifier-naming): a C name
  DynFilter filter;
  Frame frame;
  Verdicts verdicts;
  std::string notes, error;
};

namespace {

const char* const kOtherStruct =
    "the frame's struct_size differs: call dynfilter_frame_init, or another version was compiled in";

bool short_row(const dynfilter_frame& frame, const void* data, std::size_t stride_bytes,
               std::size_t pixel_bytes) {
  const std::size_t row_bytes = pixel_bytes * static_cast<std::size_t>(std::max(0, frame.width_px));
  return data != nullptr && stride_bytes != 0 && stride_bytes < row_bytes;
}

/// What cannot be read safely of a frame: the name of the member and what was expected; "" if nothing.
std::string fault_of(const dynfilter_frame& frame) {
  const auto needs = [](const char* array, const char* count) {
    return std::string(array) + " is NULL, but " + count + " is not 0";
  };
  const auto stride = [](const std::string& name) { return name + " is less than a row of the image"; };
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<int>::max());
  if (frame.keypoint_count > kMost) return "keypoint_count is more than 2^31 - 1";
  if (frame.descriptor_bytes > kMost) return "descriptor_bytes is more than 2^31 - 1";
  if (frame.keypoints == nullptr && frame.keypoint_count > 0) return needs("keypoints", "keypoint_count");
  if (frame.has_boxes != 0 && frame.boxes == nullptr && frame.box_count > 0)
    return needs("boxes", "box_count");
  if (short_row(frame, frame.grey, frame.grey_stride_bytes, 1)) return stride("grey_stride_bytes");
  if (short_row(frame, frame.right_grey, frame.right_grey_stride_bytes, 1))
    return stride("right_grey_stride_bytes");
  if (short_row(frame, frame.depth, frame.depth_stride_bytes,
                frame.depth_type == DYNFILTER_DEPTH_U16 ? 2 : 4))
    return stride("depth_stride_bytes");
  if (short_row(frame, frame.mask, frame.mask_stride_bytes, 1)) return stride("mask_stride_bytes");
  for (std::size_t i = 0; frame.has_boxes != 0 && i < frame.box_count; ++i)
    if (short_row(frame, frame.boxes[i].mask, frame.boxes[i].mask_stride_bytes, 1))
      return stride("boxes[" + std::to_string(i) + "].mask_stride_bytes");
  return "";
}

/// An image of the caller's memory; empty when there is none.
cv::Mat image_of(const void* data, std::size_t stride_bytes, int type, const dynfilter_frame& frame) {
  if (data == nullptr || frame.width_px <= 0 || frame.height_px <= 0) return {};
  return cv::Mat(frame.height_px, frame.width_px, type, const_cast<void*>(data),
                 stride_bytes == 0 ? static_cast<std::size_t>(cv::Mat::AUTO_STEP) : stride_bytes);
}

void fill_features(const dynfilter_frame& from, Frame& to) {
  const std::size_t n = from.keypoint_count;
  to.keypoints.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const dynfilter_keypoint& k = from.keypoints[i];
    to.keypoints.emplace_back(k.x_px, k.y_px, k.size_px, k.angle_deg, k.response, k.octave);
  }
  const auto assign = [n](auto& values, const auto* data) {
    values.clear();
    if (data != nullptr) values.assign(data, data + n);
  };
  assign(to.depth_m, from.depth_m);
  assign(to.right_u_px, from.right_u_px);
  assign(to.map_point_ids, from.map_point_ids);
  assign(to.match_index, from.match_index);
  to.has_matches = from.match_index != nullptr;
  to.match_frame_id = from.match_frame_id;
  to.map_points_world_m.clear();
  if (const float* p = from.map_points_xyz_m)
    for (std::size_t i = 0; i < n; ++i)
      to.map_points_world_m.emplace_back(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
  to.descriptors = from.descriptors == nullptr || n == 0 || from.descriptor_bytes == 0
                       ? cv::Mat()
                       : cv::Mat(static_cast<int>(n), static_cast<int>(from.descriptor_bytes), CV_8UC1,
                                 const_cast<std::uint8_t*>(from.descriptors));
}

void fill_geometry(const dynfilter_frame& from, Frame& to) {
  to.has_camera = from.has_camera != 0;
  to.camera.fx_px = from.fx_px, to.camera.fy_px = from.fy_px;
  to.camera.cx_px = from.cx_px, to.camera.cy_px = from.cy_px;
  std::copy(std::begin(from.distortion), std::end(from.distortion), std::begin(to.camera.distortion));
  to.camera.baseline_fx_px_m = from.baseline_fx_px_m;
  to.camera.width_px = from.width_px, to.camera.height_px = from.height_px;
  to.pose_kind =
      from.pose_kind >= 0 && from.pose_kind <= 3 ? static_cast<PoseKind>(from.pose_kind) : PoseKind::None;
  std::copy(std::begin(from.rotation), std::end(from.rotation), std::begin(to.T_world_camera.rotation));
  std::copy(std::begin(from.translation_m), std::end(from.translation_m),
            std::begin(to.T_world_camera.translation_m));
  to.motion_kind = from.motion_kind >= 0 && from.motion_kind <= 2 ? static_cast<MotionKind>(from.motion_kind)
                                                                  : MotionKind::None;
  to.motion_frame_id = from.motion_frame_id;
  std::copy(std::begin(from.motion_rotation), std::end(from.motion_rotation),
            std::begin(to.T_current_reference.rotation));
  std::copy(std::begin(from.motion_translation_m), std::end(from.motion_translation_m),
            std::begin(to.T_current_reference.translation_m));
  std::copy(std::begin(from.motion_covariance), std::end(from.motion_covariance),
            std::begin(to.motion_covariance));
}

void fill_semantics(const dynfilter_frame& from, Frame& to) {
  to.has_boxes = from.has_boxes != 0;
  to.boxes_frame_id = from.boxes_frame_id;
  to.boxes.resize(to.has_boxes ? from.box_count : 0);
  for (std::size_t i = 0; i < to.boxes.size(); ++i) {
    const dynfilter_box& b = from.boxes[i];
    Box& box = to.boxes[i];
    box.box = {b.x_px, b.y_px, b.width_px, b.height_px};
    box.class_id = b.class_id, box.track_id = b.track_id;
    box.class_name = b.class_name == nullptr ? "" : b.class_name;
    box.score = b.score;
    box.mask = image_of(b.mask, b.mask_stride_bytes, CV_8UC1, from);
  }
  to.mask = image_of(from.mask, from.mask_stride_bytes, CV_8UC1, from);
  to.mask_frame_id = from.mask_frame_id;
}

void fill(const dynfilter_frame& from, Frame& to) {
  to.id = from.id, to.timestamp_s = from.timestamp_s;
  fill_features(from, to);
  fill_geometry(from, to);
  fill_semantics(from, to);
  to.grey = image_of(from.grey, from.grey_stride_bytes, CV_8UC1, from);
  to.right_grey = image_of(from.right_grey, from.right_grey_stride_bytes, CV_8UC1, from);
  to.depth_unit_m = from.depth_unit_m;
  to.depth =
      from.depth_type == DYNFILTER_DEPTH_U16   ? image_of(from.depth, from.depth_stride_bytes, CV_16UC1, from)
      : from.depth_type == DYNFILTER_DEPTH_F32 ? image_of(from.depth, from.depth_stride_bytes, CV_32FC1, from)
                                               : cv::Mat();
}

void show(const dynfilter_filter& from, dynfilter_verdicts& to) {
  const Verdicts& v = from.verdicts;
  to.count = v.keep.size();
  to.keep = v.keep.data(), to.decision = v.decision.data();
  to.suspicion = v.suspicion.data(), to.reasons = v.reasons.data();
  to.stage_count = v.stages.size(), to.rejected = v.rejected;
  to.wait_for_keyframe = v.wait_for_keyframe ? 1 : 0;
  to.correspondence_ms = v.correspondence_ms, to.total_ms = v.total_ms;
  to.notes = from.notes.c_str();
  to.weight = v.weight.data();
}

int fail(dynfilter_filter* filter, const char* why) noexcept {
  try {
    filter->error = why;
  } catch (...) {  // no memory even for the message
  }
  return 1;
}

/// Runs what may throw; `work` returns why it failed, "" if it did not. Nothing gets out of here.
template <class Work>
int guarded(dynfilter_filter* filter, const Work& work) noexcept {
  try {
    const std::string wrong = work();
    return wrong.empty() ? 0 : fail(filter, wrong.c_str());
  } catch (const std::exception& e) {
    return fail(filter, e.what());
  } catch (...) {
    return fail(filter, "unknown error");
  }
}

void copy_error(char* error, std::size_t error_size, const std::string& why) {
  if (error == nullptr || error_size == 0) return;
  const std::size_t n = std::min(why.size(), error_size - 1);
  std::memcpy(error, why.data(), n);
  error[n] = '\0';
}

template <class Load>
dynfilter_filter* create(const char* source, char* error, std::size_t error_size, const Load& load) noexcept {
  if (source == nullptr) {
    copy_error(error, error_size, "expected a text, got NULL");
    return nullptr;
  }
  auto* made = new (std::nothrow) dynfilter_filter;
  if (made == nullptr) return nullptr;
  try {
    if (load(made->filter, source)) return made;
    copy_error(error, error_size, made->filter.error());
  } catch (...) {
    copy_error(error, error_size, "out of memory");
  }
  delete made;
  return nullptr;
}

}  // namespace

extern "C" {

int dynfilter_abi_version(void) {
  return DYNFILTER_ABI_VERSION;
}
const char* dynfilter_version(void) {
  return version();
}

dynfilter_filter* dynfilter_create(const char* name_path_or_text, char* error, size_t error_size) {
  return create(name_path_or_text, error, error_size,
                [](DynFilter& f, const char* text) { return f.load(text); });
}
dynfilter_filter* dynfilter_create_from_file(const char* path, char* error, size_t error_size) {
  return create(path, error, error_size, [](DynFilter& f, const char* text) { return f.load_file(text); });
}
dynfilter_filter* dynfilter_create_from_text(const char* yaml, char* error, size_t error_size) {
  return create(yaml, error, error_size, [](DynFilter& f, const char* text) { return f.load_text(text); });
}
void dynfilter_destroy(dynfilter_filter* filter) {
  delete filter;
}

void dynfilter_frame_init(dynfilter_frame* frame) {
  if (frame == nullptr) return;
  *frame = dynfilter_frame();
  frame->struct_size = sizeof(dynfilter_frame);
  frame->depth_unit_m = 1;
  frame->rotation[0] = frame->rotation[4] = frame->rotation[8] = 1;
  frame->motion_rotation[0] = frame->motion_rotation[4] = frame->motion_rotation[8] = 1;
  frame->motion_frame_id = -1;
  frame->boxes_frame_id = frame->mask_frame_id = frame->match_frame_id = -1;
}

int dynfilter_prepare(dynfilter_filter* filter, const dynfilter_frame* frame) {
  if (filter == nullptr) return 1;
  if (frame == nullptr || frame->struct_size != sizeof(dynfilter_frame))
    return fail(filter, frame == nullptr ? "expected a frame, got NULL" : kOtherStruct);
  if (short_row(*frame, frame->grey, frame->grey_stride_bytes, 1))
    return fail(filter, "grey_stride_bytes is less than a row of the image");
  const cv::Mat grey = image_of(frame->grey, frame->grey_stride_bytes, CV_8UC1, *frame);
  return filter->filter.prepare(grey, frame->timestamp_s) ? 0 : fail(filter, filter->filter.error().c_str());
}
int dynfilter_process(dynfilter_filter* filter, const dynfilter_frame* frame, int call_point,
                      dynfilter_verdicts* verdicts) {
  if (filter == nullptr) return 1;
  if (frame == nullptr || verdicts == nullptr) return fail(filter, "expected a frame and verdicts, got NULL");
  if (frame->struct_size != sizeof(dynfilter_frame)) return fail(filter, kOtherStruct);
  if (call_point < 0 || call_point > 2) return fail(filter, "unknown call point");
  return guarded(filter, [&] {
    const std::string wrong = fault_of(*frame);
    if (!wrong.empty()) return wrong;
    fill(*frame, filter->frame);
    const bool done =
        filter->filter.process(filter->frame, static_cast<CallPoint>(call_point), filter->verdicts);
    if (!done) return filter->filter.error();
    filter->notes.clear();
    for (const std::string& note : filter->verdicts.notes) filter->notes += note + "\n";
    show(*filter, *verdicts);
    return std::string();
  });
}

int dynfilter_update_pose(dynfilter_filter* filter, const dynfilter_frame* frame, size_t inliers,
                          size_t outliers) {
  if (filter == nullptr) return 1;
  if (frame == nullptr || frame->struct_size != sizeof(dynfilter_frame))
    return fail(filter, frame == nullptr ? "expected a frame, got NULL" : kOtherStruct);
  return guarded(filter, [&] {
    const std::string wrong = fault_of(*frame);
    if (!wrong.empty()) return wrong;
    Frame given;
    fill_features(*frame, given);
    fill_geometry(*frame, given);
    Tracking tracking;
    tracking.keypoints.swap(given.keypoints), tracking.map_point_ids.swap(given.map_point_ids);
    tracking.inliers = inliers, tracking.outliers = outliers;
    const bool done = filter->filter.update_pose(frame->id, given.T_world_camera, given.pose_kind, tracking);
    return done ? std::string() : filter->filter.error();
  });
}
int dynfilter_lost(dynfilter_filter* filter) {
  if (filter == nullptr) return 1;
  return filter->filter.lost() ? 0 : fail(filter, filter->filter.error().c_str());
}
size_t dynfilter_moved_map_points(const dynfilter_filter* filter, int64_t* ids, size_t capacity) {
  if (filter == nullptr) return 0;
  const std::vector<std::int64_t> moved = filter->filter.moved_map_points();
  if (ids != nullptr) std::copy_n(moved.begin(), std::min(moved.size(), capacity), ids);
  return moved.size();
}

int dynfilter_reset(dynfilter_filter* filter) {
  if (filter == nullptr) return 1;
  return filter->filter.reset() ? 0 : fail(filter, filter->filter.error().c_str());
}
int dynfilter_record(dynfilter_filter* filter, const char* file, int max_mb) {
  if (filter == nullptr) return 1;
  if (file == nullptr) return fail(filter, "expected a file, got NULL");
  return filter->filter.record(file, max_mb) ? 0 : fail(filter, filter->filter.error().c_str());
}
const char* dynfilter_stage_name(const dynfilter_filter* filter, size_t stage) {
  return filter == nullptr || stage >= filter->verdicts.stages.size()
             ? ""
             : filter->verdicts.stages[stage].c_str();
}
int dynfilter_get_stage_report(const dynfilter_filter* filter, size_t stage, dynfilter_stage_report* report,
                               size_t report_size) {
  if (filter == nullptr || report == nullptr || stage >= filter->filter.reports().size()) return 1;
  const StageReport& from = filter->filter.reports()[stage];
  dynfilter_stage_report to{};
  to.name = from.name.c_str(), to.path = from.path.c_str(), to.note = from.note.c_str();
  to.skipped = from.skipped ? 1 : 0, to.failed = from.failed ? 1 : 0;
  to.judged = from.judged, to.dynamic = from.dynamic;
  to.unknown = from.unknown, to.prior = from.prior;
  to.time_ms = from.time_ms;
  std::memcpy(report, &to, std::min(report_size, sizeof to));
  return 0;
}
const char* dynfilter_last_error(const dynfilter_filter* filter) {
  return filter == nullptr ? "expected a dynfilter, got NULL" : filter->error.c_str();
}

}  // extern "C"
