// SPDX-License-Identifier: MIT
// What flow_consistency carries from frame to frame does not outlive its premise by a second. Each case shows
// the premise, takes it away, and expects neutral votes.
#include <algorithm>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/flow_consistency.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <opencv2/core.hpp>
#include <vector>

#include "doctest/doctest.h"

namespace flow_consistency_expiry_test {

using namespace dynfilter;

namespace {

constexpr double kRate_hz = 20;

/// A point that is seen. Two of consecutive frames with the same number are one track.
struct Seen {
  int number;
  cv::Point3d at_m;  ///< right of, below and ahead of the camera
};

/// The filter behind a camera with f = 700 px and 1240 x 380 px.
class Camera700 {
 public:
  void see(const std::vector<Seen>& points) {
    std::vector<cv::KeyPoint> keypoints;
    std::vector<std::int32_t> reference;
    for (const Seen& p : points) {
      keypoints.emplace_back(static_cast<float>(620 + 700 * p.at_m.x / p.at_m.z),
                             static_cast<float>(190 + 700 * p.at_m.y / p.at_m.z), 7.0F);
      const auto last =
          std::find_if(seen_.begin(), seen_.end(), [&](const Seen& q) { return q.number == p.number; });
      reference.push_back(last == seen_.end() ? -1 : static_cast<std::int32_t>(last - seen_.begin()));
    }
    seen_ = points;
    FrameView view;
    view.id = frame_;
    view.timestamp_s = frame_ / kRate_hz;
    view.keypoints = keypoints;
    view.camera = Camera();
    view.camera->width_px = 1240, view.camera->height_px = 380;
    view.matches = HostMatches{frame_ - 1, reference};
    evidence_.begin(view, CallPoint::BeforePose);
    votes_.reset(keypoints.size());
    filter_.apply(evidence_, votes_);
    evidence_.end(false);
    ++frame_;
  }
  /// Of the points with these numbers.
  int dynamic(int from, int to) const {
    int n = 0;
    for (std::size_t i = 0; i < seen_.size(); ++i)
      n += seen_[i].number >= from && seen_[i].number < to && votes_[i] == Vote::Dynamic ? 1 : 0;
    return n;
  }

