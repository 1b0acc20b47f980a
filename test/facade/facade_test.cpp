// SPDX-License-Identifier: MIT
#include <dynfilter/facade/dynfilter.h>

#include <cmath>
#include <cstring>
#include <dynfilter/facade/facade.hpp>
#include <dynfilter/filters/builtin.hpp>
#include <dynfilter/io/detections.hpp>
#include <dynfilter/io/image_file.hpp>
#include <dynfilter/io/tum_sequence.hpp>
#include <dynfilter/pipeline/yaml.hpp>
#include <dynfilter/synth/exact_scene_presets.hpp>
#include <filesystem>
#include <limits>
#include <memory>
#include <opencv2/features2d.hpp>

#include "doctest/doctest.h"

using namespace dynfilter;

namespace {

std::string preset_file(const std::string& name) {
  return std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/" + name + ".yaml";
}

template <class T>
std::vector<T> copy(Span<const T> values) {
  return {values.begin(), values.end()};
}

facade::Frame facade_frame(const FrameView& view) {
  facade::Frame frame;
  frame.id = view.id, frame.timestamp_s = view.timestamp_s;
  frame.keypoints = copy(view.keypoints);
  frame.keypoints_undistorted = copy(view.keypoints_undistorted);
  frame.descriptors = view.descriptors;
  frame.depth_m = copy(view.depth_m);
  frame.grey = view.grey, frame.depth = view.depth, frame.depth_unit_m = view.depth_unit_m;
  frame.has_camera = view.camera.has_value();
  if (view.camera) {
    frame.camera.fx_px = view.camera->fx_px, frame.camera.fy_px = view.camera->fy_px;
    frame.camera.cx_px = view.camera->cx_px, frame.camera.cy_px = view.camera->cy_px;
    std::copy(view.camera->distortion.begin(), view.camera->distortion.end(), frame.camera.distortion);
    frame.camera.baseline_fx_px_m = view.camera->baseline_fx_px_m;
    frame.camera.width_px = view.camera->width_px, frame.camera.height_px = view.camera->height_px;
  }
  frame.pose_kind = static_cast<facade::PoseKind>(static_cast<int>(view.pose_provenance));
  std::copy(view.T_world_camera.rotation.begin(), view.T_world_camera.rotation.end(),
            frame.T_world_camera.rotation);
  std::copy(view.T_world_camera.translation_m.begin(), view.T_world_camera.translation_m.end(),
            frame.T_world_camera.translation_m);
  frame.map_point_ids = copy(view.map_point_ids);
  frame.map_points_world_m = copy(view.map_points_world_m);
  frame.has_boxes = view.detections.has_value();
  if (view.detections) {
    frame.boxes_frame_id = view.detections->frame_id;
    for (const Detection& d : view.detections->detections) {
      facade::Box box;
      box.box = d.box, box.class_id = d.class_id, box.class_name = d.class_name, box.score = d.score;
      box.track_id = d.track_id, box.mask = d.mask;
      frame.boxes.push_back(box);
    }
  }
  frame.has_matches = view.matches.has_value();
  if (view.matches) {
    frame.match_frame_id = view.matches->reference_frame_id;
    frame.match_index = copy(view.matches->reference_index);
  }
  return frame;
}

/// Keeps what a C frame points at.
struct CFrame {
  explicit CFrame(const facade::Frame& from) {
    dynfilter_frame_init(&frame);
    frame.id = from.id, frame.timestamp_s = from.timestamp_s;
    for (const cv::KeyPoint& k : from.keypoints)
      keypoints.push_back({k.pt.x, k.pt.y, k.size, k.angle, k.response, k.octave});
    frame.keypoint_count = keypoints.size(), frame.keypoints = keypoints.data();
    if (!from.depth_m.empty()) frame.depth_m = from.depth_m.data();
    if (!from.descriptors.empty())
      frame.descriptors = from.descriptors.data,
      frame.descriptor_bytes = static_cast<std::size_t>(from.descriptors.cols);
    frame.width_px = from.grey.cols, frame.height_px = from.grey.rows;
    frame.grey = from.grey.data, frame.grey_stride_bytes = from.grey.step;
    frame.depth = from.depth.data, frame.depth_stride_bytes = from.depth.step;
    frame.depth_type = from.depth.empty() ? DYNFILTER_DEPTH_NONE : DYNFILTER_DEPTH_U16;
    frame.depth_unit_m = from.depth_unit_m;
    frame.has_camera = from.has_camera;
    frame.fx_px = from.camera.fx_px, frame.fy_px = from.camera.fy_px;
    frame.cx_px = from.camera.cx_px, frame.cy_px = from.camera.cy_px;
    frame.has_boxes = from.has_boxes, frame.boxes_frame_id = from.boxes_frame_id;
    for (const facade::Box& b : from.boxes)
      boxes.push_back({b.box.x, b.box.y, b.box.width, b.box.height, b.score, b.class_id, b.track_id,
                       b.class_name.c_str()});
    frame.box_count = boxes.size(), frame.boxes = boxes.data();
  }
  dynfilter_frame frame;
  std::vector<dynfilter_keypoint> keypoints;
  std::vector<dynfilter_box> boxes;
};

bool same_bits(const float* other, const std::vector<float>& values) {
  return values.empty() || std::memcmp(other, values.data(), values.size() * sizeof(float)) == 0;
}

void check_equal(const Verdict& verdict, const facade::Verdicts& other) {
  REQUIRE(other.keep.size() == verdict.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < verdict.size(); ++i) {
    different += (other.keep[i] != 0) != verdict.keep(i) ? 1 : 0;
    different += (other.decision[i] == 1) != (verdict.decision[i] == Vote::Dynamic) ? 1 : 0;
    different += (other.decision[i] == -1) != (verdict.decision[i] == Vote::Static) ? 1 : 0;
  }
  CHECK(different == 0);
  CHECK(same_bits(other.suspicion.data(), verdict.suspicion));
  CHECK(other.reasons == verdict.reasons);
  CHECK(other.restored == verdict.restored);
  CHECK(other.rejected == verdict.report.rejected);
  const auto lines = [](const std::vector<std::string>& notes) {
    std::string text;
    for (const std::string& note : notes) text += note + '\n';
    return text;
  };
  CHECK(lines(other.notes) == lines(verdict.report.notes));
  REQUIRE(other.stages.size() == verdict.report.stages.size());
}

void check_equal(const Verdict& verdict, const dynfilter_verdicts& other) {
  REQUIRE(other.count == verdict.size());
  for (std::size_t i = 0; i < verdict.size(); ++i) REQUIRE((other.keep[i] != 0) == verdict.keep(i));
  CHECK(same_bits(other.suspicion, verdict.suspicion));
  CHECK(std::equal(verdict.reasons.begin(), verdict.reasons.end(), other.reasons));
  CHECK(other.rejected == verdict.report.rejected);
}

}  // namespace

