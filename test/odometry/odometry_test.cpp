// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/detectors/detections.hpp>
#include <filesystem>
#include <odometry/odometry.hpp>

#include "eval/ate.hpp"
#include "test_images.hpp"

#include "doctest/doctest.h"

namespace odometry_test {

using namespace dynfilter;
using namespace dynfilter::odometry;
using odometry_test::frame_at;

namespace {

/// A camera that swings in front of the relief, at 30 Hz.
double x_at(int i) {
  return 0.15 * std::sin(0.07 * i);
}
double y_at(int i) {
  return 0.08 * (1 - std::cos(0.05 * i));
}
io::SequenceFrame sway(int i) {
  return frame_at(x_at(i), y_at(i), i / 30.0);
}

/// Rejects the features in a part of the image, and records its calls.
class RecordingJudge : public FeatureJudge {
 public:
  cv::Rect2f bad;
  std::string calls;
  int shown_bad = 0;  ///< rejected features that appeared again
  std::vector<std::uint8_t> flags;

  Flags before_pose(const FrameView& view) override {
    calls += view.pose_provenance == PoseProvenance::None ? 'n' : 'p';
    return reject(view);
  }
  Flags after_pose(const FrameView& view) override {
    calls += view.pose_provenance == PoseProvenance::Estimated ? 'a' : '?';
    count_bad(view);
    CHECK(view.map_point_ids.size() == view.size());
    return {};
  }
  Flags at_keyframe(const FrameView& view) override {
    calls += 'k';
    count_bad(view);
    return {};
  }
  void lost() override { calls += 'l'; }
  void reset() override { calls += 'r'; }

