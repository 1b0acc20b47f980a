// SPDX-License-Identifier: MIT
// The C interface with structs of any content. Pointers are NULL or point to as much as the numbers beside them
// say, which is all that a host must promise.
#include <dynfilter/facade/dynfilter.h>
#include <cstdint>
#include <string>
#include <vector>

#include "bytes.hpp"
#include "target.hpp"

namespace {

using fuzz::Bytes;
using fuzz::require;

/// Memory of one call of the library.
struct Memory {
  std::vector<dynfilter_keypoint> keypoints;
  std::vector<float> depth_m, right_u_px, map_points;
  std::vector<std::uint8_t> descriptors, grey, depth, mask;
  std::vector<std::int64_t> ids;
  std::vector<std::int32_t> matches;
  std::vector<dynfilter_box> boxes;
  std::string name;
};

float number(Bytes& in) {
  const double value = in.odd();
  return std::abs(value) > 3e38 ? 3e38F : static_cast<float>(value);
}

/// Strides may be too short, which the library must refuse before it reads.
std::size_t stride(Bytes& in, std::size_t row_bytes) {
  switch (in.below(4)) {
    case 0:
      return row_bytes + 5 * 4;
    case 1:
      return in.flag() ? in.byte() : in.take<std::size_t>() & 0xffU;
    default:
      return 0;
  }
}

/// As much as the largest stride can want.
const std::uint8_t* image(Bytes& in, std::vector<std::uint8_t>& memory) {
  if (in.below(4) == 0) return nullptr;
  memory.assign(64 * (64 * 4 + 256), in.byte());
  return memory.data();
}

void fill_features(Bytes& in, dynfilter_frame& f, Memory& m) {
  const std::size_t n = f.keypoint_count = static_cast<std::size_t>(in.below(20));
  for (std::size_t i = 0; i < n; ++i)
    m.keypoints.push_back(
        {in.flag() ? number(in) : in.byte() % 64, static_cast<float>(in.byte() % 48), 31, 0, 1, in.below(9)});
  const auto have = [&](auto& values, std::size_t count) {
    values.resize(count);
    for (auto& value : values) value = static_cast<std::remove_reference_t<decltype(value)>>(in.byte());
    return in.flag() ? values.data() : nullptr;
  };
  f.keypoints = m.keypoints.data();
  f.depth_m = have(m.depth_m, n), f.right_u_px = have(m.right_u_px, n);
  f.map_point_ids = have(m.ids, n), f.match_index = have(m.matches, n),
  f.map_points_xyz_m = have(m.map_points, 3 * n);
  if (n > 0 && f.depth_m != nullptr) m.depth_m[in.byte() % n] = number(in);
  f.descriptor_bytes = static_cast<std::size_t>(in.below(40));
  f.descriptors = have(m.descriptors, n * f.descriptor_bytes);
}

void fill_images(Bytes& in, dynfilter_frame& f, Memory& m) {
  f.width_px = in.below(65), f.height_px = in.below(65);
  if (in.below(8) == 0) f.width_px = -f.width_px;
  f.grey = image(in, m.grey), f.depth = image(in, m.depth), f.mask = image(in, m.mask);
  f.depth_type = in.below(8) == 0 ? in.take<std::int32_t>() : in.below(3);
  const auto w = static_cast<std::size_t>(std::max(f.width_px, 0));
  f.grey_stride_bytes = stride(in, w), f.mask_stride_bytes = stride(in, w);
  f.depth_stride_bytes = stride(in, w * (f.depth_type == DYNFILTER_DEPTH_U16 ? 2 : 4));
  f.depth_unit_m = in.flag() ? 0.001 : in.odd();
}

void fill_boxes(Bytes& in, dynfilter_frame& f, Memory& m) {
  f.has_boxes = in.below(3);
  m.name.assign(in.byte(), static_cast<char>(1 + in.byte() % 255));
  for (int n = in.below(6); n > 0; --n) {
    dynfilter_box box{};
    box.x_px = number(in), box.y_px = number(in), box.width_px = number(in), box.height_px = number(in);
    box.score = in.flag() ? 0.9F : number(in);
    box.class_id = in.take<std::int32_t>(), box.track_id = in.take<std::int8_t>();
    box.class_name = in.below(3) == 0 ? m.name.c_str() : in.flag() ? "person" : nullptr;
    box.mask = in.flag() ? f.mask : nullptr;
    box.mask_stride_bytes = stride(in, static_cast<std::size_t>(std::max(f.width_px, 0)));
    m.boxes.push_back(box);
  }
  f.box_count = m.boxes.size(), f.boxes = m.boxes.data();
}

void fill_geometry(Bytes& in, dynfilter_frame& f) {
  f.has_camera = in.below(3);
  f.fx_px = f.fy_px = 60, f.cx_px = 32, f.cy_px = 24, f.baseline_fx_px_m = in.flag() ? 8 : 0;
  double* const values[] = {
      &f.fx_px,       &f.cx_px,       &f.distortion[0],    &f.distortion[3], &f.baseline_fx_px_m,
      &f.rotation[0], &f.rotation[5], &f.translation_m[1], &f.timestamp_s};
  for (int n = in.below(4); n > 0; --n) *values[in.byte() % std::size(values)] = in.odd();
  f.pose_kind = in.flag() ? in.below(5) : in.take<std::int32_t>();
}

/// Counts and sizes that no array can have: these are refused or not read.
void make_odd(Bytes& in, dynfilter_frame& f) {
  switch (in.below(24)) {
    case 0:
      f.struct_size = in.take<std::size_t>();
      break;
    case 1:
      f.keypoints = nullptr;
      break;
    case 2:
      f.keypoint_count = SIZE_MAX - in.byte();
      break;
    case 3:
      f.descriptor_bytes = SIZE_MAX - in.byte();
      break;
    case 4:
      f.boxes = nullptr, f.box_count = in.take<std::size_t>();
      break;
    case 5:
      f.width_px = f.height_px = INT32_MAX, f.grey = f.mask = nullptr, f.depth = nullptr, f.has_boxes = 0;
      break;
    case 6:
      f.boxes_frame_id = f.mask_frame_id = in.take<std::int64_t>();
      break;
    case 7:
      f.match_frame_id = in.take<std::int64_t>();
      break;
    default:
      break;
  }
}

void check(dynfilter_filter* filter, const dynfilter_frame& frame, const dynfilter_verdicts& v) {
  require(v.count == frame.keypoint_count, "a verdict has an entry per feature");
  std::size_t rejected = 0;
  for (std::size_t i = 0; i < v.count; ++i) {
    require(v.keep[i] == (v.decision[i] == 1 ? 0 : 1), "what is dynamic is not kept");
    require(v.suspicion[i] >= 0 && v.suspicion[i] <= 1, "a suspicion is in [0, 1]");
    require(v.stage_count >= 64 || v.reasons[i] >> v.stage_count == 0, "reasons name stages of the report");
    rejected += v.keep[i] == 0 ? 1 : 0;
  }
  require(v.rejected == rejected, "the count of what is rejected");
  for (std::size_t k = 0; k < v.stage_count; ++k) {
    dynfilter_stage_report report;
    require(dynfilter_get_stage_report(filter, k, &report, sizeof(report)) == 0, "every stage has a report");
    if (report.failed != 0) fuzz::fail("no stage throws", report.note);
    require(*dynfilter_stage_name(filter, k) != '\0', "every stage has a name");
  }
  require(*dynfilter_stage_name(filter, v.stage_count) == '\0', "no stage beyond the last");
}

dynfilter_filter* filter(int which) {
  static const char* const names[] = {"dynfilter", "rts_slam", "des_slam", "ovd_slam", "dynaslam", "sg_slam"};
  static dynfilter_filter* made[std::size(names)] = {};
  const std::size_t k = static_cast<std::size_t>(which) % std::size(names);
  if (made[k] == nullptr) {
    const std::string file = std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/" + names[k] + ".yaml";
    made[k] = dynfilter_create_from_file(file.c_str(), nullptr, 0);
  }
  require(made[k] != nullptr, "a preset can be loaded");
  dynfilter_reset(made[k]);
  return made[k];
}

void make_from_text(Bytes& in) {
  char error[32];
  const std::size_t size = in.byte() % (sizeof(error) + 1);
  dynfilter_filter* made = dynfilter_create(in.rest().c_str(), error, size);
  require(made != nullptr || size == 0 || std::memchr(error, 0, size) != nullptr,
          "an error ends within its buffer");
  dynfilter_destroy(made);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  const int which = in.byte();
  if (which == 255) {
    make_from_text(in);
    return 0;
  }
  dynfilter_filter* const subject = filter(which);
  for (int k = 0, n = 1 + in.below(4); k < n; ++k) {
    Memory memory;
    dynfilter_frame frame;
    dynfilter_frame_init(&frame);
    frame.id = k, frame.timestamp_s = k / 30.0, frame.match_frame_id = k - 1;
    fill_features(in, frame, memory);
    fill_images(in, frame, memory);
    fill_boxes(in, frame, memory);
    fill_geometry(in, frame);
    make_odd(in, frame);
    dynfilter_verdicts verdicts;
    const int point = in.below(8) == 0 ? in.take<std::int32_t>() : in.below(3);
    if (dynfilter_process(subject, &frame, point, &verdicts) == 0)
      check(subject, frame, verdicts);
    else
      require(*dynfilter_last_error(subject) != '\0', "an error has a message");
  }
  return 0;
}