 private:
  FlowConsistencyFilter filter_;
  FrameEvidence evidence_;
  Votes votes_;
  std::vector<Seen> seen_;
  int frame_ = 0;
};

constexpr int kFirstOfCar = 350, kEnd = 380;

/// A road 1.5 m below the camera, walls on both sides, and the front of a car on the oncoming lane (the last
/// 30).
/// `driven_m` of the camera and `car_m` of the car, towards each other.
std::vector<Seen> road(double driven_m, double car_m) {
  SampleGenerator rng(1);
  std::vector<Seen> points;
  const auto add = [&](double x, double y, double z) {
    points.push_back({static_cast<int>(points.size()), {x, y, z}});
  };
  for (int i = 0; i < 150; ++i) {
    const double x = rng.uniform(-6, 6);
    add(x, 1.5, rng.uniform(16, 40) - driven_m);
  }
  for (int i = 0; i < 200; ++i) {
    const double y = rng.uniform(-4, 1.5);
    add(i % 2 == 0 ? -9 : 9, y, rng.uniform(20, 50) - driven_m);
  }
  for (int i = 0; i < 30; ++i) {
    const double x = rng.uniform(-4, -2.4);
    add(x, rng.uniform(0.1, 1.45), 26 - driven_m - car_m);
  }
  return points;
}

constexpr double kSpeed_mps = 8;
constexpr int kDrive = 16, kSecond = static_cast<int>(kRate_hz);  ///< frames

}  // namespace

// Half of the car has tracks too young to be compared with the ground: these have what is lent.
TEST_CASE(
    "flow_consistency: distance from the ground, own and lent, is forgotten where the camera does not "
    "drive") {
  Camera700 camera;
  const auto drive = [&](int k) {
    const double way_m = kSpeed_mps * k / kRate_hz;
    std::vector<Seen> points = road(way_m, way_m);
    for (Seen& p : points)
      if (p.number >= kFirstOfCar && p.number % 2 == 0)
        p.number += 1000 * (k / 2 + 1);  // new every second frame
    return points;
  };
  constexpr int kStop = kDrive + 1;  // the young tracks have one flow
  for (int k = 0; k <= kStop; ++k) camera.see(drive(k));
  REQUIRE(camera.dynamic(kFirstOfCar, 100000) >= 25);
  for (int k = 0; k < kSecond; ++k) camera.see(drive(kStop));  // all stop; tracks live on
  CHECK(camera.dynamic(0, 100000) == 0);
}

// A wall across the view that reaches deeper than the road did: beneath the plane of the road, if it were
// there.
TEST_CASE("flow_consistency: the ground is forgotten when it was not seen for a second") {
  Camera700 camera;
  for (int k = 0; k <= kDrive; ++k) camera.see(road(kSpeed_mps * k / kRate_hz, 0));
  REQUIRE(camera.dynamic(0, kEnd) <= 5);
  const auto wall = [](double driven_m) {
    SampleGenerator rng(2);
    std::vector<Seen> points;
    for (int i = 0; i < 300; ++i) {
      const double x = rng.uniform(-14, 14);
      points.push_back({1000 + i, {x, rng.uniform(-4, 4), 24 - driven_m}});
    }
    return points;
  };
  for (int k = 0; k < kSecond; ++k) camera.see(wall(0));
  int worst = 0;
  for (int k = 0; k < kDrive; ++k) {
    camera.see(wall(0.5 * kSpeed_mps * k / kRate_hz));
    worst = std::max(worst, camera.dynamic(0, 100000));
  }
  CHECK(worst <= 9);  // of 300
}

// Eight points of something that flies sideways, far from all else in the image, and stops. Then they are all
// that is seen for a second: too few to measure a motion by.
TEST_CASE("flow_consistency: the flow of a track is forgotten if it was not measured for a second") {
  constexpr int kFirst = kEnd - 8;
  Camera700 camera;
  const auto scene = [](double aside_m, bool all) {
    std::vector<Seen> points = road(0, 0);
    points.erase(points.begin() + (all ? kFirstOfCar : 0), points.begin() + kFirst);
    for (Seen& p : points)
      if (p.number >= kFirst) p.at_m.x += 2.4 + aside_m, p.at_m.y -= 4.5;
    return points;
  };
  for (int k = 0; k <= kDrive; ++k) camera.see(scene(2.0 * k / kRate_hz, true));
  REQUIRE(camera.dynamic(kFirst, kEnd) >= 7);
  const double aside_m = 2.0 * kDrive / kRate_hz;
  for (int k = 0; k < kSecond; ++k) camera.see(scene(aside_m, false));
  camera.see(scene(aside_m, true));
  camera.see(scene(aside_m, true));
  CHECK(camera.dynamic(0, kEnd) == 0);
}

// A camera in the hand: for 0.2 s it happens to move ahead, in between it moves to the side.
TEST_CASE("flow_consistency: a few frames ahead are no drive, and a drive is forgotten after a second") {
  Camera700 camera;
  double driven_m = 0, aside_m = 0;
  const auto move = [&](int frames, bool ahead) {
    for (int k = 0; k < frames; ++k) {
      (ahead ? driven_m : aside_m) += kSpeed_mps / kRate_hz / (ahead ? 1 : 4);
      std::vector<Seen> points = road(driven_m, driven_m);
      for (Seen& p : points) p.at_m.x -= aside_m;
      camera.see(points);
    }
  };
  move(kDrive, true);
  REQUIRE(camera.dynamic(kFirstOfCar, kEnd) >= 28);  // the car comes
  move(kSecond, false);
  REQUIRE(camera.dynamic(0, kEnd) <= 4);
  move(4, true);
  CHECK(camera.dynamic(0, kEnd) <= 4);
}

}  // namespace flow_consistency_expiry_test
