// SPDX-License-Identifier: MIT
#include <malloc.h>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cstdlib>
#include <dynfilter/hosts/masked_host.hpp>
#include <dynfilter/hosts/orb_slam.hpp>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>
#include <set>

#include "doctest/doctest.h"
#include "fuzz/lent_memory.hpp"
#include "hosts/host_stand_ins.hpp"
#include "hosts/settings_folder.hpp"

namespace orb_slam_test {

using namespace dynfilter;

namespace {

enum class Sensor { Mono = 0, Stereo = 1, RgbD = 2 };

cv::Mat_<float> camera_matrix() {
  return (cv::Mat_<float>(3, 3) << 500, 0, 320, 0, 500, 240, 0, 0, 1);
}

/// Feature i has class_id i, a place of its own and depth 1 + i / 100 m. The first one is on the right edge,
/// outside the grid. Every fourth has no depth. The even ones have map points, and every third is an outlier.
template <class Frame>
struct Host {
  using MapPoint = orb_slam::MapPointOf<Frame>;

  explicit Host(int n, Sensor sensor = Sensor::RgbD, long unsigned int id = 0)
      : points(static_cast<std::size_t>(n)) {
    frame.mK = camera_matrix();
    frame.mDistCoef = cv::Mat::zeros(4, 1, CV_32F);
    frame.mnId = id;
    frame.mTimeStamp = 0.04 * static_cast<double>(id);
    frame.mDescriptors.create(n, 32, CV_8U);
    for (int i = 0; i < n; ++i) add(i, sensor);
    frame.N = n;
    orb_slam::detail::fill_grid(frame, frame.mvKeysUn, frame.mGrid);
    frame.mBowVec[3] = 1, frame.mFeatVec[3] = {0};
  }
  Host(const Host&) = delete;

  void add(int i, Sensor sensor) {
    cv::KeyPoint key(i == 0 ? 640.0F : static_cast<float>(5 + (i * 37) % 620),
                     static_cast<float>(5 + (i * 91) % 460), 31, 0, 0, 0, i);
    frame.mvKeys.push_back(key);
    key.pt.x -= i == 0 ? 0.0F : 1.0F;  // undistorted: elsewhere
    frame.mvKeysUn.push_back(key);
    frame.mDescriptors.row(i).setTo(i % 256);
    const bool has_depth = sensor != Sensor::Mono && i % 4 != 0;
    frame.mvDepth.push_back(has_depth ? depth_of(i) : -1);
    frame.mvuRight.push_back(has_depth ? key.pt.x - 40 / depth_of(i) : -1);
    auto& point = points[static_cast<std::size_t>(i)];
    point.mnId = 1000 + static_cast<long unsigned int>(i);
    frame.mvpMapPoints.push_back(i % 2 == 0 ? &point : nullptr);
    frame.mvbOutlier.push_back(i % 3 == 0);
  }
  static float depth_of(int i) { return 1 + static_cast<float>(i) / 100; }

