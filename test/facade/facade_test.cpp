// SPDX-License-Identifier: MIT
#include <dynfilter/facade/dynfilter.h>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <dynfilter/detectors/detections.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <dynfilter/facade/facade.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <filesystem>
#include <limits>
#include <memory>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"
#include "io/sequence.hpp"

using namespace dynfilter;

namespace {

/// Every preset but the one that needs labels.
std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines"))
    if (entry.path().extension() == ".yaml" && entry.path().stem() != "oracle")
      names.push_back(entry.path().stem().string());
  return names;
}
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
    frame.width_px = from.grey.empty() ? from.camera.width_px : from.grey.cols;
    frame.height_px = from.grey.empty() ? from.camera.height_px : from.grey.rows;
    std::copy(from.camera.distortion, from.camera.distortion + 5, frame.distortion);
    frame.baseline_fx_px_m = from.camera.baseline_fx_px_m;
    frame.pose_kind = static_cast<std::int32_t>(from.pose_kind);
    std::copy(from.T_world_camera.rotation, from.T_world_camera.rotation + 9, frame.rotation);
    std::copy(from.T_world_camera.translation_m, from.T_world_camera.translation_m + 3, frame.translation_m);
    if (!from.map_point_ids.empty()) frame.map_point_ids = from.map_point_ids.data();
    for (const cv::Point3f& p : from.map_points_world_m) map_points.insert(map_points.end(), {p.x, p.y, p.z});
    if (!map_points.empty()) frame.map_points_xyz_m = map_points.data();
    if (from.has_matches) frame.match_index = from.match_index.data();
    frame.match_frame_id = from.match_frame_id;
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
                       b.class_name.c_str(), b.mask.data, b.mask.step});
    frame.box_count = boxes.size(), frame.boxes = boxes.data();
  }
  dynfilter_frame frame;
  std::vector<dynfilter_keypoint> keypoints;
  std::vector<dynfilter_box> boxes;
  std::vector<float> map_points;
};

using CFilter = std::unique_ptr<dynfilter_filter, void (*)(dynfilter_filter*)>;
CFilter c_filter_of(const char* yaml) {
  return CFilter(dynfilter_create_from_text(yaml, nullptr, 0), dynfilter_destroy);
}

/// Boxes with instance masks: an ellipse in each box, in a matrix with rows longer than the image.
void add_instance_masks(std::vector<Detection>& detections, const Camera& camera) {
  for (Detection& detection : detections) {
    cv::Mat wide = cv::Mat::zeros(camera.height_px, camera.width_px + 7, CV_8UC1);
    const cv::Rect2f& box = detection.box;
    cv::ellipse(wide, cv::RotatedRect({box.x + box.width / 2, box.y + box.height / 2}, box.size(), 0),
                cv::Scalar(255), cv::FILLED);
    detection.mask = wide.colRange(0, camera.width_px);
  }
}

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
    different += other.weight[i] != verdict.weight(i) ? 1 : 0;
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
  for (std::size_t i = 0; i < verdict.size(); ++i) {
    REQUIRE((other.keep[i] != 0) == verdict.keep(i));
    REQUIRE(other.weight[i] == verdict.weight(i));
  }
  CHECK(same_bits(other.suspicion, verdict.suspicion));
  CHECK(std::equal(verdict.reasons.begin(), verdict.reasons.end(), other.reasons));
  CHECK(other.rejected == verdict.report.rejected);
}

}  // namespace

