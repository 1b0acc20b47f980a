// SPDX-License-Identifier: MIT
// Frames with the exact contents that ORB-SLAM2 and ORB-SLAM3 produce, through every preset.
// The verdicts equal those of the same scene as `dynfilter run` gives it: a FrameView with what the sensor
// has, and nothing else.
//
// What the hosts fill, looked up in their sources (facts, no code). N: number of features. "l" features of
// the left camera, "r" of the right one. Only version 3 has the pair.
//
// | member       | one camera | stereo              | RGB-D               | one fisheye | fisheye pair
// |--------------|------------|---------------------|---------------------|-------------|------------------
// | mvKeys       | N          | N, rectified        | N                   | N           | l
// | mvDepth      | N times -1 | bf / disparity, -1  | depth image, -1     | N times -1  | triangulated, -1
// | mvuRight     | N times -1 | matched column, -1  | u - bf / depth, -1  | N times -1  | l times -1
// | mDescriptors | N rows     | N rows              | N rows              | N rows      | l + r rows
// | mvpMapPoints | N nulls    | N nulls             | N nulls             | N nulls     | l + r nulls
// | mTcw         | none       | none                | none                | none        | none
// | mbf          | 0          | bf                  | bf                  | 0           | bf
// | Nleft        | -1         | -1                  | -1                  | -1          | l
// | images       | grey       | left grey           | grey, depth [m]     | grey        | left grey
//
// mvKeysUn: undistorted, or mvKeys where the first distortion coefficient is 0 (UndistortKeyPoints).
// mvpMapPoints and the pose are filled by the tracking. A keyframe copies the arrays of its frame.
// One camera: the constructor of Frame that sets no stereo information. Stereo: ComputeStereoMatches.
// RGB-D: ComputeStereoFromRGBD. Pair: the last constructor and ComputeStereoFishEyeMatches (src/Frame.cc).
// Images: GrabImageMonocular, GrabImageStereo, GrabImageRGBD (src/Tracking.cc).
// Read at raulmur/ORB_SLAM2 f2e6f51 and UZ-SLAMLab/ORB_SLAM3 c0acf23.
#include <dynfilter/hosts/orb_slam.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "doctest/doctest.h"
#include "hosts/host_stand_ins.hpp"
#include "hosts/settings_folder.hpp"
#include "support/layered_scene.hpp"