  Frame frame;
  std::vector<MapPoint> points;
};

Verdict verdict_without(std::size_t n, const std::set<int>& rejected) {
  Verdict verdict;
  verdict.decision.assign(n, Vote::Unknown);
  verdict.restored.assign(n, 0);
  verdict.suspicion.assign(n, 0);
  for (const int i : rejected) verdict.decision[static_cast<std::size_t>(i)] = Vote::Dynamic;
  return verdict;
}

/// Each index of `keypoints` that has a place in the grid is there exactly once, in its cell; no other is.
template <class Frame, class Grid>
void check_grid(Frame& frame, const std::vector<cv::KeyPoint>& keypoints, const Grid& grid) {
  std::size_t in_grid = 0, expected = 0;
  for (const auto& column : grid)
    for (const auto& cell : column) in_grid += cell.size();
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    int x = 0, y = 0;
    if (!frame.PosInGrid(keypoints[i], x, y)) continue;
    ++expected;
    CHECK(std::count(grid[x][y].begin(), grid[x][y].end(), i) == 1);
  }
  CHECK(in_grid == expected);
}

/// Every array has N entries, and entry k is all of feature `left[k]`.
template <class Frame>
void check_thinned(Host<Frame>& host, const std::vector<int>& left, Sensor sensor) {
  Frame& f = host.frame;
  const std::size_t n = left.size();
  REQUIRE(f.N == static_cast<int>(n));
  REQUIRE(f.mvKeys.size() == n);
  REQUIRE(f.mvKeysUn.size() == n);
  REQUIRE(f.mDescriptors.rows == f.N);
  REQUIRE(f.mvDepth.size() == n);
  REQUIRE(f.mvuRight.size() == n);
  REQUIRE(f.mvpMapPoints.size() == n);
  REQUIRE(f.mvbOutlier.size() == n);
  for (std::size_t k = 0; k < n; ++k) {
    const int i = left[k];
    CAPTURE(i);
    CHECK(f.mvKeys[k].class_id == i);
    CHECK(f.mvKeysUn[k].class_id == i);
    CHECK(f.mDescriptors.template at<std::uint8_t>(static_cast<int>(k), 31) == i % 256);
    const bool has_depth = sensor != Sensor::Mono && i % 4 != 0;
    CHECK(f.mvDepth[k] == (has_depth ? Host<Frame>::depth_of(i) : -1.0F));
    CHECK((f.mvuRight[k] != -1.0F) == has_depth);
    CHECK(f.mvpMapPoints[k] == (i % 2 == 0 ? &host.points[static_cast<std::size_t>(i)] : nullptr));
    CHECK(f.mvbOutlier[k] == (i % 3 == 0));
  }
  check_grid(f, f.mvKeysUn, f.mGrid);
}

std::vector<int> all_but(int n, const std::set<int>& rejected) {
  std::vector<int> left;
  for (int i = 0; i < n; ++i)
    if (rejected.count(i) == 0) left.push_back(i);
  return left;
}

std::set<int> random_set(int n, double share, unsigned seed) {
  std::mt19937 random(seed);
  std::set<int> chosen;
  for (int i = 0; i < n; ++i)
    if (static_cast<double>(random() % 1000) < 1000 * share) chosen.insert(i);
  return chosen;
}

using Folder = dynfilter_test::SettingsFolder;

const char* const kHostKeys =
    "%YAML:1.0\n---\nCamera.fx: 500.0\nCamera.fy: 500.0\nCamera.cx: 320.0\nCamera.cy: 240.0\n"
    "DepthMapFactor: 5000.0\nORBextractor.nFeatures: 1000\n";
const char* const kBoxes =
    "pipeline:\n  name: boxes\n  floor: { min_features: 0 }\n"
    "  before_pose:\n    - semantic_box: { role: reject }\n"
    "  after_pose:\n    - semantic_box: { role: reject }\n"
    "  at_keyframe:\n    - depth_consistency: { against: covisible, prediction: match, max_deviation: 0.08 "
    "}\n";

OrbSlamSettings settings_from(const std::string& text) {
  const Folder folder;
  return read_orb_slam_settings(folder.write("settings.yaml", kHostKeys + text));
}
OrbSlam make(const std::string& keys = "", HostSensor sensor = HostSensor::RgbD) {
  return OrbSlam(settings_from(keys + kBoxes), sensor);
}
const char* const kNoFloor =
    "DynFilter.keep_first_frame: 0\nDynFilter.min_features_before_map: 0\nDynFilter.min_features: 0\n";

Detection person(float x, float y, float w, float h) {
  Detection detection;
  detection.box = {x, y, w, h};
  detection.class_name = "person";
  return detection;
}
/// The left half of the image.
std::vector<Detection> left_half() {
  return {person(-10, -10, 330, 600)};
}

template <class Frame>
std::vector<int> right_half(const Frame& frame) {
  std::vector<int> ids;
  for (const cv::KeyPoint& key : frame.mvKeys)
    if (key.pt.x > 320) ids.push_back(key.class_id);
  return ids;
}

cv::Mat noise(int width, int height, unsigned seed = 1) {
  cv::Mat image(height, width, CV_8UC1);
  std::mt19937 random(seed);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(random());
  return image;
}

}  // namespace

static_assert(orb_slam::traits::HasMatrixPose<host::v2::Frame>::value);
static_assert(!orb_slam::traits::HasGroupPose<host::v2::Frame>::value);
static_assert(!orb_slam::traits::HasTwoCameras<host::v2::Frame>::value);
static_assert(!orb_slam::traits::HasCameraModel<host::v2::Frame>::value);
static_assert(!orb_slam::traits::HasMatrixPose<host::v3::Frame>::value);  // there, but private
static_assert(orb_slam::traits::HasGroupPose<host::v3::Frame>::value);
static_assert(orb_slam::traits::HasTwoCameras<host::v3::Frame>::value);
static_assert(orb_slam::traits::HasCameraModel<host::v3::Frame>::value);

TEST_CASE_TEMPLATE("compaction keeps every array together, whatever is rejected", Frame, host::v2::Frame,
                   host::v3::Frame) {
  for (const Sensor sensor : {Sensor::Mono, Sensor::Stereo, Sensor::RgbD})
    for (const int n : {0, 1, 2, 300})
      for (const double share : {0.0, 0.3, 1.0}) {
        CAPTURE(n);
        CAPTURE(share);
        Host<Frame> host(n, sensor);
        const std::set<int> rejected = random_set(n, share, 7);
        const std::size_t went =
            orb_slam::compact_frame(host.frame, verdict_without(static_cast<std::size_t>(n), rejected));
        CHECK(went == rejected.size());
        CHECK(host.frame.mBowVec.empty() == !rejected.empty());
        CHECK(host.frame.mFeatVec.empty() == !rejected.empty());
        check_thinned(host, all_but(n, rejected), sensor);
      }
}

TEST_CASE_TEMPLATE("one rejected feature: first, last, and two times in a row", Frame, host::v2::Frame,
                   host::v3::Frame) {
  for (const int gone : {0, 5, 9}) {
    Host<Frame> host(10);
    CHECK(orb_slam::compact_frame(host.frame, verdict_without(10, {gone})) == 1);
    check_thinned(host, all_but(10, {gone}), Sensor::RgbD);
    CHECK(orb_slam::compact_frame(host.frame, verdict_without(9, {3})) == 1);
    std::vector<int> left = all_but(10, {gone});
    left.erase(left.begin() + 3);
    check_thinned(host, left, Sensor::RgbD);
  }
}

TEST_CASE("a verdict about another number of features changes nothing") {
  Host<host::v2::Frame> host(10);
  CHECK(orb_slam::compact_frame(host.frame, verdict_without(9, {1, 2})) == 0);
  check_thinned(host, all_but(10, {}), Sensor::RgbD);
}