TEST_CASE("an exact scene through the C++11 interface: the verdicts of the headers, bit for bit") {
  for (const std::string& name : preset_names()) {
    CAPTURE(name);
    const testing::ExactScene scene = testing::preset(testing::Preset::General);
    Pipeline pipeline(pipeline_from_file(preset_file(name), builtin_filters()));
    facade::DynFilter filter;
    REQUIRE(filter.load_file(preset_file(name)));
    facade::Verdicts verdicts;
    std::size_t rejected = 0;
    for (int k = 0; k < 8; ++k) {
      const testing::ExactFrame frame = scene.frame(k);
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
    if (name == "dynfilter" || name == "dynfilter_mono" || name == "rts_slam") CHECK(rejected > 50);
  }
}

TEST_CASE("real frames through the C++11 and the C interface: the verdicts of the headers, bit for bit" *
          doctest::test_suite("shared_data")) {
  const std::filesystem::path folder =
      std::filesystem::path(DYNFILTER_DATA_DIR) / "tum_fr3_walking_halfsphere";
  if (!std::filesystem::exists(folder)) {
    MESSAGE("skipped: no ../shared/data");
    return;
  }
  const io::Sequence sequence = io::Sequence::open(folder);
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
      const io::SequenceFrame image = sequence.load(static_cast<std::size_t>(k));
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

TEST_CASE(
    "host matches and instance masks through the C interface: the verdicts of the headers, bit for bit") {
  // Matches alone: there is no image, no depth image and no descriptor to find any other.
  const char* yaml =
      "pipeline:\n  floor: { min_features: 0 }\n  correspondence: { source: host }\n  before_pose:\n"
      "    - semantic_mask: { source: instances, role: prior, dilate_px: 0 }\n"
      "    - by_region:\n        inside: { strict: epipolar }\n"
      "        outside: { any: [ epipolar, trajectory_consistency ] }\n";
  const testing::ExactScene scene = testing::preset(testing::Preset::General);
  Pipeline pipeline(pipeline_from_text(yaml, builtin_filters()));
  const CFilter filter = c_filter_of(yaml), without = c_filter_of(yaml);
  REQUIRE(filter);
  REQUIRE(without);
  dynfilter_verdicts verdicts;
  std::size_t rejected = 0, suspects = 0, different = 0;
  for (int k = 0; k < 8; ++k) {
    testing::ExactFrame exact = scene.frame(k);
    exact.keypoints_undistorted.clear(), exact.descriptors = cv::Mat();  // the C interface computes the first
    if (!exact.detections || exact.detections->empty())
      exact.detections = {Detection{{100, 80, 200, 250}, 0, "person", 0.9F, -1, cv::Mat()}};
    exact.detections_frame_id = -1;
    add_instance_masks(*exact.detections, exact.camera);
    const FrameView view = exact.view();
    CHECK(view.matches.has_value() == (k > 0));
    const Verdict& verdict = pipeline.before_pose(view);
    const facade::Frame same = facade_frame(view);
    CFrame c_frame(same);
    REQUIRE(dynfilter_process(filter.get(), &c_frame.frame, DYNFILTER_BEFORE_POSE, &verdicts) == 0);
    check_equal(verdict, verdicts);
    rejected += verdicts.rejected;
    for (const std::uint8_t prior : verdict.prior) suspects += prior;
    c_frame.frame.match_index = nullptr;
    for (dynfilter_box& box : c_frame.boxes) box.mask = nullptr;
    REQUIRE(dynfilter_process(without.get(), &c_frame.frame, DYNFILTER_BEFORE_POSE, &verdicts) == 0);
    for (std::size_t i = 0; i < verdict.size(); ++i) different += verdicts.keep[i] != verdict.keep(i) ? 1 : 0;
  }
  CHECK(rejected > 50);
  CHECK(suspects > 50);
  CHECK(different > 50);
}

TEST_CASE("the C interface: matches that lead nowhere are none, sizes that cannot be are errors") {
  const char* yaml =
      "pipeline:\n  floor: { min_features: 0 }\n  correspondence: { source: host }\n  before_pose:\n"
      "    - trajectory_consistency: { mode: rigid }\n";
  const testing::ExactScene scene = testing::preset(testing::Preset::General);
  const CFilter odd = c_filter_of(yaml), none = c_filter_of(yaml);
  REQUIRE(odd);
  REQUIRE(none);
  for (int k = 0; k < 3; ++k) {
    const testing::ExactFrame exact = scene.frame(k);
    facade::Frame frame = facade_frame(exact.view()), same = frame;
    const std::int32_t nowhere[] = {-2, INT32_MIN, INT32_MAX, static_cast<std::int32_t>(exact.size()) + 50};
    for (std::size_t i = 0; k > 0 && i < 4; ++i) frame.match_index[i] = nowhere[i], same.match_index[i] = -1;
    CFrame c_frame(frame), c_same(same);
    dynfilter_verdicts a, b;
    REQUIRE(dynfilter_process(odd.get(), &c_frame.frame, DYNFILTER_BEFORE_POSE, &a) == 0);
    REQUIRE(dynfilter_process(none.get(), &c_same.frame, DYNFILTER_BEFORE_POSE, &b) == 0);
    CHECK(std::equal(a.decision, a.decision + a.count, b.decision));
    dynfilter_stage_report report;
    REQUIRE(dynfilter_get_stage_report(odd.get(), a.stage_count - 1, &report, sizeof report) == 0);
    const bool noted =
        std::string(report.note)
            .find("4 matches lead to features that frame " + std::to_string(k - 1) + " does not have") == 0;
    CHECK(noted == (k > 0));
  }

  const testing::ExactFrame exact = scene.frame(3);
  const cv::Mat image(exact.camera.height_px, exact.camera.width_px, CV_8UC1, cv::Scalar(1));
  const dynfilter_box box{10, 10, 50, 50, 0.9F, 0, -1, "person", image.data, 3};
  const auto error = [&](const auto& spoil) -> std::string {
    const facade::Frame source = facade_frame(exact.view());  // the C frame points into it
    CFrame c_frame(source);
    spoil(c_frame.frame);
    dynfilter_verdicts verdicts;
    const bool done = dynfilter_process(odd.get(), &c_frame.frame, DYNFILTER_BEFORE_POSE, &verdicts) == 0;
    return done ? "" : dynfilter_last_error(odd.get());
  };
  CHECK(error([](dynfilter_frame&) {}).empty());
  CHECK(error([&](dynfilter_frame& f) { f.has_boxes = 1, f.boxes = &box, f.box_count = 1; }) ==
        "boxes[0].mask_stride_bytes is less than a row of the image");
  CHECK(error([&](dynfilter_frame& f) { f.mask = image.data, f.mask_stride_bytes = 5; }) ==
        "mask_stride_bytes is less than a row of the image");
  CHECK(error([&](dynfilter_frame& f) {
          f.depth = image.data, f.depth_type = DYNFILTER_DEPTH_U16,
          f.depth_stride_bytes = static_cast<std::size_t>(image.cols);
        }) == "depth_stride_bytes is less than a row of the image");
  CHECK(error([](dynfilter_frame& f) { f.keypoints = nullptr; }) ==
        "keypoints is NULL, but keypoint_count is not 0");
  CHECK(error([](dynfilter_frame& f) { f.has_boxes = 1, f.boxes = nullptr, f.box_count = 2; }) ==
        "boxes is NULL, but box_count is not 0");
  CHECK(error([](dynfilter_frame& f) { f.keypoint_count = std::size_t{1} << 40U; }) ==
        "keypoint_count is more than 2^31 - 1");
}

namespace {

/// One stream through the pipeline and both interfaces, and what a host's tracker makes of it.
class Three {
 public:
  explicit Three(const std::string& yaml)
      : pipeline(pipeline_from_text(yaml, builtin_filters())), c(c_filter_of(yaml.c_str())) {
    REQUIRE(cpp11.load_text(yaml));
  }

  /// The verdict is the same three times.
  const Verdict& judge(const FrameView& view) {
    const facade::Frame frame = facade_frame(view);
    const CFrame in_c(frame);
    const Verdict& verdict = pipeline.before_pose(view);
    facade::Verdicts verdicts;
    dynfilter_verdicts c_verdicts;
    REQUIRE(cpp11.process(frame, facade::CallPoint::BeforePose, verdicts));
    REQUIRE(dynfilter_process(c.get(), &in_c.frame, DYNFILTER_BEFORE_POSE, &c_verdicts) == 0);
    check_equal(verdict, verdicts);
    check_equal(verdict, c_verdicts);
    std::string notes;
    for (const std::string& note : verdict.report.notes) notes += note + '\n';
    CHECK(c_verdicts.notes == notes);
    return verdict;
  }
  void track(const FrameView& view, const facade::Tracking& tracking) {
    pipeline.update_pose(view.id, view.T_world_camera, PoseProvenance::Estimated,
                         {tracking.keypoints, tracking.map_point_ids, tracking.inliers, tracking.outliers});
    facade::Frame frame;
    frame.id = view.id, frame.pose_kind = facade::PoseKind::Estimated;
    frame.T_world_camera = facade_frame(view).T_world_camera;
    frame.keypoints = tracking.keypoints, frame.map_point_ids = tracking.map_point_ids;
    const CFrame in_c(frame);
    CHECK(cpp11.update_pose(frame.id, frame.T_world_camera, frame.pose_kind, tracking));
    CHECK(dynfilter_update_pose(c.get(), &in_c.frame, tracking.inliers, tracking.outliers) == 0);
  }
  void lost() {
    pipeline.lost();
    CHECK(cpp11.lost());
    CHECK(dynfilter_lost(c.get()) == 0);
  }

  Pipeline pipeline;
  facade::DynFilter cpp11;
  CFilter c;
};

}  // namespace

TEST_CASE("map points of the host's tracker, through all interfaces: those that move are the pipeline's") {
  using testing::MovingBox;
  const testing::ExactScene scene = testing::ExactScene().pixel_noise(0.2).depth_noise(0.0014).mover(
      MovingBox(60).at({-0.6, 0, 2.5}).moving({0.02, 0, 0.01}));
  Three three("pipeline: { before_pose: [ background_motion ] }");
  for (int k = 0; k < 24; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    FrameView view = frame.view();
    const Verdict& verdict = three.judge(view);
    facade::Tracking tracking;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      if (!verdict.keep(i)) continue;
      tracking.keypoints.push_back(frame.keypoints[i]);
      tracking.map_point_ids.push_back(k == 0 || frame.label[i] == 0 ? frame.point[i] : -1);
    }
    view.T_world_camera = scene.T_world_camera(k);
    three.track(view, tracking);
    if (k == 12) three.lost();
  }
  const std::vector<std::int64_t> moved = three.pipeline.moved_map_points();
  CHECK(moved.size() > 30);
  CHECK(three.cpp11.moved_map_points() == moved);
  std::vector<std::int64_t> ids(moved.size());
  CHECK(dynfilter_moved_map_points(three.c.get(), ids.data(), ids.size()) == moved.size());
  CHECK(ids == moved);
  ids.assign(3, -1);
  CHECK(dynfilter_moved_map_points(three.c.get(), ids.data(), 2) == moved.size());
  CHECK(ids == std::vector<std::int64_t>{moved[0], moved[1], -1});
  CHECK(dynfilter_moved_map_points(three.c.get(), nullptr, 9) == moved.size());
  CHECK(dynfilter_moved_map_points(nullptr, ids.data(), 3) == 0);
}

TEST_CASE("inliers of the host's tracker, through all interfaces: a limit below the noise makes it doubt") {
  const testing::ExactScene scene = testing::ExactScene().pixel_noise(0.1);
  Three three("pipeline: { before_pose: [ { epipolar: { max_distance_px: 0.07 } } ] }");
  std::size_t doubts = 0;
  for (int k = 0; k < 40; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    FrameView view = frame.view();
    doubts = three.judge(view).report.doubts;
    facade::Tracking tracking;
    tracking.inliers = 200, tracking.outliers = 20;
    view.T_world_camera = scene.T_world_camera(k);
    three.track(view, tracking);
  }
  CHECK(doubts > 0);
}

TEST_CASE("what cannot be said of a frame's tracking is an error, through both interfaces") {
  facade::DynFilter nothing;
  CHECK_FALSE(nothing.lost());
  CHECK(nothing.error() == "no pipeline is loaded");
  CHECK(nothing.moved_map_points().empty());
  const CFilter c = c_filter_of("pipeline: { before_pose: [ epipolar ] }");
  dynfilter_frame frame;
  dynfilter_frame_init(&frame);
  CHECK(dynfilter_update_pose(c.get(), nullptr, 0, 0) != 0);
  CHECK(dynfilter_update_pose(nullptr, &frame, 0, 0) != 0);
  CHECK(dynfilter_lost(nullptr) != 0);
  frame.keypoint_count = 5;
  CHECK(dynfilter_update_pose(c.get(), &frame, 0, 0) != 0);
  CHECK(std::string(dynfilter_last_error(c.get())) == "keypoints is NULL, but keypoint_count is not 0");
  frame.keypoint_count = 0, frame.struct_size = 3;
  CHECK(dynfilter_update_pose(c.get(), &frame, 0, 0) != 0);
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
  const dynfilter_box box{10, 10, 1000, 1000, 0.9F, 0, -1, "person", nullptr, 0};
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
