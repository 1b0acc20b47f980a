// SPDX-License-Identifier: MIT
// An input that is there but has no usable value counts as not given.
// For every optional member of FrameView and every preset, the verdicts are those without the member.
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "doctest/doctest.h"
#include "support/effort.hpp"
#include "support/layered_scene.hpp"

namespace empty_inputs_test {

using namespace dynfilter;
using dynfilter_test::LayeredFrame;
using dynfilter_test::LayeredScene;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
constexpr float kNoDepths[] = {-1, 0, kNan, -kInf, kInf};
constexpr int kFrames = 6;

/// A frame of the scene, and arrays of its length without a usable value.
struct Inputs {
  explicit Inputs(const LayeredFrame& from) : frame(from) {
    const std::size_t n = frame.size();
    for (std::size_t i = 0; i < n; ++i) no_depths.push_back(kNoDepths[i % std::size(kNoDepths)]);
    minus_ones.assign(n, -1), no_ids.assign(n, -1), no_indices.assign(n, -1);
    nowhere.assign(n, cv::KeyPoint(kNan, kNan, 31));
    no_points.assign(n, cv::Point3f(kNan, kNan, kNan));
    no_boxes = frame.boxes;
    no_boxes[0].box.x = kNan;
    zero_depth_image = cv::Mat::zeros(frame.depth.size(), CV_16UC1);
    zero_descriptors = cv::Mat::zeros(frame.descriptors.size(), CV_8UC1);
    float_descriptors = cv::Mat::ones(frame.descriptors.size(), CV_32FC1);
    no_depth_image.create(frame.depth.size(), CV_32FC1);
    for (int y = 0; y < no_depth_image.rows; ++y)
      for (int x = 0; x < no_depth_image.cols; ++x)
        no_depth_image.at<float>(y, x) = kNoDepths[static_cast<std::size_t>(x + y) % std::size(kNoDepths)];
    keyframe = {{frame.id - 1000, Pose(), frame.keypoints, frame.depth_m, frame.map_point_ids}};
    bad_keyframe = keyframe, mono_keyframe = keyframe, empty_keyframe = keyframe;
    bad_keyframe[0].T_world_camera.rotation.fill(0);
    mono_keyframe[0].depth_m = {}, mono_keyframe[0].map_point_ids = {};
    empty_keyframe[0].depth_m = minus_ones, empty_keyframe[0].map_point_ids = no_ids;
    no_keyframe = {{frame.id - 1000, Pose(), {}, {}, {}}};
  }

  /// All inputs.
  FrameView view() const {
    FrameView view;
    view.id = frame.id, view.timestamp_s = frame.timestamp_s;
    view.keypoints = frame.keypoints, view.keypoints_undistorted = frame.keypoints;
    view.descriptors = frame.descriptors;
    view.depth_m = frame.depth_m;
    view.grey = frame.grey, view.depth = frame.depth;
    view.camera = LayeredScene().camera();
    view.T_world_camera = frame.T_world_camera, view.pose_provenance = PoseProvenance::Estimated;
    view.map_point_ids = frame.map_point_ids, view.map_points_world_m = frame.map_points_world_m;
    view.covisible_keyframes = keyframe;
    if (frame.id > 0) view.matches = HostMatches{frame.id - 1, frame.reference_index};
    view.detections = DetectionInput{-1, frame.boxes};
    view.mask = MaskInput{-1, frame.labels};
    return view;
  }