TEST_CASE("descriptors that somebody else holds stay as they were") {
  Host<host::v2::Frame> host(10);
  const cv::Mat held = host.frame.mDescriptors;
  orb_slam::compact_frame(host.frame, verdict_without(10, {0, 1}));
  CHECK(held.rows == 10);
  CHECK(held.at<std::uint8_t>(0, 0) == 0);
  CHECK(host.frame.mDescriptors.at<std::uint8_t>(0, 0) == 2);
}

TEST_CASE("a fisheye pair: both cameras' arrays, matches renumbered, partners go together") {
  // Left 0..5, right 0..4; left 2, 3, 4 match right 1, 4, 3. The first two left and the first right feature
  // lie outside the overlap.
  Host<host::v3::Frame> host(11);
  host::v3::Frame& f = host.frame;
  f.Nleft = 6, f.Nright = 5, f.monoLeft = 2, f.monoRight = 1;
  f.mvKeysRight.assign(f.mvKeys.begin() + 6, f.mvKeys.end());
  f.mvKeys.resize(6), f.mvKeysUn.resize(6), f.mvDepth.resize(6), f.mvuRight.resize(6);
  f.mDescriptorsRight = f.mDescriptors.rowRange(6, 11).clone();
  f.mvLeftToRightMatch = {-1, -1, 1, 4, 3, -1};
  f.mvRightToLeftMatch = {-1, 2, -1, 4, 3};
  for (int i = 0; i < 6; ++i) f.mvStereo3Dpoints.emplace_back(static_cast<float>(i), 0.0F, 1.0F);

  CHECK(orb_slam::is_pair(f));
  CHECK(orb_slam::compact_frame(f, verdict_without(6, {1, 3})) == 2);
  // Left 0 2 4 5 stay; right 4 goes with left 3, right 0 1 2 3 stay.
  CHECK(f.Nleft == 4);
  CHECK(f.Nright == 4);
  CHECK(f.N == 8);
  CHECK(f.monoLeft == 1);
  CHECK(f.monoRight == 1);
  const std::vector<int> both{0, 2, 4, 5, 6, 7, 8, 9};
  for (std::size_t k = 0; k < 8; ++k) {
    const int i = both[k];
    CHECK((k < 4 ? f.mvKeys[k] : f.mvKeysRight[k - 4]).class_id == i);
    CHECK(f.mDescriptors.at<std::uint8_t>(static_cast<int>(k), 0) == i);
    CHECK(f.mvpMapPoints[k] == (i % 2 == 0 ? &host.points[static_cast<std::size_t>(i)] : nullptr));
    CHECK(f.mvbOutlier[k] == (i % 3 == 0));
  }
  CHECK(f.mDescriptors.rows == 8);
  CHECK(f.mDescriptorsRight.rows == 4);
  CHECK(f.mvpMapPoints.size() == 8);
  CHECK(f.mvLeftToRightMatch == std::vector<int>{-1, 1, 3, -1});
  CHECK(f.mvRightToLeftMatch == std::vector<int>{-1, 1, -1, 2});
  REQUIRE(f.mvStereo3Dpoints.size() == 4);
  CHECK(f.mvStereo3Dpoints[2].x() == 4.0F);
  CHECK(f.mvDepth.size() == 4);
  check_grid(f, f.mvKeys, f.mGrid);
  check_grid(f, f.mvKeysRight, f.mGridRight);
}

TEST_CASE("a fisheye frame is judged by boxes only: nothing that needs a pinhole is filled in") {
  Host<host::v3::Frame> host(20);
  host::v3::GeometricCamera camera;
  host.frame.mpCamera = &camera;
  orb_slam::FrameReader reader;
  CHECK(reader.read(host.frame, noise(640, 480), cv::Mat(), 1, false).camera.has_value());
  camera.type = 1;
  const FrameView view = reader.read(host.frame, noise(640, 480), cv::Mat(), 1, false);
  CHECK_FALSE(view.camera);
  CHECK(view.grey.empty());
  CHECK(view.descriptors.empty());
  CHECK(view.keypoints_undistorted.empty());
  OrbSlam filter = make(kNoFloor);
  filter.set_detections(left_half());
  const std::vector<int> expected = right_half(host.frame);
  filter.before_tracking(host.frame, noise(640, 480), cv::Mat(), true);
  check_thinned(host, expected, Sensor::RgbD);
}

TEST_CASE_TEMPLATE("a frame is read as it is", Frame, host::v2::Frame, host::v3::Frame) {
  Host<Frame> host(30);
  host.frame.mDistCoef.template at<float>(1) = 0.25F;
  host.frame.mbf = 40;
  host.points[4].bad = true;
  orb_slam::FrameReader reader;
  const FrameView view = reader.read(host.frame, noise(640, 480), cv::Mat(), 1, false);
  CHECK(view.size() == 30);
  CHECK(view.keypoints_undistorted.size() == 30);
  CHECK(view.depth_m[5] == Host<Frame>::depth_of(5));
  REQUIRE(view.camera);
  CHECK(view.camera->fx_px == 500);
  CHECK(view.camera->cy_px == 240);
  CHECK(view.camera->distortion == std::array<double, 5>{0, 0.25, 0, 0, 0});
  CHECK(view.camera->baseline_fx_px_m == 40);
  CHECK(view.right_u_px.empty());
  const FrameView stereo = reader.read(host.frame, noise(640, 480), cv::Mat(), 1, true);
  CHECK(is_stereo(stereo));
  CHECK(stereo.right_u_px[5] == host.frame.mvuRight[5]);
  CHECK(view.map_point_ids[2] == 1002);
  CHECK(view.map_point_ids[3] == -1);
  CHECK(view.map_point_ids[4] == -1);
}

