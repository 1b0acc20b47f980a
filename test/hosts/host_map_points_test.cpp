// SPDX-License-Identifier: MIT
// A host makes map points of its first frame, in which a person walks. The adapter finds those on the person
// although the host has lost them. The lines of docs/how-to/orb_slam.md run here as they are there.
#include <algorithm>
#include <dynfilter/hosts/orb_slam.hpp>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "doctest/doctest.h"
#include "hosts/host_stand_ins.hpp"
#include "hosts/settings_folder.hpp"
#include "pipeline/whole_pixel_scene.hpp"

namespace host_map_points_test {

using namespace dynfilter;
namespace scene = whole_pixel_scene;

constexpr int kWallStep = 12, kPersonStep = 8;  ///< between features [px]

OrbSlam filter_of(const std::string& keys) {
  const dynfilter_test::SettingsFolder folder;
  return OrbSlam(folder.write("settings.yaml", "%YAML:1.0\n---\nCamera.fx: 256.0\n" + keys), 2);
}

/// It stays on one place of the wall or of the person, whose number is the id of its map point.
struct Feature {
  cv::KeyPoint key;
  int place;
  bool on_person;
};

std::vector<Feature> features_of(int k) {
  const cv::Rect person(130 + scene::kPersonStep_px * k, 60, 80, 170);
  std::vector<Feature> features;
  for (int y = 20; y < scene::kHeight - 16; y += kWallStep)
    for (int column = -30; column < 40; ++column) {
      const int x = kWallStep * column + scene::kWallStep_px * k;
      if (x < 20 || x > scene::kWidth - 20 || cv::Rect(person.x - 8, 52, 96, 186).contains({x, y})) continue;
      features.push_back(
          {cv::KeyPoint(static_cast<float>(x), static_cast<float>(y), 31), 1000 * y + 100 + column, false});
    }
  for (int y = 68; y < 222; y += kPersonStep)
    for (int column = 1; column < 10; ++column) {
      const int x = person.x + kPersonStep * column;
      if (x < 20 || x > scene::kWidth - 20) continue;
      features.push_back({cv::KeyPoint(static_cast<float>(x), static_cast<float>(y), 31),
                          1000000 + 1000 * y + column, true});
    }
  return features;
}

template <class Frame>
struct Tracker {
  using MapPoint = orb_slam::MapPointOf<Frame>;
  using KeyFrame =
      std::conditional_t<std::is_same_v<Frame, host::v2::Frame>, host::v2::KeyFrame, host::v3::KeyFrame>;

  explicit Tracker(const std::string& keys) : filter(filter_of(keys)) {}

  /// As GrabImageRGBD: prepare beside the extraction, reject, track.
  void track(int k, bool finds_person = false) {
    const scene::Frame images(k);
    const cv::Mat grey = images.view().grey;
    cv::Mat depth;
    images.view().depth.convertTo(depth, CV_32F, 1.0 / 1024);
    std::thread prepare([&] { filter.prepare(grey, k / 32.0); });
    std::vector<Feature> extracted = features_of(k);
    Frame frame = frame_of(extracted, k, depth);
    prepare.join();
    filter.before_tracking(frame, grey, std::move(depth), k > 0,
                           orb_slam::predicted_pose(velocity, last, k > 1));
    find_points(frame, extracted, k, finds_person);
    set_pose(frame, k);
    last = frame;
  }

  Frame frame_of(const std::vector<Feature>& extracted, int k, const cv::Mat& depth) const {
    Frame frame;
    frame.mnId = static_cast<unsigned long>(k), frame.mTimeStamp = k / 32.0;
    frame.mK = (cv::Mat_<float>(3, 3) << 256, 0, scene::kWidth / 2, 0, 256, scene::kHeight / 2, 0, 0, 1);
    frame.mDistCoef = cv::Mat::zeros(4, 1, CV_32F);
    for (const Feature& feature : extracted) {
      frame.mvKeys.push_back(feature.key);
      frame.mvDepth.push_back(depth.at<float>(feature.key.pt));
    }
    frame.mvKeysUn = frame.mvKeys;
    frame.N = static_cast<int>(extracted.size());
    frame.mvuRight.assign(extracted.size(), -1.0F);
    frame.mvpMapPoints.assign(extracted.size(), nullptr);
    frame.mvbOutlier.assign(extracted.size(), false);
    frame.mDescriptors = cv::Mat(frame.N, 32, CV_8U, cv::Scalar(1));
    return frame;
  }