TEST_CASE("an exact scene through the C++11 interface: the verdicts of the headers, bit for bit") {
  for (const std::string name : {"dynfilter", "dynfilter_mono", "rts_slam"}) {
    CAPTURE(name);
    const synth::ExactScene scene = synth::preset(synth::Preset::General);
    Pipeline pipeline(pipeline_from_file(preset_file(name), builtin_filters()));
    facade::DynFilter filter;
    REQUIRE(filter.load_file(preset_file(name)));
    facade::Verdicts verdicts;
    std::size_t rejected = 0;
    for (int k = 0; k < 8; ++k) {
      const synth::ExactFrame frame = scene.frame(k);
      const facade::Frame same = facade_frame(frame.view());
      for (const auto& [point, facade_point] :
           {std::pair(CallPoint::BeforePose, facade::CallPoint::BeforePose),
            std::pair(CallPoint::AtKeyframe, facade::CallPoint::AtKeyframe)}) {
        const Verdict& verdict = pipeline.process(frame.view(), point);
        REQUIRE(filter.process(same, facade_point, verdicts));
        check_equal(verdict, verdicts);
        rejected += verdicts.rejected;
      }
    }
    CHECK(rejected > 50);
  }
}

TEST_CASE("real frames through the C++11 and the C interface: the verdicts of the headers, bit for bit") {
  const std::filesystem::path folder =
      std::filesystem::path(DYNFILTER_DATA_DIR) / "tum_fr3_walking_halfsphere";
  if (!std::filesystem::exists(folder)) {
    MESSAGE("skipped: no ../shared/data");
    return;
  }
  const io::TumSequence sequence = io::TumSequence::open(folder);
  const io::DetectionTrack boxes = io::read_detections(folder / "detections_yolov8.txt");
  const auto orb = cv::ORB::create(1000);
  for (const std::string name : {"dynfilter", "rts_slam"}) {
    CAPTURE(name);
    Pipeline pipeline(pipeline_from_file(preset_file(name), builtin_filters()));
    facade::DynFilter filter;
    REQUIRE(filter.load_file(preset_file(name)));
    char error[200] = "";
    const std::unique_ptr<dynfilter_filter, void (*)(dynfilter_filter*)> c_filter(
        dynfilter_create_from_file(preset_file(name).c_str(), error, sizeof error), dynfilter_destroy);
    REQUIRE(c_filter);
    facade::Verdicts verdicts;
    dynfilter_verdicts c_verdicts;
    std::size_t rejected = 0;
    for (int k = 0; k < 8; ++k) {
      const io::RgbdFrame image = sequence.load(static_cast<std::size_t>(k));
      std::vector<cv::KeyPoint> keypoints;
      cv::Mat descriptors;
      orb->detectAndCompute(image.grey, cv::noArray(), keypoints, descriptors);
      for (cv::KeyPoint& keypoint : keypoints) keypoint.class_id = -1;
      FrameView view;
      view.id = k, view.timestamp_s = image.timestamp_s;
      view.keypoints = keypoints, view.descriptors = descriptors;
      view.grey = image.grey, view.depth = image.depth, view.depth_unit_m = image.depth_unit_m;
      view.camera = sequence.camera();
      view.camera->width_px = image.grey.cols, view.camera->height_px = image.grey.rows;
      if (const std::vector<Detection>* found = boxes.at(image.timestamp_s))
        view.detections = DetectionInput{-1, *found};
      const Verdict& verdict = pipeline.before_pose(view);
      const facade::Frame same = facade_frame(view);
      CAPTURE(filter.error());
      REQUIRE(filter.process(same, facade::CallPoint::BeforePose, verdicts));
      check_equal(verdict, verdicts);
      const CFrame c_frame(same);
      REQUIRE(dynfilter_process(c_filter.get(), &c_frame.frame, DYNFILTER_BEFORE_POSE, &c_verdicts) == 0);
      check_equal(verdict, c_verdicts);
      rejected += verdicts.rejected;
    }
    CHECK(rejected > 100);
  }
}