TEST_CASE("poses: empty, not rigid, both versions; the prediction is velocity times last pose") {
  cv::Mat Tcw = cv::Mat::eye(4, 4, CV_32F);
  CHECK_FALSE(orb_slam::to_pose(cv::Mat()));
  Tcw.at<float>(0, 3) = 2;
  CHECK(orb_slam::to_pose(Tcw)->translation_m == std::array<double, 3>{2, 0, 0});
  cv::Mat velocity = cv::Mat::eye(4, 4, CV_32F);
  velocity.at<float>(0, 3) = -0.5F;
  host::v2::Frame last;
  CHECK_FALSE(orb_slam::predicted_pose(velocity, last).has_prediction);
  last.mTcw = Tcw, last.mnId = 4;
  const orb_slam::HostPose pose = orb_slam::predicted_pose(velocity, last);
  CHECK(pose.last_frame_id == 4);
  CHECK(pose.last_T_world_camera.translation_m == std::array<double, 3>{-2, 0, 0});
  CHECK(pose.predicted_T_world_camera.translation_m == std::array<double, 3>{-1.5, 0, 0});
  CHECK_FALSE(orb_slam::predicted_pose(cv::Mat(), last).has_prediction);
  Tcw.at<float>(0, 0) = 3;
  CHECK_FALSE(orb_slam::to_pose(Tcw));

  host::v3::Frame frame;
  host::v3::SE3f T;
  T.m(1, 3) = 1;
  CHECK_FALSE(orb_slam::predicted_pose(T, frame).has_last);
  frame.SetPose(T);
  CHECK(orb_slam::predicted_pose(T, frame).predicted_T_world_camera.translation_m[1] == -2);
  CHECK_FALSE(orb_slam::predicted_pose(T, frame, false).has_prediction);
}

TEST_CASE_TEMPLATE("call point B: boxes empty the left half, for all sensors", Frame, host::v2::Frame,
                   host::v3::Frame) {
  for (const Sensor sensor : {Sensor::Mono, Sensor::Stereo, Sensor::RgbD}) {
    OrbSlam filter = make(kNoFloor, host_sensor(static_cast<int>(sensor)));
    for (long unsigned int id = 0; id < 3; ++id) {
      Host<Frame> host(300, sensor, id);
      const std::vector<int> expected = id == 1 ? all_but(300, {}) : right_half(host.frame);
      if (id != 1) filter.set_detections(left_half());  // used once
      const Verdict& verdict =
          filter.before_tracking(host.frame, noise(640, 480), cv::Mat(), true, orb_slam::HostPose());
      CHECK(verdict.size() == 300);
      CHECK(verdict.kept() == expected.size());
      CHECK(verdict.report.rejected == 300 - expected.size());
      CHECK(filter.judged_keypoints().size() == 300);
      CHECK(filter.weights().size() == expected.size());  // of the thinned frame
      for (const float weight : filter.weights()) CHECK((weight > 0 && weight <= 1));
      check_thinned(host, expected, sensor);
    }
  }
}

TEST_CASE("call point A: keypoints and descriptors only, B finds the rest") {
  OrbSlam filter = make(kNoFloor);
  Host<host::v2::Frame> whole(50);
  host::v2::Frame frame;
  frame.mK = camera_matrix(), frame.mDistCoef = cv::Mat::zeros(4, 1, CV_32F);
  frame.mvKeys = whole.frame.mvKeys;
  frame.mDescriptors = whole.frame.mDescriptors.clone();
  const std::vector<int> expected = right_half(frame);
  filter.set_detections(left_half());
  filter.after_extraction(frame, noise(640, 480), cv::Mat(), true);
  REQUIRE(frame.mvKeys.size() == expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    CHECK(frame.mvKeys[k].class_id == expected[k]);
    CHECK(frame.mDescriptors.at<std::uint8_t>(static_cast<int>(k), 0) == expected[k]);
  }
  CHECK(frame.mDescriptors.rows == static_cast<int>(expected.size()));
}

TEST_CASE("call point C: map points go with their features") {
  OrbSlam filter = make(kNoFloor);
  Host<host::v3::Frame> host(60);
  host.frame.SetPose({});
  filter.before_tracking(host.frame, noise(640, 480), cv::Mat(), true);
  check_thinned(host, all_but(60, {}), Sensor::RgbD);
  const std::vector<float> weights = filter.weights();
  filter.after_pose(host.frame);  // the boxes of the frame were none
  CHECK(filter.weights() == weights);
  check_thinned(host, all_but(60, {}), Sensor::RgbD);
  CHECK(filter.verdict().report.call_point == CallPoint::AfterPose);
}