 private:
  Flags reject(const FrameView& view) {
    CHECK(view.descriptors.rows == static_cast<int>(view.size()));
    CHECK(view.depth_m.size() == view.size());
    flags.assign(view.size(), 0);
    for (std::size_t i = 0; i < view.size(); ++i) flags[i] = bad.contains(view.keypoints[i].pt);
    return flags;
  }
  void count_bad(const FrameView& view) {
    for (const cv::KeyPoint& k : view.keypoints) shown_bad += bad.contains(k.pt);
  }
};

double worst_error_m(const io::Trajectory& trajectory) {
  double worst = 0;
  for (const auto& pose : trajectory) {
    const int i = static_cast<int>(std::lround(pose.timestamp_s * 30));
    worst = std::max(worst, (pose.T_world_camera.t() - Eigen::Vector3d(x_at(i), y_at(i), 0)).norm());
  }
  return worst;
}

}  // namespace

TEST_CASE("a swaying camera is followed to millimetres, twice the same to the last bit") {
  cv::setNumThreads(1);
  io::Trajectory runs[2];
  for (auto& run : runs) {
    Odometry odometry(odometry_test::camera(), {}, nullptr);
    int keyframes = 0;
    for (int i = 0; i < 40; ++i) {
      const TrackResult result = odometry.process(sway(i));
      CHECK(result.state == TrackState::Tracked);
      CHECK(result.features > 900);
      CHECK(result.tracked_points > 200);
      keyframes += result.keyframe;
    }
    CHECK(keyframes >= 3);
    CHECK(keyframes < 30);
    run = odometry.trajectory();
  }
  REQUIRE(runs[0].size() == 40);
  CHECK(worst_error_m(runs[0]) < 0.003);
  for (std::size_t i = 0; i < 40; ++i) {
    CHECK(runs[0][i].T_world_camera.rotation == runs[1][i].T_world_camera.rotation);
    CHECK(runs[0][i].T_world_camera.translation_m == runs[1][i].T_world_camera.translation_m);
  }
}

TEST_CASE("the map keeps no more keyframes than allowed, and the trajectory keeps all frames") {
  cv::setNumThreads(1);
  OdometryOptions options;
  options.max_keyframes = 12;
  Odometry odometry(odometry_test::camera(), options, nullptr), whole(odometry_test::camera(), {}, nullptr);
  constexpr int kFrames = 120;
  std::vector<std::size_t> kept_points;
  for (int i = 0; i < kFrames; ++i) {
    CHECK(odometry.process(sway(i)).state == TrackState::Tracked);
    whole.process(sway(i));
    const Map& map = odometry.map();
    CHECK(map.keyframes.count() <= 12);
    std::size_t points = 0, forgotten = 0;
    for (std::int64_t k = map.points.first(); k < static_cast<std::int64_t>(map.points.size()); ++k) {
      if (!map.alive(k)) continue;
      ++points;
      for (const Observation& o : map.point(k).observations)
        forgotten += o.keyframe < map.keyframes.first() ? 1 : 0;
    }
    CHECK(forgotten == 0);
    kept_points.push_back(points);
    // Until the first keyframe is removed, nothing is different.
    if (map.keyframes.first() == 0)
      CHECK(odometry.trajectory().back().T_world_camera.translation_m ==
            whole.trajectory().back().T_world_camera.translation_m);
  }
  CHECK(odometry.map().keyframes.first() > 5);
  CHECK(whole.map().keyframes.first() == 0);
  CHECK(kept_points.back() <= std::size_t{12} * 1000);
  const io::Trajectory trajectory = odometry.trajectory();
  REQUIRE(trajectory.size() == kFrames);
  for (int i = 0; i < kFrames; ++i) CHECK(trajectory[static_cast<std::size_t>(i)].timestamp_s == i / 30.0);
  CHECK(worst_error_m(trajectory) < 0.005);
}

TEST_CASE("the judge is asked where it should be, and what it rejects is gone") {
  RecordingJudge judge;
  judge.bad = {0, 0, 320, 480};
  Odometry odometry(odometry_test::camera(), {}, &judge);
  for (int i = 0; i < 3; ++i) {
    const TrackResult result = odometry.process(sway(i));
    int in_area = 0;
    for (std::size_t k = 0; k < odometry.extracted().size(); ++k) {
      const bool bad = judge.bad.contains(odometry.extracted()[k].pt);
      in_area += bad;
      CHECK(odometry.rejected_at()[k] == (bad ? RejectedAt::BeforePose : RejectedAt::Nowhere));
    }
    CHECK(in_area > 300);
    CHECK(result.rejected == in_area);
    int points = 0;
    const Map& map = odometry.map();
    for (std::int64_t k = 0; k < static_cast<std::int64_t>(map.points.size()); ++k)
      if (map.alive(k)) points += map.point(k).world_m.x() / map.point(k).world_m.z() * 525 + 319.5 < 319;
    CHECK(points == 0);  // none was created where the first frame was judged bad
  }
  CHECK(judge.shown_bad == 0);
  CHECK(judge.calls.substr(0, 2) == "nk");
  judge.calls.erase(std::remove(judge.calls.begin(), judge.calls.end(), 'k'), judge.calls.end());
  CHECK(judge.calls == "npapa");
}

TEST_CASE("a loss is said, and ends when known places return") {
  RecordingJudge judge;
  Odometry odometry(odometry_test::camera(), {}, &judge);
  for (int i = 0; i < 12; ++i) REQUIRE(odometry.process(sway(i)).state == TrackState::Tracked);
  judge.calls.clear();
  for (int i = 12; i < 15; ++i) {
    io::SequenceFrame dark = sway(i);
    dark.grey = cv::Mat(480, 640, CV_8UC1, cv::Scalar(3));
    const TrackResult result = odometry.process(dark);
    CHECK(result.state == TrackState::Lost);
    CHECK(!result.T_world_camera);
  }
  CHECK(judge.calls == "plnn");
  judge.calls.clear();
  const TrackResult back = odometry.process(sway(25));
  CHECK(back.state == TrackState::Tracked);
  CHECK(back.relocalised);
  CHECK(judge.calls.substr(0, 2) == "na");
  CHECK(judge.calls.back() == 'l');
  CHECK(odometry.process(sway(26)).state == TrackState::Tracked);
  CHECK(odometry.trajectory().size() == 14);
  CHECK(worst_error_m(odometry.trajectory()) < 0.004);
}

TEST_CASE("a time jump is said and resets the judge; depthless, dark and small images do no harm") {
  RecordingJudge judge;
  Odometry odometry(odometry_test::camera(), {}, &judge);
  io::SequenceFrame first = sway(0);
  first.depth = cv::Mat();
  CHECK(odometry.process(first).state == TrackState::NoMap);
  for (int i = 1; i < 4; ++i) CHECK(odometry.process(sway(i)).state == TrackState::Tracked);
  io::SequenceFrame depthless = sway(4);
  depthless.depth = cv::Mat();
  CHECK(odometry.process(depthless).state == TrackState::Tracked);
  judge.calls.clear();
  io::SequenceFrame later = sway(5);
  later.timestamp_s += 100;
  const TrackResult result = odometry.process(later);
  CHECK(result.time_jump);
  CHECK(judge.calls.front() == 'r');
  CHECK(result.state == TrackState::Tracked);

  Odometry empty(odometry_test::camera(), {}, nullptr);
  io::SequenceFrame tiny;
  tiny.grey = cv::Mat(20, 20, CV_8UC1, cv::Scalar(0));
  CHECK(empty.process(tiny).state == TrackState::NoMap);
  CHECK(empty.trajectory().empty());
}

namespace {

/// Rejects all features in boxes of people.
class BoxJudge : public RecordingJudge {
 public:
  Flags before_pose(const FrameView& view) override {
    flags.assign(view.size(), 0);
    if (!view.detections) return flags;
    for (const Detection& d : view.detections->detections)
      for (std::size_t i = 0; i < view.size() && d.class_name == "person"; ++i)
        if (d.box.contains(view.keypoints[i].pt)) flags[i] = 1;
    return flags;
  }
};

double ate_m(const std::filesystem::path& folder, FeatureJudge* judge, std::size_t& tracked,
             std::size_t& frames) {
  const auto sequence = io::Sequence::open(folder);
  io::DetectionTrack track;
  if (judge) track = io::read_detections(folder / "detections_yolov8.txt");
  Odometry odometry(sequence.camera(), {}, judge);
  frames = sequence.size();
  tracked = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    const io::SequenceFrame frame = sequence.load(i);
    SemanticInputs inputs;
    if (const auto* detections = track.at(frame.timestamp_s))
      inputs.detections = DetectionInput{-1, Span<const Detection>(*detections)};
    tracked += odometry.process(frame, inputs).state == TrackState::Tracked;
  }
  return eval::absolute_trajectory_error(*sequence.ground_truth(), odometry.trajectory()).error_m.rmse;
}

}  // namespace

TEST_CASE("real frames: a static desk, and walking people with the features in their boxes dropped" *
          doctest::test_suite("shared_data")) {
  const std::filesystem::path data = DYNFILTER_DATA_DIR;
  if (!std::filesystem::exists(data / "tum_fr1_xyz")) {
    MESSAGE("skipped: no ../shared/data");
    return;
  }
  std::size_t tracked = 0, frames = 0;
  CHECK(ate_m(data / "tum_fr1_xyz", nullptr, tracked, frames) < 0.010);
  CHECK(tracked == frames);
  BoxJudge boxes;
  CHECK(ate_m(data / "tum_fr3_walking_halfsphere", &boxes, tracked, frames) < 0.020);
  CHECK(tracked == frames);
}

}  // namespace odometry_test