  /// All of frame 0 become map points. Later the host finds those of the wall, on the person only outliers.
  void find_points(Frame& frame, const std::vector<Feature>& extracted, int k, bool finds_person) {
    std::map<std::pair<float, float>, Feature> by_place;
    for (const Feature& feature : extracted) by_place[{feature.key.pt.x, feature.key.pt.y}] = feature;
    for (std::size_t i = 0; i < frame.mvKeys.size(); ++i) {
      const Feature& feature = by_place.at({frame.mvKeys[i].pt.x, frame.mvKeys[i].pt.y});
      if (k == 0) {
        std::unique_ptr<MapPoint>& made = points[feature.place];
        made = std::make_unique<MapPoint>();
        made->mnId = static_cast<unsigned long>(feature.place);
        first.points.push_back(made.get());
        if (feature.on_person) on_person.insert(made.get());
      }
      const auto known = points.find(feature.place);
      const bool outlier = feature.on_person && k > 0 && !finds_person;
      frame.mvpMapPoints[i] = known == points.end() || outlier ? nullptr : known->second.get();
      frame.mvbOutlier[i] = outlier;
    }
  }

  /// The wall moves 3 px to the right per frame at 3 m.
  void set_pose(Frame& frame, int k) {
    const float x = 3.0F * scene::kWallStep_px / 256 * static_cast<float>(k);
    if constexpr (std::is_same_v<Frame, host::v2::Frame>) {
      frame.mTcw = cv::Mat::eye(4, 4, CV_32F), velocity = cv::Mat::eye(4, 4, CV_32F);
      frame.mTcw.template at<float>(0, 3) = x, velocity.template at<float>(0, 3) = 3.0F * 3 / 256;
    } else {
      host::v3::SE3f T;
      T.m(0, 3) = x;
      frame.SetPose(T);
      velocity.m(0, 3) = 3.0F * 3 / 256;
    }
  }

  std::set<MapPoint*> moved_at_keyframe() {
    const auto moved = filter.at_keyframe(last, std::vector<KeyFrame*>{nullptr, &first});
    std::set<MapPoint*> unique(moved.begin(), moved.end());
    CHECK(unique.size() == moved.size());
    return unique;
  }