TEST_CASE_TEMPLATE("a keyframe: map points at another depth than the covisible keyframes saw are returned",
                   Frame, host::v2::Frame, host::v3::Frame) {
  using KeyFrame =
      std::conditional_t<std::is_same_v<Frame, host::v2::Frame>, host::v2::KeyFrame, host::v3::KeyFrame>;
  OrbSlam filter = make(kNoFloor);
  Host<Frame> host(40, Sensor::RgbD, 3);
  KeyFrame keyframe;
  if constexpr (std::is_same_v<Frame, host::v2::Frame>)
    host.frame.mTcw = keyframe.Tcw = cv::Mat::eye(4, 4, CV_32F);
  else
    host.frame.SetPose({});
  // At the keyframe's place the map point of feature i is where the feature sees it. The points of 6 and 10
  // are 20 % farther: |1.2 - 1| / 1.2 = 0.17 > 0.08.
  for (int i = 0; i < 40; ++i) {
    const float z = Host<Frame>::depth_of(i) * (i == 6 || i == 10 ? 1.2F : 1.0F);
    auto& world = host.points[static_cast<std::size_t>(i)].world;
    if constexpr (std::is_same_v<Frame, host::v2::Frame>)
      world.template at<float>(2) = z;
    else
      world.z() = z;
    keyframe.points.push_back(&host.points[static_cast<std::size_t>(i)]);
  }
  KeyFrame bad = keyframe;
  bad.bad = true;
  filter.before_tracking(host.frame, noise(640, 480), cv::Mat(), true);
  const auto moved = filter.at_keyframe(host.frame, std::vector<KeyFrame*>{nullptr, &bad, &keyframe});
  REQUIRE(moved.size() == 2);
  CHECK(moved[0] == &host.points[6]);
  CHECK(moved[1] == &host.points[10]);
  check_thinned(host, all_but(40, {6, 10}), Sensor::RgbD);
  CHECK(filter.at_keyframe(host.frame, std::vector<KeyFrame*>{}).empty());
}

TEST_CASE("until the map exists more is kept") {
  const auto kept = [](OrbSlam& filter, int n, long unsigned int id, bool map_exists) {
    Host<host::v2::Frame> host(n, Sensor::RgbD, id);
    filter.set_detections({person(-10, -10, 900, 900)});
    filter.before_tracking(host.frame, noise(640, 480), cv::Mat(), map_exists);
    return host.frame.N;
  };
  OrbSlam rgbd = make();
  CHECK(kept(rgbd, 1000, 0, false) == 550);
  CHECK(kept(rgbd, 1000, 1, false) == 550);
  CHECK(kept(rgbd, 1000, 2, true) == 100);
  rgbd.reset();
  CHECK(kept(rgbd, 1000, 3, false) == 550);
  CHECK(rgbd.summary().find("550 restored") != std::string::npos);
  OrbSlam all = make("DynFilter.keep_first_frame: true\n");
  CHECK(kept(all, 1000, 0, false) == 1000);
  OrbSlam mono = make("", HostSensor::Monocular);
  CHECK(kept(mono, 1000, 0, false) == 250);
  OrbSlam told = make("DynFilter.min_features_before_map: 700\n");
  CHECK(kept(told, 1000, 0, false) == 700);
  OrbSlam off = make("DynFilter.enabled: 0\n");
  CHECK(kept(off, 1000, 0, true) == 1000);
  CHECK(off.verdict().size() == 0);
}

TEST_CASE("settings: where the pipeline comes from, and what is wrong") {
  const Folder folder;
  const auto read = [&](const std::string& text) {
    return read_orb_slam_settings(folder.write("settings.yaml", kHostKeys + text));
  };
  CHECK(read("").pipeline.name == "dynfilter");
  CHECK(read("DynFilter.pipeline: rts_slam\n").pipeline.name == "rts_slam");
  CHECK(read(kBoxes).pipeline.name == "boxes");
  folder.write("mine.yaml", std::string("%YAML:1.0\n---\n") + kBoxes);
  CHECK(read("DynFilter.pipeline: mine.yaml\n").pipeline.name == "boxes");
  CHECK(read("DynFilter.min_features: 70\n").params.min_features == 70);
  const auto error = [&](const std::string& text) -> std::string {
    try {
      read(text);
      return "";
    } catch (const ConfigError& e) {
      return e.what();
    }
  };
  CHECK(error("DynFilter.min_feature: 70\n").find("unknown key `DynFilter.min_feature`") !=
        std::string::npos);
  CHECK(error("DynFilter.min_features: abc\n").find("expected a whole number") != std::string::npos);
  CHECK(error("DynFilter.pipeline: nowhere\n").find("no pipeline `nowhere`") != std::string::npos);
  CHECK(error(std::string("DynFilter.pipeline: rts_slam\n") + kBoxes).find("both") != std::string::npos);
  CHECK(error("pipeline:\n  before_pose:\n    - nonsense\n").find("settings.yaml") != std::string::npos);
  CHECK_THROWS_AS(read_orb_slam_settings("/nowhere/settings.yaml"), ConfigError);
  // The host's own part of the file is the host's business ...
  CHECK(read("Camera.fps: 30\nCamera.fps: 30\nViewer.PointSize:2\nbaseline: 1\n").pipeline.name ==
        "dynfilter");
  CHECK(error("DynFilter.enabled: 1\nDynFilter.enabled: 0\n").find("`DynFilter.enabled` is written twice") !=
        std::string::npos);
  // ... but what nearly is ours must not be ignored.
  for (const char* key : {"Dynfilter.pipeline", "dynfilter.pipeline", "DynFilter_pipeline", "DynFilter"})
    CHECK(error(std::string(key) + ": rts_slam\n").find(std::string("unknown key `") + key + "`: expected") !=
          std::string::npos);
  CHECK(error("DynFilter:\n  pipeline: rts_slam\n").find("unknown key `DynFilter`: expected keys as") !=
        std::string::npos);
  for (const char* key : {"pipelin", "pipelines", "Pipeline", "piepline"})
    CHECK(error(std::string(key) + ": { before_pose: [] }\n").find("did you mean `pipeline`?") !=
          std::string::npos);
  CHECK(read("DynFilter.pipeline: rts_slam.yaml\n").pipeline.name == "rts_slam");
  CHECK(error("DynFilter.pipeline: rts_slm\n").find("(did you mean `rts_slam`?)") != std::string::npos);
  CHECK(error("DynFilter.pipeline: nowhere\n").find("or one of coeb_slam, des_slam, ") != std::string::npos);
  CHECK(error("DynFilter.pipeline: nowhere\n").find("oracle") == std::string::npos);
  CHECK(error("DynFilter.pipeline: oracle\n").find("only the command `dynfilter` can run it") !=
        std::string::npos);
  CHECK(host_sensor(0) == HostSensor::Monocular);
  CHECK(host_sensor(4) == HostSensor::Stereo);
  CHECK(host_sensor(5) == HostSensor::RgbD);
}

