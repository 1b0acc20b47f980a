// SPDX-License-Identifier: MIT
// The C interface with structs of any content. Pointers are NULL or point to as much as the numbers beside
// them say, which is all that a host must promise. Each array is an allocation of its own, and all are filled
// with garbage and freed after the call. A second filter sees other garbage: its verdicts must be the same.
#include <dynfilter/facade/dynfilter.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "bytes.hpp"
#include "lent_memory.hpp"
#include "target.hpp"

namespace {

using fuzz::Bytes;
using fuzz::LentMemory;
using fuzz::require;

constexpr int kSide_px = 64;

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

/// As much as width, height and stride say, or nothing at all. Noise, so that what is read makes a
/// difference.
const std::uint8_t* image(Bytes& in, LentMemory& memory, const dynfilter_frame& f, std::size_t pixel_bytes,
                          std::size_t stride_bytes) {
  if (in.below(4) == 0) return nullptr;
  const auto rows = static_cast<std::size_t>(std::max(f.height_px, 0));
  const std::size_t row = pixel_bytes * static_cast<std::size_t>(std::max(f.width_px, 0));
  const bool refused = stride_bytes != 0 && stride_bytes < row;
  const std::size_t step = stride_bytes == 0 ? row : stride_bytes;
  const std::size_t size = refused || rows == 0 || row == 0 ? 1 : step * (rows - 1) + row;
  auto* pixels = static_cast<std::uint8_t*>(memory.bytes(size));
  const std::uint8_t base = in.byte();
  for (std::size_t k = 0; k < size; ++k)
    pixels[k] = static_cast<std::uint8_t>(base & (k % 7 + k / 64 % 5 < 6 ? 0xffU : 0x0fU));
  return pixels;
}

void fill_features(Bytes& in, dynfilter_frame& f, LentMemory& m) {
  const std::size_t n = f.keypoint_count = static_cast<std::size_t>(in.below(20));
  std::vector<dynfilter_keypoint> keypoints;
  for (std::size_t i = 0; i < n; ++i)
    keypoints.push_back(
        {in.flag() ? number(in) : in.byte() % 64, static_cast<float>(in.byte() % 48), 31, 0, 1, in.below(9)});
  f.keypoints = m.array(keypoints.data(), n);
  const auto have = [&](const auto* kind, std::size_t count) {
    std::vector<std::remove_cv_t<std::remove_pointer_t<decltype(kind)>>> values(count);
    for (auto& value : values) value = static_cast<std::remove_reference_t<decltype(value)>>(in.byte());
    auto* lent = m.array(values.data(), count);
    return in.flag() ? lent : nullptr;
  };
  auto* const depth_m = have(f.depth_m, n);
  f.depth_m = depth_m, f.right_u_px = have(f.right_u_px, n);
  f.map_point_ids = have(f.map_point_ids, n), f.match_index = have(f.match_index, n),
  f.map_points_xyz_m = have(f.map_points_xyz_m, 3 * n);
  if (n > 0 && depth_m != nullptr) depth_m[in.byte() % n] = number(in);
  f.descriptor_bytes = static_cast<std::size_t>(in.below(40));
  f.descriptors = have(f.descriptors, n * f.descriptor_bytes);
}

void fill_images(Bytes& in, dynfilter_frame& f, LentMemory& m) {
  // One size for most frames: others reset what is matched.
  f.width_px = in.flag() ? kSide_px : in.below(kSide_px + 1);
  f.height_px = f.width_px == kSide_px ? 48 : in.below(kSide_px + 1);
  if (in.below(8) == 0) f.width_px = -f.width_px;
  f.depth_type = in.below(8) == 0 ? in.take<std::int32_t>() : in.below(3);
  const auto w = static_cast<std::size_t>(std::max(f.width_px, 0));
  const std::size_t depth_bytes = f.depth_type == DYNFILTER_DEPTH_U16 ? 2 : 4;
  f.grey_stride_bytes = stride(in, w), f.mask_stride_bytes = stride(in, w);
  f.depth_stride_bytes = stride(in, w * depth_bytes);
  f.grey = image(in, m, f, 1, f.grey_stride_bytes), f.mask = image(in, m, f, 1, f.mask_stride_bytes);
  f.depth = image(in, m, f, depth_bytes, f.depth_stride_bytes);
  f.right_grey = f.grey, f.right_grey_stride_bytes = f.grey_stride_bytes;  // no disparity
  f.depth_unit_m = in.flag() ? 0.001 : in.odd();
}

/// Half of them on the image, with a mask of their own, of a late frame, as a detector gives them.
void fill_boxes(Bytes& in, dynfilter_frame& f, LentMemory& m) {
  f.has_boxes = in.below(3);
  const std::size_t length = in.byte();
  const std::string name(length, static_cast<char>(1 + in.byte() % 255));
  std::vector<dynfilter_box> boxes;
  for (int n = in.below(6); n > 0; --n) {
    dynfilter_box box{};
    if (in.flag())
      box.x_px = 8, box.y_px = 8, box.width_px = box.height_px = static_cast<float>(in.below(kSide_px));
    else
      box.x_px = number(in), box.y_px = number(in), box.width_px = number(in), box.height_px = number(in);
    box.score = in.flag() ? 0.9F : number(in);
    box.class_id = in.take<std::int32_t>(), box.track_id = in.take<std::int8_t>();
    box.class_name = in.below(3) == 0 ? m.text(name) : in.flag() ? m.text("person") : nullptr;
    box.mask_stride_bytes = stride(in, static_cast<std::size_t>(std::max(f.width_px, 0)));
    box.mask = image(in, m, f, 1, box.mask_stride_bytes);
    boxes.push_back(box);
  }
  f.box_count = boxes.size(), f.boxes = m.array(boxes.data(), boxes.size());
  if (in.flag()) f.boxes_frame_id = std::max<std::int64_t>(f.id - in.below(4), 0);
  if (in.flag()) f.mask_frame_id = std::max<std::int64_t>(f.id - in.below(4), 0);
}

void fill_geometry(Bytes& in, dynfilter_frame& f) {
  f.has_camera = in.below(3);
  f.fx_px = f.fy_px = 60, f.cx_px = 32, f.cy_px = 24, f.baseline_fx_px_m = in.flag() ? 8 : 0;
  double* const values[] = {&f.fx_px,
                            &f.cx_px,
                            &f.distortion[0],
                            &f.distortion[3],
                            &f.baseline_fx_px_m,
                            &f.rotation[0],
                            &f.rotation[5],
                            &f.translation_m[1],
                            &f.timestamp_s,
                            &f.motion_rotation[0],
                            &f.motion_rotation[3],
                            &f.motion_translation_m[2],
                            &f.motion_covariance[1],
                            &f.motion_covariance[21]};
  for (int n = in.below(4); n > 0; --n) *values[in.byte() % std::size(values)] = in.odd();
  f.pose_kind = in.flag() ? in.below(5) : in.take<std::int32_t>();
  f.motion_kind = in.below(4);
  for (int k = 0; k < 6; ++k) f.motion_covariance[7 * k] = 1e-6;
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
      f.width_px = f.height_px = INT32_MAX, f.grey = f.right_grey = f.mask = nullptr, f.depth = nullptr,
      f.has_boxes = 0;
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

void check(dynfilter_filter* filter, std::size_t features, const dynfilter_verdicts& v) {
  require(v.count == features, "a verdict has an entry per feature");
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

/// Two filters of one pipeline file.
struct Pair {
  using Filter = std::unique_ptr<dynfilter_filter, void (*)(dynfilter_filter*)>;
  Filter first, second;
};
std::vector<Pair>& filters() {
  static std::vector<Pair> all = [] {
    const auto load = [](const std::string& file) {
      return Pair::Filter(dynfilter_create_from_file(file.c_str(), nullptr, 0), dynfilter_destroy);
    };
    std::vector<Pair> made;
    for (const std::string& file : fuzz::pipeline_files(DYNFILTER_SOURCE_DIR)) {
      made.push_back({load(file), load(file)});
      require(made.back().first && made.back().second, "a preset can be loaded");
    }
    return made;
  }();
  return all;
}

/// What a filter said of a frame, times excepted; of an error its text.
struct Said {
  std::string text;
  template <class T>
  void add(const T* values, std::size_t n) {
    text.append(reinterpret_cast<const char*>(values), n * sizeof(T));
  }
};

Said process(dynfilter_filter* filter, Bytes in, int k, std::uint8_t garbage, Bytes& after) {
  LentMemory memory(fuzz::Host::Frees, garbage);
  dynfilter_frame frame;
  dynfilter_frame_init(&frame);
  frame.id = k, frame.timestamp_s = k / 30.0, frame.match_frame_id = k - 1;
  fill_features(in, frame, memory);
  fill_images(in, frame, memory);
  fill_boxes(in, frame, memory);
  fill_geometry(in, frame);
  make_odd(in, frame);
  const int point = in.below(8) == 0 ? in.take<std::int32_t>() : in.below(3);
  const int tracking = in.below(8);  // of the frame before, which seldom has these keypoints
  after = in;
  frame.id = k - 1;
  if (tracking == 7) dynfilter_lost(filter);
  if (tracking >= 4) dynfilter_update_pose(filter, &frame, static_cast<std::size_t>(tracking) * 20, 20);
  frame.id = k;
  dynfilter_verdicts v;
  const bool done = dynfilter_process(filter, &frame, point, &v) == 0;
  const std::size_t n = frame.keypoint_count;
  memory.take_back();  // before the answers are read
  std::memset(static_cast<void*>(&frame), garbage, sizeof frame);
  Said said;
  if (!done) {
    require(*dynfilter_last_error(filter) != '\0', "an error has a message");
    said.text = dynfilter_last_error(filter);
    return said;
  }
  check(filter, n, v);
  said.add(v.keep, n), said.add(v.decision, n), said.add(v.suspicion, n), said.add(v.reasons, n);
  said.text += v.notes;
  for (std::size_t s = 0; s < v.stage_count; ++s) {
    dynfilter_stage_report report;
    dynfilter_get_stage_report(filter, s, &report, sizeof report);
    said.text += std::string(report.path) + report.note;
  }
  std::int64_t moved[8] = {};
  said.text += std::to_string(dynfilter_moved_map_points(filter, moved, std::size(moved)));
  said.add(moved, std::size(moved));
  return said;
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
  const Pair& pair = filters()[static_cast<std::size_t>(which) % filters().size()];
  dynfilter_filter *const first = pair.first.get(), *const second = pair.second.get();
  dynfilter_reset(first), dynfilter_reset(second);
  for (int k = 0, n = 1 + in.below(6); k < n; ++k) {
    Bytes rest = in;
    const Said a = process(first, in, k, 0x00, rest), b = process(second, in, k, 0xff, rest);
    if (a.text != b.text) fuzz::fail("what a host does with its memory after the call makes no difference");
    in = rest;
  }
  return 0;
}
