// SPDX-License-Identifier: MIT
// The C++11 interface. Images are in memory that is filled with garbage after each call, and freed or used
// again.
// The verdicts must be those of a pipeline whose frames stay in memory, bit for bit.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/facade/facade.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "bytes.hpp"
#include "frames.hpp"
#include "lent_memory.hpp"
#include "target.hpp"

namespace {

using namespace fuzz;
namespace facade = dynfilter::facade;

struct Subject {
  std::string name;
  dynfilter::Pipeline pipeline;
  facade::DynFilter frees, reuses;
};

std::vector<std::unique_ptr<Subject>>& subjects() {
  static std::vector<std::unique_ptr<Subject>> all = [] {
    std::vector<std::unique_ptr<Subject>> made;
    for (const std::string& file : pipeline_files(DYNFILTER_SOURCE_DIR)) {
      made.push_back(std::make_unique<Subject>(
          Subject{file,
                  dynfilter::Pipeline(dynfilter::pipeline_from_file(file, dynfilter::builtin_filters())),
                  {},
                  {}}));
      require(made.back()->frees.load_file(file) && made.back()->reuses.load_file(file),
              "a preset can be loaded");
    }
    return made;
  }();
  return all;
}

facade::Transform transform_of(const dynfilter::Pose& from) {
  facade::Transform to;
  std::copy(from.rotation.begin(), from.rotation.end(), std::begin(to.rotation));
  std::copy(from.translation_m.begin(), from.translation_m.end(), std::begin(to.translation_m));
  return to;
}

void add_motion_prior(facade::Frame& to, const dynfilter::MotionPrior& from) {
  to.motion_kind = from.has_translation ? facade::MotionKind::TurnAndTranslation : facade::MotionKind::Turn;
  to.motion_frame_id = from.reference_frame_id;
  to.T_current_reference = transform_of(from.T_current_reference);
  std::copy(from.covariance.begin(), from.covariance.end(), std::begin(to.motion_covariance));
}

facade::Frame facade_frame(const OwnedFrame& from, LentMemory& memory) {
  facade::Frame to;
  to.id = from.id, to.timestamp_s = from.timestamp_s;
  to.keypoints = from.keypoints, to.keypoints_undistorted = from.undistorted;
  to.descriptors = memory.image(from.descriptors);
  to.depth_m = from.depth_m, to.right_u_px = from.right_u_px;
  to.grey = memory.image(from.grey), to.right_grey = memory.image(from.right),
  to.depth = memory.image(from.depth);
  to.depth_unit_m = from.depth_unit_m;
  to.has_camera = from.has_camera;
  const dynfilter::Camera& c = from.camera;
  to.camera.fx_px = c.fx_px, to.camera.fy_px = c.fy_px, to.camera.cx_px = c.cx_px, to.camera.cy_px = c.cy_px;
  std::copy(c.distortion.begin(), c.distortion.end(), std::begin(to.camera.distortion));
  to.camera.baseline_fx_px_m = c.baseline_fx_px_m;
  to.camera.width_px = c.width_px, to.camera.height_px = c.height_px;
  to.pose_kind = static_cast<facade::PoseKind>(static_cast<int>(from.provenance));
  to.T_world_camera = transform_of(from.pose);
  if (from.prior) add_motion_prior(to, *from.prior);
  to.map_point_ids = from.map_point_ids, to.map_points_world_m = from.map_points;
  to.has_boxes = from.has_boxes, to.boxes_frame_id = from.boxes_id;
  for (const dynfilter::Detection& box : from.boxes) {
    to.boxes.emplace_back();
    to.boxes.back().box = box.box, to.boxes.back().score = box.score;
    to.boxes.back().class_id = box.class_id, to.boxes.back().class_name = box.class_name;
    to.boxes.back().track_id = box.track_id, to.boxes.back().mask = memory.image(box.mask);
  }
  if (from.has_mask) to.mask = memory.image(from.labels);
  to.mask_frame_id = from.mask_id;
  to.has_matches = from.has_matches, to.match_index = from.match_index, to.match_frame_id = from.match_id;
  return to;
}

template <class T>
void overwrite(std::vector<T>& values, std::uint8_t garbage) {
  if (!values.empty()) std::memset(static_cast<void*>(values.data()), garbage, values.size() * sizeof(T));
}

facade::Verdicts process(facade::DynFilter& filter, const OwnedFrame& from, facade::CallPoint point,
                         Host host, std::uint8_t garbage) {
  LentMemory memory(host, garbage);
  facade::Frame frame = facade_frame(from, memory);
  facade::Verdicts verdicts;
  if (!filter.process(frame, point, verdicts)) fail("a frame can be judged", filter.error());
  frame.boxes.clear();
  frame.grey = frame.right_grey = frame.depth = frame.mask = frame.descriptors = cv::Mat();
  overwrite(frame.keypoints, garbage), overwrite(frame.keypoints_undistorted, garbage);
  overwrite(frame.depth_m, garbage), overwrite(frame.right_u_px, garbage);
  overwrite(frame.map_point_ids, garbage), overwrite(frame.map_points_world_m, garbage);
  overwrite(frame.match_index, garbage);
  require(memory.take_back() == 0, "no image is referred to after the call");
  return verdicts;
}

void same(const dynfilter::Verdict& a, const facade::Verdicts& b, const Subject& subject) {
  const std::size_t n = a.size();
  bool equal = b.keep.size() == n && a.report.notes == b.notes && a.suspicion == b.suspicion &&
               a.restored == b.restored && a.reasons == b.reasons;
  for (std::size_t i = 0; equal && i < n; ++i) {
    const int decision = a.decision[i] == dynfilter::Vote::Dynamic  ? 1
                         : a.decision[i] == dynfilter::Vote::Static ? -1
                                                                    : 0;
    equal = b.decision[i] == decision;
  }
  if (!equal) fail("the C++11 interface gives the pipeline's verdict", subject.name);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  Subject& subject = *subjects()[in.byte() % subjects().size()];
  subject.pipeline.reset(), subject.frees.reset(), subject.reuses.reset();
  Frames frames(in);
  std::list<OwnedFrame> memory;  // the pipeline's
  for (int k = 0, n = 2 + in.below(6); k < n; ++k) {
    OwnedFrame& frame = memory.emplace_back(frames.next());
    frame.keyframe_points.clear(), frame.depth_handed_over = false;  // not in this interface
    if (frame.labels.empty()) frame.has_mask = false;
    const int calls = in.below(8);
    for (const int point : {0, 1, 2}) {
      if (point > 0 && (calls >> point & 1) == 0) continue;
      const dynfilter::Verdict& verdict =
          subject.pipeline.process(frame.view(), static_cast<dynfilter::CallPoint>(point));
      const auto at = static_cast<facade::CallPoint>(point);
      same(verdict, process(subject.frees, frame, at, Host::Frees, 0x00), subject);
      same(verdict, process(subject.reuses, frame, at, Host::Reuses, 0xff), subject);
    }
  }
  return 0;
}