// The whole default pipeline, with flow, on images and depth that keep changing size or go missing.
TEST_CASE("odd input: sizes that change, depth that is missing, empty pose, time back, reset in a frame") {
  for (const char* pipeline : {"dynfilter", "dynfilter_mono", "rts_slam", "des_slam"}) {
    OrbSlam filter(settings_from(std::string("DynFilter.pipeline: ") + pipeline + "\n"), HostSensor::RgbD);
    host::v2::KeyFrame keyframe;  // without a pose
    for (long unsigned int id = 0; id < 14; ++id) {
      Host<host::v2::Frame> host(static_cast<int>(id) == 6 ? 0 : 120, Sensor::RgbD, id == 9 ? 2 : id);
      if (id == 7) host.frame.mTimeStamp = -5;
      if (id == 8) host.frame.mK.release();
      const bool small = id == 3 || id == 4;
      cv::Mat grey = noise(small ? 320 : 640, small ? 240 : 480), depth(grey.size(), CV_32FC1, cv::Scalar(2));
      if (id == 1) depth.release();
      if (id == 2) depth = cv::Mat(100, 100, CV_32FC1, cv::Scalar(2));
      if (id == 5) grey.release();
      if (id == 10) grey = cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(9));
      if (id == 11) host.frame.mDescriptors.release();
      if (id == 12) host.frame.mvKeys[3].pt.x = std::numeric_limits<float>::quiet_NaN();
      orb_slam::HostPose pose;
      if (id == 4) pose = orb_slam::predicted_pose(cv::Mat(), host.frame);
      const Verdict& verdict = filter.before_tracking(host.frame, grey, depth, id > 2, pose);
      CHECK(verdict.size() == (id == 6 ? 0U : 120U));
      CHECK(host.frame.N == static_cast<int>(host.frame.mvKeys.size()));
      CHECK(host.frame.mvpMapPoints.size() == host.frame.mvKeys.size());
      if (id == 13) filter.reset();
      filter.after_pose(host.frame);
      filter.at_keyframe(host.frame, std::vector<host::v2::KeyFrame*>{&keyframe});
      for (const StageReport& stage : filter.verdict().report.stages) CHECK_FALSE(stage.failed);
    }
  }
}

TEST_CASE("time that jumps back and numbers that start again forget the history") {
  OrbSlam filter = make();
  const auto run = [&](long unsigned int id, double time_s) {
    Host<host::v2::Frame> host(20, Sensor::RgbD, id);
    host.frame.mTimeStamp = time_s;
    filter.set_detections({person(-10, -10, 900, 900)});
    filter.before_tracking(host.frame, noise(640, 480), cv::Mat(), false);
    return filter.summary();
  };
  run(5, 10.0);
  CHECK(run(6, 3.0).find("time jump") != std::string::npos);
  CHECK(run(7, 3.04).find("time jump") == std::string::npos);
  CHECK(run(0, 50.0).find("time jump") == std::string::npos);  // a new run: nothing to jump from
}

TEST_CASE("the host's buffers may be reused: what is kept is the library's") {
  const std::string pipeline = "pipeline:\n  before_pose:\n    - flow_consistency\n    - background_motion\n";
  OrbSlam with_own(settings_from(pipeline), HostSensor::RgbD),
      reused(settings_from(pipeline), HostSensor::RgbD);
  cv::Mat big = noise(760, 480), buffer(480, 640, CV_8UC1), depth_buffer(480, 640, CV_32FC1);
  cv::GaussianBlur(big, big, cv::Size(0, 0), 2);
  for (int k = 0; k < 6; ++k) {
    cv::Mat image = big.colRange(6 * k, 6 * k + 640).clone(), depth(480, 640, CV_32FC1, cv::Scalar(2));
    big.colRange(90, 250).copyTo(image.colRange(100 + 20 * k, 260 + 20 * k));  // goes its own way
    Host<host::v2::Frame> a(300, Sensor::RgbD, static_cast<long unsigned int>(k)),
        b(300, Sensor::RgbD, a.frame.mnId);
    with_own.before_tracking(a.frame, image, depth, true);
    image.copyTo(buffer), depth.copyTo(depth_buffer);
    reused.before_tracking(b.frame, buffer, depth_buffer, true);
    buffer.setTo(0), depth_buffer.setTo(0);
    CHECK(with_own.verdict().decision == reused.verdict().decision);
    CHECK(with_own.verdict().suspicion == reused.verdict().suspicion);
  }
  CHECK(with_own.verdict().report.stages[1].judged > 100);
  CHECK(with_own.verdict().report.stages[1].unknown < 200);
}