  LayeredFrame frame;
  std::vector<float> no_depths, minus_ones;
  std::vector<std::int64_t> no_ids;
  std::vector<std::int32_t> no_indices;
  std::vector<cv::KeyPoint> nowhere;
  std::vector<cv::Point3f> no_points;
  std::vector<Detection> no_boxes;
  cv::Mat no_depth_image, zero_depth_image, zero_descriptors, float_descriptors;
  std::vector<KeyframeView> keyframe, bad_keyframe, mono_keyframe, empty_keyframe, no_keyframe;
};

using Change = std::function<void(FrameView&, const Inputs&)>;

/// A member, how it is taken away, and how it is there without a usable value.
struct Member {
  const char* name;
  Change absent, empty;
};

void without_depth(FrameView& v, const Inputs&) {
  v.depth_m = {}, v.right_u_px = {}, v.depth = cv::Mat();
}
void without_matches(FrameView& v, const Inputs&) {
  v.matches.reset();
}

const std::vector<Member>& members() {
  static const std::vector<Member> all{
      {"depth_m: -1, 0, NaN, inf", [](FrameView& v, const Inputs&) { v.depth_m = {}; },
       [](FrameView& v, const Inputs& in) { v.depth_m = in.no_depths; }},
      {"depth: float without a depth", [](FrameView& v, const Inputs&) { v.depth = cv::Mat(); },
       [](FrameView& v, const Inputs& in) { v.depth = in.no_depth_image; }},
      {"depth: 16 bits, zeros", [](FrameView& v, const Inputs&) { v.depth = cv::Mat(); },
       [](FrameView& v, const Inputs& in) { v.depth = in.zero_depth_image, v.depth_unit_m = 1e-3; }},
      {"right_u_px: -1, with depths", [](FrameView&, const Inputs&) {},
       [](FrameView& v, const Inputs& in) { v.right_u_px = in.minus_ones; }},
      {"depth_m and right_u_px: -1, as ORB-SLAM has them for one camera", without_depth,
       [](FrameView& v, const Inputs& in) {
         v.depth_m = in.minus_ones, v.right_u_px = in.minus_ones, v.depth = cv::Mat();
       }},
      {"the same without matches",
       [](FrameView& v, const Inputs& in) { without_depth(v, in), without_matches(v, in); },
       [](FrameView& v, const Inputs& in) {
         v.depth_m = in.minus_ones, v.right_u_px = in.minus_ones, v.depth = cv::Mat();
         without_matches(v, in);
       }},
      {"depth_m and depth", without_depth,
       [](FrameView& v, const Inputs& in) { v.depth_m = in.no_depths, v.depth = in.no_depth_image; }},
      {"keypoints_undistorted: NaN", [](FrameView& v, const Inputs&) { v.keypoints_undistorted = {}; },
       [](FrameView& v, const Inputs& in) { v.keypoints_undistorted = in.nowhere; }},
      {"descriptors: zeros",
       [](FrameView& v, const Inputs& in) {
         v.descriptors = cv::Mat(), v.grey = cv::Mat(), without_matches(v, in);
       },
       [](FrameView& v, const Inputs& in) {
         v.descriptors = in.zero_descriptors;
         v.grey = cv::Mat(), without_matches(v, in);
       }},
      {"descriptors: of floats",
       [](FrameView& v, const Inputs& in) {
         v.descriptors = cv::Mat(), v.grey = cv::Mat(), without_matches(v, in);
       },
       [](FrameView& v, const Inputs& in) {
         v.descriptors = in.float_descriptors;
         v.grey = cv::Mat(), without_matches(v, in);
       }},
      {"map_point_ids: -1", [](FrameView& v, const Inputs&) { v.map_point_ids = {}; },
       [](FrameView& v, const Inputs& in) { v.map_point_ids = in.no_ids; }},
      {"map_points_world_m: NaN", [](FrameView& v, const Inputs&) { v.map_points_world_m = {}; },
       [](FrameView& v, const Inputs& in) { v.map_points_world_m = in.no_points; }},
      {"covisible_keyframes: a pose of zeros",
       [](FrameView& v, const Inputs&) { v.covisible_keyframes = {}; },
       [](FrameView& v, const Inputs& in) { v.covisible_keyframes = in.bad_keyframe; }},
      {"covisible_keyframes: no keypoints and no map points",
       [](FrameView& v, const Inputs&) { v.covisible_keyframes = {}; },
       [](FrameView& v, const Inputs& in) { v.covisible_keyframes = in.no_keyframe; }},
      {"a keyframe's depth_m and map_point_ids: -1",
       [](FrameView& v, const Inputs& in) { v.covisible_keyframes = in.mono_keyframe; },
       [](FrameView& v, const Inputs& in) { v.covisible_keyframes = in.empty_keyframe; }},
      {"T_world_camera: zeros",
       [](FrameView& v, const Inputs&) {
         v.T_world_camera = Pose(), v.pose_provenance = PoseProvenance::None;
       },
       [](FrameView& v, const Inputs&) { v.T_world_camera.rotation.fill(0); }},
      {"matches: -1", without_matches,
       [](FrameView& v, const Inputs& in) {
         if (v.matches) v.matches = HostMatches{in.frame.id - 1, in.no_indices};
       }},
      {"detections: boxes of NaN", [](FrameView& v, const Inputs&) { v.detections.reset(); },
       [](FrameView& v, const Inputs& in) {
         v.detections = DetectionInput{-1, in.no_boxes};
       }},
      {"mask: no image", [](FrameView& v, const Inputs&) { v.mask.reset(); },
       [](FrameView& v, const Inputs&) {
         v.mask = MaskInput{-1, cv::Mat()};
       }},
      {"grey: colour, without matches",
       [](FrameView& v, const Inputs& in) { v.grey = cv::Mat(), without_matches(v, in); },
       [](FrameView& v, const Inputs& in) {
         v.grey = cv::Mat(in.frame.grey.size(), CV_8UC3, cv::Scalar::all(9));
         without_matches(v, in);
       }},
      {"camera: zeros", [](FrameView& v, const Inputs&) { v.camera.reset(); },
       [](FrameView& v, const Inputs&) { v.camera = Camera(); }},
      {"camera: NaN", [](FrameView& v, const Inputs&) { v.camera.reset(); },
       [](FrameView& v, const Inputs&) { v.camera->fx_px = v.camera->cx_px = kNan; }},
  };
  return all;
}

const std::vector<Inputs>& frames() {
  static const std::vector<Inputs> all = [] {
    std::vector<Inputs> made;
    const LayeredScene scene;
    made.reserve(kFrames);
    for (int k = 0; k < kFrames; ++k) made.emplace_back(scene.frame(k));
    // Spans of a moved Inputs stay valid, as vectors keep their memory.
    return made;
  }();
  return all;
}

/// Decision, prior, reasons of each feature, and which stages did not run, over all frames and call points.
/// The change applies to every frame, or to frame `only` alone.
std::vector<std::uint64_t> verdicts_of(const std::string& preset, const Change& change, int only) {
  Pipeline pipeline(load_pipeline(preset, builtin_filters()));
  std::vector<std::uint64_t> all;
  for (const Inputs& in : frames()) {
    FrameView view = in.view();
    if (only < 0 || only == in.frame.id) change(view, in);
    for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
      const Verdict& verdict = pipeline.process(view, point);
      for (std::size_t i = 0; i < verdict.size(); ++i)
        all.push_back(static_cast<std::uint64_t>(verdict.decision[i]) + 4 * verdict.prior[i] +
                      8 * verdict.restored[i] + 16 * verdict.reasons[i]);
      for (const StageReport& stage : verdict.report.stages) all.push_back(stage.skipped ? 1 : 0);
    }
  }
  return all;
}

}  // namespace