namespace host_contents_test {

using namespace dynfilter;
using dynfilter_test::LayeredFrame;
using dynfilter_test::LayeredScene;

namespace {

enum class Content { Mono, Stereo, RgbD, Fisheye, FisheyePair };

constexpr int kFrames = 5;
/// Every fifth feature has no match in the right image, or no depth.
bool has_depth(const LayeredFrame& f, std::size_t i) {
  return f.point[i] % 5 != 0;
}
bool is_fisheye(Content content) {
  return content == Content::Fisheye || content == Content::FisheyePair;
}
int sensor_of(Content content) {  // System::eSensor
  return content == Content::RgbD ? 2 : content == Content::Stereo || content == Content::FisheyePair ? 1 : 0;
}

template <class Frame>
constexpr bool kIsVersion3 = std::is_same_v<Frame, host::v3::Frame>;

/// As the host's constructor of Frame leaves it, from the table above.
template <class Frame>
void fill(Frame& frame, const LayeredFrame& from, Content content, host::v3::GeometricCamera& camera) {
  const std::size_t n = from.size();
  const Camera pinhole = LayeredScene().camera();
  frame.mnId = static_cast<long unsigned int>(from.id), frame.mTimeStamp = from.timestamp_s;
  frame.mK =
      (cv::Mat_<float>(3, 3) << pinhole.fx_px, 0, pinhole.cx_px, 0, pinhole.fy_px, pinhole.cy_px, 0, 0, 1);
  frame.mDistCoef = cv::Mat::zeros(4, 1, CV_32F);
  frame.mbf = content == Content::Mono || content == Content::Fisheye
                  ? 0
                  : static_cast<float>(LayeredScene::kBaseline_px_m);
  frame.mvKeys = frame.mvKeysUn = from.keypoints;
  frame.mDescriptors = from.descriptors.clone();
  frame.mvDepth.assign(n, -1), frame.mvuRight.assign(n, -1);
  const bool measures = content != Content::Mono && content != Content::Fisheye;
  for (std::size_t i = 0; i < n && measures; ++i) {
    if (!has_depth(from, i)) continue;
    frame.mvDepth[i] = from.depth_m[i];
    if (content != Content::FisheyePair) frame.mvuRight[i] = from.right_u_px[i];
  }
  frame.N = static_cast<int>(n);
  if constexpr (kIsVersion3<Frame>) {
    camera.type = is_fisheye(content) ? 1 : 0;
    frame.mpCamera = &camera;
    if (content == Content::FisheyePair) {  // one right feature, without a match
      frame.Nleft = static_cast<int>(n), frame.Nright = 1, frame.N += 1;
      frame.mvKeysRight.assign(1, cv::KeyPoint(100, 100, 31));
      frame.mDescriptorsRight = cv::Mat::ones(1, 32, CV_8UC1);
      frame.mDescriptors.push_back(frame.mDescriptorsRight);
      frame.mvLeftToRightMatch.assign(n, -1), frame.mvRightToLeftMatch.assign(1, -1);
      frame.mvStereo3Dpoints.resize(n);
      frame.monoLeft = frame.monoRight = 0;
    }
  }
  const auto all = static_cast<std::size_t>(frame.N);
  frame.mvpMapPoints.assign(all, nullptr), frame.mvbOutlier.assign(all, false);
}

cv::Mat_<float> matrix_of(const Pose& T_world_camera) {
  cv::Mat_<float> T(cv::Mat::eye(4, 4, CV_32F));
  for (int row = 0; row < 3; ++row)
    T(row, 3) = -static_cast<float>(T_world_camera.translation_m[static_cast<std::size_t>(row)]);
  return T;
}

/// As the tracking leaves it before TrackLocalMap(): a pose, and map points on features with even numbers.
template <class Frame>
void track(Frame& frame, const LayeredFrame& from, const std::vector<std::size_t>& alive,
           std::vector<orb_slam::MapPointOf<Frame>>& points) {
  const cv::Mat_<float> T = matrix_of(from.T_world_camera);
  if constexpr (kIsVersion3<Frame>) {
    host::v3::SE3f pose;
    for (int row = 0; row < 3; ++row) pose.m(row, 3) = T(row, 3);
    frame.SetPose(pose);
  } else {
    frame.mTcw = T;
  }
  for (std::size_t k = 0; k < alive.size(); ++k) {
    const std::size_t i = alive[k];
    if (from.point[i] % 2 != 0) continue;
    auto& point = points[static_cast<std::size_t>(from.point[i])];
    point.mnId = static_cast<long unsigned int>(from.point[i]);
    const cv::Point3f p = from.map_points_world_m[i];
    if constexpr (kIsVersion3<Frame>)
      point.world = {p.x, p.y, p.z};
    else
      point.world = (cv::Mat_<float>(3, 1) << p.x, p.y, p.z);
    frame.mvpMapPoints[k] = &point;
  }
}

template <class Frame>
using KeyFrameOf = std::conditional_t<kIsVersion3<Frame>, host::v3::KeyFrame, host::v2::KeyFrame>;

/// A keyframe of the first frame.
template <class Frame>
KeyFrameOf<Frame> keyframe_of(const LayeredFrame& first, Content content, host::v3::GeometricCamera& camera,
                              std::vector<orb_slam::MapPointOf<Frame>>& points) {
  Frame frame;
  fill(frame, first, content, camera);
  std::vector<orb_slam::MapPointOf<Frame>*> matched(first.size(), nullptr);
  for (std::size_t i = 0; i < first.size(); ++i)
    if (first.point[i] % 2 == 0) matched[i] = &points[static_cast<std::size_t>(first.point[i])];
  if constexpr (kIsVersion3<Frame>)
    return {0, frame.mvKeysUn, frame.mvDepth, matched, host::v3::SE3f(), false};
  else
    return {0, frame.mvKeysUn, frame.mvDepth, matched, cv::Mat(matrix_of(Pose())), false};
}

/// The same frame as `dynfilter run` gives it: what the sensor has, and nothing else.
class RunFrame {
 public:
  RunFrame(const LayeredFrame& from, const LayeredFrame& first, Content content)
      : from_(from), first_(first), content_(content), alive_(from.size()) {
    for (std::size_t i = 0; i < alive_.size(); ++i) alive_[i] = i;
  }

  const std::vector<std::size_t>& alive() const { return alive_; }
  void drop_rejected(const Verdict& verdict) {
    std::size_t left = 0;
    for (std::size_t k = 0; k < alive_.size(); ++k)
      if (verdict.keep(k)) alive_[left++] = alive_[k];
    alive_.resize(left);
  }