TEST_CASE("the host may free its images before call point C") {
  const std::string pipeline =
      std::string(kNoFloor) +
      "pipeline:\n  floor: { min_features: 0, min_share: 0 }\n  after_pose:\n"
      "    - cluster_expand: { of: { semantic_box: { role: reject } }, space: depth, "
      "max_reach_m: 1.0 }\n";
  cv::Mat depth(480, 640, CV_32FC1, cv::Scalar(5));
  depth.colRange(100, 420).setTo(cv::Scalar(2));  // one surface, beyond the box
  const auto judge = [&](fuzz::Host kind, std::uint8_t garbage) {
    OrbSlam filter(settings_from(pipeline), HostSensor::RgbD);
    Host<host::v2::Frame> host(300);
    fuzz::LentMemory memory(kind, garbage);
    filter.set_detections({person(110, 0, 150, 480)});
    filter.before_tracking(host.frame, memory.image(noise(640, 480)), memory.image(depth), true);
    CHECK(memory.take_back() == 0);
    filter.after_pose(host.frame);
    return filter.verdict();
  };
  OrbSlam filter(settings_from(pipeline), HostSensor::RgbD);
  Host<host::v2::Frame> host(300);
  const cv::Mat grey = noise(640, 480);
  filter.set_detections({person(110, 0, 150, 480)});
  filter.before_tracking(host.frame, grey, depth, true);
  const Verdict expected = filter.after_pose(host.frame);
  for (const fuzz::Host kind : {fuzz::Host::Frees, fuzz::Host::Reuses})
    for (const int garbage : {0x00, 0xff})
      CHECK(judge(kind, static_cast<std::uint8_t>(garbage)).decision == expected.decision);
  std::size_t beyond_the_box = 0;
  for (std::size_t i = 0; i < expected.size(); ++i)
    beyond_the_box += !expected.keep(i) && filter.judged_keypoints()[i].pt.x > 270 ? 1U : 0U;
  CHECK(beyond_the_box > 0);  // found in the depth image
}

TEST_CASE(
    "a depth image that is handed over gives the same verdicts, and so does one that the host still has") {
  const std::string pipeline = "pipeline:\n  before_pose:\n    - flow_consistency\n    - background_motion\n";
  OrbSlam copies(settings_from(pipeline), HostSensor::RgbD),
      shares(settings_from(pipeline), HostSensor::RgbD), must_copy(settings_from(pipeline), HostSensor::RgbD);
  cv::Mat big = noise(760, 480);
  cv::GaussianBlur(big, big, cv::Size(0, 0), 2);
  for (int k = 0; k < 8; ++k) {
    cv::Mat image = big.colRange(6 * k, 6 * k + 640).clone(), depth(480, 640, CV_32FC1, cv::Scalar(2));
    big.colRange(90, 250).copyTo(image.colRange(100 + 20 * k, 260 + 20 * k));
    Host<host::v2::Frame> a(300, Sensor::RgbD, static_cast<long unsigned int>(k)),
        b(300, Sensor::RgbD, a.frame.mnId), c(300, Sensor::RgbD, a.frame.mnId);
    cv::Mat given = depth.clone(), held = depth.clone();
    cv::Mat still_the_hosts = held;
    copies.before_tracking(a.frame, image, depth, true);
    shares.before_tracking(b.frame, image, std::move(given), true);
    must_copy.before_tracking(c.frame, image, std::move(held), true);
    still_the_hosts.setTo(0);
    CHECK(copies.verdict().suspicion == shares.verdict().suspicion);
    CHECK(copies.verdict().suspicion == must_copy.verdict().suspicion);
  }
  CHECK(shares.verdict().report.stages[1].judged > 100);
}

TEST_CASE("what was rejected can be drawn and told in a line") {
  OrbSlam filter = make(kNoFloor);
  Host<host::v2::Frame> host(100);
  const std::vector<cv::KeyPoint> before = host.frame.mvKeys;
  filter.set_detections(left_half());
  const cv::Mat grey = noise(640, 480);
  filter.before_tracking(host.frame, grey, cv::Mat(), true);
  const cv::Mat picture = filter.draw(grey);
  REQUIRE(picture.type() == CV_8UC3);
  const auto rejected =
      std::count_if(before.begin(), before.end(), [](const cv::KeyPoint& k) { return k.pt.x <= 320; });
  const std::string line = filter.summary(), number = std::to_string(rejected);
  CHECK(line.find("frame 0: 100 features, " + number + " rejected, 0 restored") == 0);
  CHECK(line.find("; semantic_box " + number) != std::string::npos);
  CHECK(filter.draw(cv::Mat()).empty());
}