  OrbSlam filter;
  std::map<int, std::unique_ptr<MapPoint>> points;
  std::set<MapPoint*> on_person;
  KeyFrame first;
  Frame last;
  std::conditional_t<std::is_same_v<Frame, host::v2::Frame>, cv::Mat, host::v3::SE3f> velocity;
};

TEST_CASE_TEMPLATE("map points on a person of the first frame are returned at a keyframe, and only they",
                   Frame, host::v2::Frame, host::v3::Frame) {
  Tracker<Frame> host("DynFilter.min_features: 0\n");
  for (int k = 0; k <= 16; ++k) {
    host.track(k);
    if (k == 4) CHECK(host.moved_at_keyframe().empty());  // too early to be sure
  }
  const auto moved = host.moved_at_keyframe();
  for (auto* const point : moved) CHECK(host.on_person.count(point) == 1);
  MESSAGE(moved.size() << " of " << host.on_person.size() << " map points on the person");
  CHECK(10 * moved.size() >= 9 * host.on_person.size());
  for (auto* const point : moved) CHECK(host.filter.moved(point));  // for candidates of loops
  for (auto* const point : host.first.points)
    if (moved.count(point) == 0) CHECK_FALSE(host.filter.moved(point));
  CHECK_FALSE(host.filter.moved(static_cast<typename Tracker<Frame>::MapPoint*>(nullptr)));

  host.filter.lost();
  CHECK(host.filter.moved(*moved.begin()));  // the map is the same
  host.filter.reset();
  CHECK_FALSE(host.filter.moved(*moved.begin()));
}

TEST_CASE("a feature that a floor restored does not take a moved map point into a keyframe") {
  Tracker<host::v2::Frame> host("DynFilter.min_features: 5000\n");
  for (int k = 0; k <= 16; ++k) host.track(k, true);
  const int before = host.last.N;
  const std::vector<host::v2::MapPoint*> points = host.last.mvpMapPoints;
  CHECK(host.filter.verdict().report.restored > 50);
  const auto moved = host.moved_at_keyframe();
  const auto there =
      std::count_if(points.begin(), points.end(), [&](auto* p) { return moved.count(p) != 0; });
  CHECK(there > 50);
  CHECK(host.last.N == before - there);
  CHECK(host.filter.verdict().report.rejected == static_cast<std::size_t>(there));
  CHECK(static_cast<int>(host.filter.weights().size()) == host.last.N);
  for (auto* const point : host.last.mvpMapPoints) CHECK((point == nullptr || moved.count(point) == 0));
}

TEST_CASE("what is read of the last frame: map points, inliers and outliers, while the host has a map") {
  Tracker<host::v2::Frame> host("");
  host.track(0);
  std::vector<std::int64_t> ids;
  host.last.mvbOutlier[3] = true, host.last.mvpMapPoints[4] = nullptr;
  const HostTracking tracking = orb_slam::tracking_of(host.last, ids);
  CHECK(tracking.outliers == 1);
  CHECK(tracking.inliers == host.last.mvKeys.size() - 2);
  CHECK(tracking.keypoints.size() == host.last.mvKeys.size());
  REQUIRE(tracking.map_point_ids.size() == host.last.mvKeys.size());
  CHECK(tracking.map_point_ids[3] == -1);
  CHECK(tracking.map_point_ids[4] == -1);
  CHECK(tracking.map_point_ids[5] == static_cast<std::int64_t>(host.last.mvpMapPoints[5]->mnId));
  host.last.mvbOutlier.clear();
  CHECK(orb_slam::tracking_of(host.last, ids).map_point_ids.empty());

  int reads = 0;
  const auto judge = [&](int k, bool map_exists) {
    host::v2::Frame frame = host.frame_of(features_of(k), k, scene::Frame(k).view().depth);
    orb_slam::HostPose pose = orb_slam::predicted_pose(host.velocity, host.last);
    pose.tracking = [&](std::vector<std::int64_t>&) { return ++reads, HostTracking(); };
    host.filter.before_tracking(frame, scene::Frame(k).view().grey, cv::Mat(), map_exists, pose);
  };
  judge(1, false);
  CHECK(reads == 0);  // after Reset() the points of mLastFrame are deleted
  judge(2, true);
  CHECK(reads == 1);
  host.filter.lost();
  judge(3, true);
  CHECK(reads == 1);
  judge(4, true);
  CHECK(reads == 2);
}

TEST_CASE("prepare: the adapter's verdicts are the same without it, and off it does nothing") {
  const auto kept = [](bool prepares) {
    OrbSlam filter = filter_of("DynFilter.min_features: 0\n");
    Tracker<host::v2::Frame> frames("");
    std::vector<int> counts;
    for (int k = 0; k < 8; ++k) {
      const scene::Frame images(k);
      cv::Mat depth;
      images.view().depth.convertTo(depth, CV_32F, 1.0 / 1024);
      host::v2::Frame frame = frames.frame_of(features_of(k), k, depth);
      if (prepares) std::thread([&] { filter.prepare(images.view().grey, k / 32.0); }).join();
      filter.before_tracking(frame, images.view().grey, depth, true);
      CHECK(filter.verdict().report.notes.empty());
      counts.push_back(frame.N);
    }
    return counts;
  };
  CHECK(kept(true) == kept(false));
  CHECK(kept(true).back() < kept(true).front());
  OrbSlam off = filter_of("DynFilter.enabled: 0\n");
  off.prepare(scene::Frame(0).view().grey, 0);
}

}  // namespace host_map_points_test
