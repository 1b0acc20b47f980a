// SPDX-License-Identifier: MIT
// The adapter's frames as the flight recorder saw them, from hosts that stand in for ORB-SLAM2 and 3.
#include <dynfilter/hosts/masked_host.hpp>
#include <dynfilter/hosts/orb_slam.hpp>
#include <dynfilter/recorder/recording.hpp>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "doctest/doctest.h"
#include "hosts/host_stand_ins.hpp"
#include "hosts/settings_folder.hpp"
#include "support/layered_scene.hpp"

namespace host_recording_test {

using namespace dynfilter;
using dynfilter_test::LayeredFrame;
using dynfilter_test::LayeredScene;
using recorder::RecordedEvent;
using recorder::RecordingReader;

namespace {

constexpr int kMono = 0, kStereo = 1, kRgbd = 2;
constexpr int kFrames = 6;
constexpr int kWithoutRight = 3;  ///< the frame without a right image

class Folder : public dynfilter_test::SettingsFolder {
 public:
  std::string settings(const std::string& keys) const {
    return write("settings.yaml",
                 "%YAML:1.0\n---\nCamera.fx: 250.0\nCamera.fy: 250.0\nCamera.cx: 160.0\nCamera.cy: 120.0\n"
                 "DepthMapFactor: 1.0\n" +
                     keys);
  }
  std::filesystem::path recording() const { return path() / "host.dfr"; }
  std::string record_key() const { return "DynFilter.record: '" + recording().string() + "'\n"; }
};

template <class Frame>
constexpr bool kIsVersion3 = std::is_same_v<Frame, host::v3::Frame>;

/// As the host's constructor leaves a frame.
template <class Frame>
void fill(Frame& frame, const LayeredFrame& from, int sensor) {
  const std::size_t n = from.size();
  frame.mnId = static_cast<long unsigned int>(from.id), frame.mTimeStamp = from.timestamp_s;
  frame.mK = (cv::Mat_<float>(3, 3) << 250, 0, 160, 0, 250, 120, 0, 0, 1);
  frame.mDistCoef = cv::Mat::zeros(4, 1, CV_32F);
  frame.mbf = sensor == kMono ? 0 : static_cast<float>(LayeredScene::kBaseline_px_m);
  frame.mvKeys = frame.mvKeysUn = from.keypoints;
  frame.mDescriptors = from.descriptors.clone();
  frame.mvDepth.assign(n, -1), frame.mvuRight.assign(n, -1);
  if (sensor != kMono) frame.mvDepth = from.depth_m, frame.mvuRight = from.right_u_px;
  frame.N = static_cast<int>(n);
  frame.mvpMapPoints.assign(n, nullptr), frame.mvbOutlier.assign(n, false);
}

/// A first pose, and a map point on every other feature.
template <class Frame>
void track(Frame& frame, const LayeredFrame& from, std::vector<orb_slam::MapPointOf<Frame>>& points) {
  if constexpr (kIsVersion3<Frame>) {
    host::v3::SE3f pose;
    pose.m(0, 3) = -static_cast<float>(from.T_world_camera.translation_m[0]);
    frame.SetPose(pose);
  } else {
    frame.mTcw = cv::Mat::eye(4, 4, CV_32F);
    frame.mTcw.template at<float>(0, 3) = -static_cast<float>(from.T_world_camera.translation_m[0]);
  }
  for (std::size_t k = 0; k < frame.mvpMapPoints.size(); k += 2) {
    points[k].mnId = static_cast<long unsigned int>(k);
    frame.mvpMapPoints[k] = &points[k];
  }
}

struct Played {
  std::vector<Verdict> verdicts;
  std::vector<std::size_t> features;  ///< at each call, before it was thinned
};

/// Plays a few frames through all call points, as a host's tracking does. It is reset before frame 4.
template <class Frame>
Played play(OrbSlam& filter, int sensor) {
  Played played;
  std::vector<orb_slam::MapPointOf<Frame>> points(5000);
  Frame last;
  for (int k = 0; k < kFrames; ++k) {
    const LayeredFrame from = LayeredScene().frame(k);
    if (k == 4) filter.reset();
    filter.set_detections(from.boxes);
    filter.set_mask(from.labels);
    if (k != kWithoutRight) filter.set_right_image(from.grey);  // only a stereo host's is used
    Frame frame;
    fill(frame, from, sensor);
    const auto call = [&](const auto& judge) {
      played.features.push_back(frame.mvKeys.size());
      judge();
      played.verdicts.push_back(filter.verdict());
    };
    const orb_slam::HostPose pose = k > 0 && k != 4
                                        ? orb_slam::predicted_pose(cv::Mat(cv::Mat::eye(4, 4, CV_32F)), last)
                                        : orb_slam::HostPose();
    call([&] {
      filter.before_tracking(frame, from.grey, sensor == kRgbd ? from.depth.clone() : cv::Mat(), k > 1, pose);
    });
    track(frame, from, points);
    call([&] { filter.after_pose(frame); });
    using KeyFrame = std::conditional_t<kIsVersion3<Frame>, host::v3::KeyFrame, host::v2::KeyFrame>;
    if (k % 2 == 0) call([&] { filter.at_keyframe(frame, std::vector<KeyFrame*>()); });
    last = frame;
  }
  return played;
}

template <class Frame>
void check_round_trip(int sensor, const char* preset) {
  const Folder folder;
  Played host;
  {
    const auto filter = OrbSlam::start(
        folder.settings(std::string("DynFilter.pipeline: ") + preset + "\n" + folder.record_key()), sensor,
        nullptr);
    REQUIRE(filter != nullptr);
    host = play<Frame>(*filter, sensor);
  }
  RecordingReader reader(folder.recording());
  CHECK(reader.notes().empty());
  REQUIRE(reader.calls() == host.verdicts.size());
  Pipeline pipeline(config_of(reader.pipeline(), builtin_filters()));
  std::vector<KeyframeView> keyframes;
  std::size_t k = 0, resets = 0, poses = 0;
  while (const auto event = reader.next()) {
    event->repeat(pipeline);
    resets += event->kind == RecordedEvent::Kind::Reset ? 1 : 0;
    poses += event->kind == RecordedEvent::Kind::Pose ? 1 : 0;
    if (event->kind != RecordedEvent::Kind::Frame) continue;
    CAPTURE(k);
    const FrameView view = event->frame.view(keyframes);
    CHECK(view.size() == host.features[k]);  // thinned by the verdicts before
    CHECK(view.depth.empty() == (sensor != kRgbd));
    CHECK(view.right_u_px.empty() == (sensor != kStereo));
    const bool right = sensor == kStereo && view.id != kWithoutRight;
    CHECK(view.right_grey.empty() == !right);
    if (right) CHECK(cv::norm(view.right_grey, view.grey, cv::NORM_INF) == 0);
    CHECK((view.mask && view.detections && view.camera));
    CHECK(!recorder::difference(*event->verdict, host.verdicts[k]).any());
    CHECK(!recorder::difference(*event->verdict, pipeline.process(view, event->point, event->limits)).any());
    ++k;
  }
  CHECK(k == host.verdicts.size());
  CHECK(resets == 1);
  CHECK(poses == kFrames - 2);
}

}  // namespace

TEST_CASE_TEMPLATE("what a host hands in is recorded, and its verdicts come back", Frame, host::v2::Frame,
                   host::v3::Frame) {
  if constexpr (!kIsVersion3<Frame>)
    for (const int sensor : {kMono, kStereo, kRgbd})
      for (const char* preset : {"dynfilter", "rts_slam", "dynaslam"})
        check_round_trip<Frame>(sensor, preset);
  else
    check_round_trip<Frame>(kRgbd, "sg_slam");
}

TEST_CASE("keep_first_frame is a parameter of the recorded pipeline") {
  const Folder folder;
  OrbSlam::start(folder.settings("DynFilter.keep_first_frame: false\n" + folder.record_key()), kRgbd,
                 nullptr);
  const RecordingReader reader(folder.recording());
  CHECK(reader.pipeline().name == "dynfilter");
  CHECK(config_of(reader.pipeline(), builtin_filters()).params.first_frame_suspects ==
        FirstFrameSuspects::Reject);
}

TEST_CASE("a pipeline in the settings themselves is recorded with them") {
  const Folder folder;
  OrbSlam::start(folder.settings("pipeline: {name: mine, before_pose: [ epipolar ]}\n" + folder.record_key()),
                 kMono, nullptr);
  const RecordingReader reader(folder.recording());
  CHECK(config_of(reader.pipeline(), builtin_filters()).name == "mine");
}

TEST_CASE("a recording that cannot be written stops the host at start, with the key's name") {
  const Folder folder;
  std::string said;
  const auto tell = [&](const std::string& line) { said = line; };
  CHECK(OrbSlam::start(folder.settings("DynFilter.record: /nowhere/run.dfr\n"), kMono, tell) == nullptr);
  CHECK(said ==
        "dynfilter: DynFilter.record: /nowhere/run.dfr: the recording cannot be written: No such file or "
        "directory");
  CHECK(OrbSlam::start(folder.settings("DynFilter.enabled: false\nDynFilter.record: /nowhere/run.dfr\n"),
                       kMono, tell) != nullptr);
}

TEST_CASE("hosts that take masks record, too") {
  const Folder folder;
  {
    MaskedHost host(folder.settings(folder.record_key()), kRgbd);
    for (int k = 0; k < 3; ++k) {
      const LayeredFrame from = LayeredScene().frame(k);
      host.process(from.grey, from.depth, from.timestamp_s);
    }
  }
  CHECK(RecordingReader(folder.recording()).calls() == 3);
}

}  // namespace host_recording_test