TEST_CASE("a closed host is given depth without what was rejected, or a painted image") {
  const Folder folder;
  MaskedHost closed(
      folder.write("settings.yaml", std::string(kHostKeys) + "DynFilter.keep_first_frame: 0\n" + kBoxes), 2);
  const cv::Mat image = noise(640, 480), depth(480, 640, CV_16UC1, cv::Scalar(10000));
  closed.set_detections({person(0, 0, 200, 480)});
  const MaskedHost::Images& images = closed.process(image, depth, 0.0);
  CHECK(images.image.data == image.data);
  CHECK(cv::countNonZero(images.depth.colRange(0, 180)) < 180 * 480 * 3 / 20);
  CHECK(cv::countNonZero(images.depth.colRange(240, 640)) == 400 * 480);
  CHECK(cv::countNonZero(depth) == 640 * 480);
  closed.process(image, depth, 0.04);  // no boxes
  CHECK(images.depth.data == depth.data);
  closed.set_detections({person(0, 0, 200, 480)});
  closed.process(image, cv::Mat(), 0.08);
  CHECK(images.image.data != image.data);
  CHECK(cv::norm(images.image.colRange(240, 640), image.colRange(240, 640), cv::NORM_INF) == 0);
  closed.process(cv::Mat(), cv::Mat(), 0.12);
  closed.process(noise(320, 240), cv::Mat(), 0.16);
  CHECK_THROWS_AS(
      MaskedHost(folder.write("fisheye.yaml", std::string(kHostKeys) + "Camera.type: \"KannalaBrandt8\"\n"),
                 0),
      IoError);
}

#if defined(__GLIBC__)
TEST_CASE("memory does not grow with time") {
  OrbSlam filter(settings_from("DynFilter.pipeline: dynfilter\n"), HostSensor::RgbD);
  const cv::Mat big = noise(640, 320), depth(240, 320, CV_32FC1, cv::Scalar(2));
  std::size_t early = 0;
  for (int k = 0; k < 400; ++k) {
    Host<host::v2::Frame> host(100, Sensor::RgbD, static_cast<long unsigned int>(k));
    filter.set_detections({person(10, 10, 50, 100)});
    filter.before_tracking(host.frame, big(cv::Rect(2 * (k % 40), 40 + k % 7, 320, 240)), depth, true);
    filter.at_keyframe(host.frame, std::vector<host::v2::KeyFrame*>{});
    if (k == 100) early = mallinfo2().uordblks;
  }
  CHECK(mallinfo2().uordblks < early + 100000);  // a frame's copy is 400 kB
}
#endif

namespace {

/// Compares what stands between `begin` and the next end mark of the guide. With DYNFILTER_UPDATE_DOCS=1 it
/// is written instead.
void check_guide(const std::string& begin, const std::string& wanted) {
  const std::string path = std::string(DYNFILTER_SOURCE_DIR) + "/docs/how-to/orb_slam.md";
  std::ifstream file(path);
  std::string guide((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto at = guide.find(begin);
  REQUIRE(at != std::string::npos);
  const auto from = at + begin.size(), end = guide.find("<!-- end -->", from);
  REQUIRE(end != std::string::npos);
  if (std::getenv("DYNFILTER_UPDATE_DOCS") != nullptr)
    std::ofstream(path) << guide.replace(from, end - from, wanted);
  else
    CHECK(guide.substr(from, end - from) == wanted);
}

}  // namespace

TEST_CASE("the guide's table of settings is that of the parameters") {
  std::string wanted =
      "| key, after `DynFilter.` | default | meaning |\n|---|---|---|\n"
      "| `pipeline` | `dynfilter` | a preset, or a file with a pipeline |\n";
  for (const FieldInfo& field : describe_parameters<OrbSlamParams>()) {
    const bool number = field.type == "integer" || field.type == "number";
    const std::string value = field.default_value.empty() || field.default_value == "[]" ? "none"
                              : number ? field.default_value + " (" + field.range + ")"
                                       : field.default_value;
    wanted += "| `" + field.name + "` | " + value + " | " + field.doc + " |\n";
  }
  check_guide("<!-- parameters -->\n", wanted);
}

TEST_CASE("docs/reference/pipelines.md: the column `reads` of a preset is what it asks for") {
  std::ifstream file(std::string(DYNFILTER_SOURCE_DIR) + "/docs/reference/pipelines.md");
  const std::string page((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  for (const std::string& name : preset_names()) {
    if (name == "oracle") continue;
    const Pipeline pipeline(load_pipeline(name, builtin_filters()));
    std::string reads;
    const auto asks = [&](Input input, const char* letter) {
      if ((pipeline.needs().optional & input) != Input::None) reads += letter;
    };
    asks(Input::Depth, " D"), asks(Input::Detections, " B"), asks(Input::Mask, " M");
    if (pipeline.stages(CallPoint::AfterPose) != nullptr) reads += " P";
    if (pipeline.stages(CallPoint::AtKeyframe) != nullptr) reads += " K";
    const auto at = page.find("\n| `" + name + "` | ");
    CAPTURE(name);
    REQUIRE(at != std::string::npos);
    const std::string row = page.substr(at + 1, page.find('\n', at + 1) - at - 1);
    CHECK(row.substr(row.rfind(" | ", row.size() - 3) + 2) == (reads.empty() ? " -" : reads) + " |");
  }
}

}  // namespace orb_slam_test