TEST_CASE("every preset: a member that is there without a usable value is a member that is not there") {
  const std::vector<std::string> presets = dynfilter_test::host_presets(preset_names());
  REQUIRE(presets.size() >= 19);
  for (const std::string& preset : presets) {
    for (const Member& member : members())
      for (const int only : {-1, 3}) {
        if (dynfilter_test::kSlowBuild && only < 0) continue;
        const std::string what =
            preset + ", " + member.name + (only < 0 ? ", in all frames" : ", in one frame");
        CAPTURE(what);
        CHECK((verdicts_of(preset, member.empty, only) == verdicts_of(preset, member.absent, only)));
      }
  }
}

TEST_CASE("the scene of that test is not empty: the default rejects the mover, with depth and without") {
  for (const bool mono : {false, true}) {
    CAPTURE(mono);
    Pipeline pipeline(load_pipeline("dynfilter", builtin_filters()));
    std::size_t found = 0, movers = 0, false_alarms = 0;
    for (const Inputs& in : frames()) {
      FrameView view = in.view();
      view.detections.reset(), view.mask.reset();
      if (mono) view.depth_m = in.minus_ones, view.right_u_px = in.minus_ones, view.depth = in.no_depth_image;
      const Verdict& verdict = pipeline.before_pose(view);
      if (in.frame.id < 3) continue;
      for (std::size_t i = 0; i < view.size(); ++i) {
        movers += in.frame.moves[i];
        (in.frame.moves[i] != 0 ? found : false_alarms) += verdict.keep(i) ? 0 : 1;
      }
      const StageReport& choice = verdict.report.stages[3];
      REQUIRE(choice.name == "first_available");
      CHECK(choice.note == (mono ? "judged by flow_consistency (background_motion skipped: no depth)" : ""));
    }
    CHECK(found > movers / 2);
    CHECK(false_alarms < movers / 10);
  }
}