  FrameView view(CallPoint point) {
    gather(from_, alive_);
    FrameView view;
    view.id = from_.id, view.timestamp_s = from_.timestamp_s;
    view.keypoints = keypoints_;
    const bool depths = content_ != Content::Mono && content_ != Content::Fisheye;
    if (depths) view.depth_m = depth_m_;
    view.detections = DetectionInput{-1, from_.boxes};
    view.mask = MaskInput{-1, from_.labels};
    if (point != CallPoint::BeforePose) {
      view.T_world_camera = as_read(from_.T_world_camera), view.pose_provenance = PoseProvenance::Estimated;
      view.map_point_ids = ids_, view.map_points_world_m = points_;
    }
    if (is_fisheye(content_)) return view;
    view.keypoints_undistorted = keypoints_;
    view.descriptors = descriptors_;
    view.grey = from_.grey;
    if (content_ == Content::RgbD) view.depth = from_.depth;
    if (content_ == Content::Stereo) view.right_u_px = right_u_px_;
    view.camera = LayeredScene().camera();
    if (content_ == Content::Mono) view.camera->baseline_fx_px_m = 0;
    if (point == CallPoint::AtKeyframe) {
      keyframe_ids_.clear(), keyframe_depth_m_.clear();
      for (std::size_t i = 0; i < first_.size(); ++i) {
        keyframe_ids_.push_back(first_.point[i] % 2 == 0 ? first_.point[i] : -1);
        keyframe_depth_m_.push_back(has_depth(first_, i) ? first_.depth_m[i] : -1);
      }
      keyframes_ = {{0, inverse(Pose()), first_.keypoints,
                     depths ? Span<const float>(keyframe_depth_m_) : Span<const float>(), keyframe_ids_}};
      view.covisible_keyframes = keyframes_;
    }
    return view;
  }

 private:
  /// Hosts have poses of the world in the camera, in single precision.
  static Pose as_read(const Pose& T_world_camera) {
    return inverse(*orb_slam::to_pose(cv::Mat(matrix_of(T_world_camera))));
  }

  void gather(const LayeredFrame& f, const std::vector<std::size_t>& alive) {
    keypoints_.clear(), depth_m_.clear(), right_u_px_.clear(), ids_.clear(), points_.clear();
    descriptors_ = cv::Mat();
    for (const std::size_t i : alive) {
      keypoints_.push_back(f.keypoints[i]);
      depth_m_.push_back(has_depth(f, i) ? f.depth_m[i] : std::numeric_limits<float>::quiet_NaN());
      right_u_px_.push_back(has_depth(f, i) ? f.right_u_px[i] : std::numeric_limits<float>::quiet_NaN());
      const bool matched = f.point[i] % 2 == 0;
      ids_.push_back(matched ? f.point[i] : -1);
      points_.push_back(matched ? f.map_points_world_m[i] : cv::Point3f());
      descriptors_.push_back(f.descriptors.row(static_cast<int>(i)));
    }
  }