TEST_CASE("keypoints at infinity through the C interface are kept, whatever the floor asks for") {
  const char* yaml =
      "pipeline:\n  floor: { min_features: 0, min_grid_coverage: 0.5 }\n  before_pose:\n"
      "    - semantic_box: { role: reject }\n";
  const std::unique_ptr<dynfilter_filter, void (*)(dynfilter_filter*)> filter(
      dynfilter_create_from_text(yaml, nullptr, 0), dynfilter_destroy);
  REQUIRE(filter);
  const float inf = std::numeric_limits<float>::infinity();
  const dynfilter_keypoint keypoints[] = {{1e30F, 5, 1, 0, 1, 0},
                                          {inf, -inf, 1, 0, 1, 0},
                                          {NAN, 5, 1, 0, 1, 0},
                                          {20, 20, 1, 0, 1, 0},
                                          {300, 200, 1, 0, 1, 0}};
  const dynfilter_box box{10, 10, 1000, 1000, 0.9F, 0, -1, "person"};
  dynfilter_frame frame;
  dynfilter_frame_init(&frame);
  frame.keypoints = keypoints, frame.keypoint_count = 5;
  frame.has_boxes = 1, frame.boxes = &box, frame.box_count = 1;
  dynfilter_verdicts verdicts;
  REQUIRE(dynfilter_process(filter.get(), &frame, DYNFILTER_BEFORE_POSE, &verdicts) == 0);
  REQUIRE(verdicts.count == 5);
  for (std::size_t i = 0; i < 3; ++i) CHECK(verdicts.decision[i] == 0);
  CHECK(std::string(verdicts.notes).find("3 keypoints are in no image") != std::string::npos);
}