TEST_CASE("the report notes what no host leaves empty, and is silent about what hosts fill with none") {
  const auto notes_of = [](const Change& change) {
    Pipeline pipeline(load_pipeline("none", builtin_filters()));
    FrameView view = frames()[1].view();
    change(view, frames()[1]);
    std::string all;
    for (const std::string& note : pipeline.before_pose(view).report.notes) all += note + '\n';
    return all;
  };
  CHECK(notes_of([](FrameView& v, const Inputs& in) {
          v.depth_m = in.minus_ones, v.right_u_px = in.minus_ones, v.map_point_ids = in.no_ids;
          v.map_points_world_m = in.no_points, v.matches = HostMatches{0, in.no_indices};
        }) == "");
  CHECK(notes_of([](FrameView& v, const Inputs& in) { v.depth = in.no_depth_image; }) ==
        "depth: no pixel has a depth\n");
  CHECK(notes_of([](FrameView& v, const Inputs& in) { v.keypoints_undistorted = in.nowhere; }) ==
        "keypoints_undistorted: none is in an image\n");
  CHECK(notes_of([](FrameView& v, const Inputs&) { v.camera = Camera(); }) ==
        "camera: neither a focal length nor a size\n");
  CHECK(notes_of([](FrameView& v, const Inputs& in) {
          v.detections = DetectionInput{-1, in.no_boxes};
        }) == "1 of 1 boxes cannot be used\n");
}

TEST_CASE("one usable value is enough") {
  const Inputs& in = frames()[1];
  const auto inputs_with = [&](const Change& change) {
    FrameView view;
    view.keypoints = in.frame.keypoints;
    change(view, in);
    FrameEvidence evidence;
    evidence.begin(view, CallPoint::BeforePose);
    return evidence.inputs();
  };
  std::vector<float> depths = in.no_depths;
  depths.back() = 2;
  cv::Mat image = in.no_depth_image.clone();
  image.at<float>(image.rows - 1, image.cols - 1) = 2;
  CHECK(inputs_with([&](FrameView& v, const Inputs&) { v.depth_m = depths; }) == Input::Depth);
  CHECK(inputs_with([&](FrameView& v, const Inputs&) { v.depth = image; }) == Input::Depth);
  CHECK(inputs_with([&](FrameView& v, const Inputs&) {
          v.depth_m = in.no_depths, v.depth = in.no_depth_image;
        }) == Input::None);
}

}  // namespace empty_inputs_test