  const LayeredFrame &from_, &first_;
  Content content_;
  std::vector<std::size_t> alive_;
  std::vector<cv::KeyPoint> keypoints_;
  std::vector<float> depth_m_, right_u_px_, keyframe_depth_m_;
  std::vector<std::int64_t> ids_, keyframe_ids_;
  std::vector<cv::Point3f> points_;
  cv::Mat descriptors_;
  std::vector<KeyframeView> keyframes_;
};

const std::vector<LayeredFrame>& scene() {
  static const std::vector<LayeredFrame> frames = [] {
    std::vector<LayeredFrame> made;
    for (int k = 0; k < kFrames; ++k) made.push_back(LayeredScene().frame(k));
    return made;
  }();
  return frames;
}
std::size_t count_points() {
  int most = 0;
  for (const LayeredFrame& frame : scene())
    for (const int point : frame.point) most = std::max(most, point);
  return static_cast<std::size_t>(most) + 1;
}

void check_same(const Verdict& of_host, const Verdict& of_run) {
  CHECK((of_host.decision == of_run.decision));
  CHECK((of_host.prior == of_run.prior));
  CHECK((of_host.restored == of_run.restored));
  CHECK((of_host.reasons == of_run.reasons));
  REQUIRE(of_host.report.stages.size() == of_run.report.stages.size());
  for (std::size_t k = 0; k < of_run.report.stages.size(); ++k) {
    CHECK(of_host.report.stages[k].note == of_run.report.stages[k].note);
    CHECK(of_host.report.stages[k].skipped == of_run.report.stages[k].skipped);
  }
}

OrbSlamSettings settings_of(const std::string& preset) {
  const dynfilter_test::SettingsFolder folder;
  return read_orb_slam_settings(folder.write(
      "settings.yaml", "%YAML:1.0\n---\nDynFilter.pipeline: " + preset +
                           "\nDynFilter.keep_first_frame: 0\nDynFilter.min_features_before_map: 0\n"
                           "DynFilter.min_features: 0\n"));
}

/// All call points of all frames. Returns how many features were rejected.
template <class Frame>
std::size_t compare(const std::string& preset, Content content) {
  OrbSlam host(settings_of(preset), host_sensor(sensor_of(content)));
  OrbSlamSettings settings = settings_of(preset);
  Pipeline run(configured_pipeline(settings));
  host::v3::GeometricCamera camera;
  std::vector<orb_slam::MapPointOf<Frame>> points(count_points());
  std::size_t rejected = 0;
  for (const LayeredFrame& from : scene()) {
    CAPTURE(from.id);
    Frame frame;
    fill(frame, from, content, camera);
    RunFrame expected(from, scene().front(), content);
    const auto compare_at = [&](CallPoint point) {
      CAPTURE(to_string(point));
      const Verdict& of_run = run.process(expected.view(point), point, {0});
      check_same(host.verdict(), of_run);
      expected.drop_rejected(of_run);
      rejected += of_run.report.rejected;
    };
    host.set_detections(from.boxes), host.set_mask(from.labels);
    host.before_tracking(frame, from.grey, content == Content::RgbD ? from.depth : cv::Mat(), true);
    compare_at(CallPoint::BeforePose);
    track(frame, from, expected.alive(), points);
    host.after_pose(frame);
    compare_at(CallPoint::AfterPose);
    KeyFrameOf<Frame> keyframe = keyframe_of<Frame>(scene().front(), content, camera, points);
    host.at_keyframe(frame, std::vector<KeyFrameOf<Frame>*>{&keyframe});
    compare_at(CallPoint::AtKeyframe);
  }
  return rejected;
}

}  // namespace

TEST_CASE_TEMPLATE("every preset judges a host's frame as it judges the same frame of `dynfilter run`", Frame,
                   host::v2::Frame, host::v3::Frame) {
  std::vector<Content> contents{Content::Mono, Content::Stereo, Content::RgbD};
  if (kIsVersion3<Frame>) contents.insert(contents.end(), {Content::Fisheye, Content::FisheyePair});
  const std::vector<std::string> presets = dynfilter_test::host_presets(preset_names());
  REQUIRE(presets.size() >= 19);
  for (const std::string& preset : presets)
    for (const Content content : contents) {
      CAPTURE(preset);
      CAPTURE(static_cast<int>(content));
      const std::size_t rejected = compare<Frame>(preset, content);
      // Geometry finds the mover with every sensor. It abstains on a fisheye camera, where boxes are left.
      if (preset == "dynfilter_mono") CHECK((rejected > 0) == !is_fisheye(content));
      if (preset == "dynfilter" || preset == "yolo_slam") CHECK(rejected > 0);
    }
}

TEST_CASE(
    "the default pipeline on one camera: the lines name the stage that judges instead, no warning follows") {
  std::vector<std::string> lines;
  OrbSlam filter(settings_of("dynfilter"), HostSensor::Monocular,
                 [&](const std::string& line) { lines.push_back(line); });
  CHECK(filter.start_line().find("but not: depth, boxes, mask") != std::string::npos);
  CHECK(filter.start_line().find("; boxes and mask are optional; without depth flow_consistency judges, not "
                                 "background_motion") != std::string::npos);
  host::v3::GeometricCamera camera;
  for (int k = 0; k < InputWatch::kPatience + 2; ++k) {
    LayeredFrame from = scene()[static_cast<std::size_t>(k) % kFrames];
    from.id = k, from.timestamp_s = 0.04 * k;
    host::v2::Frame frame;
    fill(frame, from, Content::Mono, camera);
    filter.before_tracking(frame, from.grey, cv::Mat(), true);
  }
  CHECK(lines.empty());
}

TEST_CASE(
    "a camera that sees nothing: the warning says what was missing, who judged, and what the stages said") {
  std::vector<std::string> lines;
  OrbSlam filter(settings_of("dynfilter"), HostSensor::Monocular,
                 [&](const std::string& line) { lines.push_back(line); });
  host::v3::GeometricCamera camera;
  for (int k = 0; k < InputWatch::kPatience + 2; ++k) {
    LayeredFrame from = scene().front();
    from.id = k, from.timestamp_s = 0.04 * k;
    host::v2::Frame frame;
    fill(frame, from, Content::Mono, camera);
    filter.before_tracking(frame, cv::Mat::zeros(from.grey.size(), CV_8UC1), cv::Mat(), true);
  }
  REQUIRE(lines.size() == 1);
  INFO(lines[0]);
  CHECK(
      lines[0].find("in 30 frames no depth came for background_motion; nothing was rejected; no stage judged "
                    "(semantic_box: skipped: no boxes, semantic_mask: skipped: no mask, background_motion: "
                    "skipped: no depth, flow_consistency)") != std::string::npos);
}

}  // namespace host_contents_test
