// SPDX-License-Identifier: MIT
#include "masks/object_tracker.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"
#include "masks/clip.hpp"
#include "masks/object_motion.hpp"

using namespace dynfilter::masks;
using namespace dynfilter_test;

namespace object_tracker_test {

const Block kDriving{"car", {20, 20, 60, 40}, {3, 0}, 0, 1 << 20, {0, 0, 130}};
const Block kParked{"car", {40, 120, 60, 40}, {0, 0}, 0, 1 << 20, {130, 0, 0}};
/// Drives for 1 s, then stands.
const Block kStops{"car", {200, 120, 60, 40}, {2, 0}, 0, 10, {0, 130, 0}};

cv::Mat image_of(const RunMask& mask) {
  cv::Mat image = cv::Mat::zeros(kClipSize, CV_8UC1);
  mask.paint(image);
  return image;
}

TEST_CASE("one car drives, one is parked, one stops: each is one track with its exact mask") {
  const std::vector<ObjectTrack> tracks = tracks_of({kDriving, kParked, kStops}, 40);
  REQUIRE(tracks.size() == 3);
  const std::vector<Block> blocks{kDriving, kParked, kStops};
  for (std::size_t b = 0; b < 3; ++b) {
    CAPTURE(b);
    REQUIRE(tracks[b].sightings.size() == 40);
    for (int i = 0; i < 40; ++i) {
      const Sighting& s = tracks[b].sightings[static_cast<std::size_t>(i)];
      CHECK(s.frame == static_cast<std::size_t>(i));
      CHECK(!s.carried);
      CHECK(s.mask.box() == blocks[b].at(i));
      CHECK(s.mask.area() == blocks[b].at(i).area());
    }
  }
  CHECK(is_mover(tracks[0]));
  CHECK(!is_mover(tracks[1]));
  CHECK(is_mover(tracks[2]));
  const auto all = [](const std::vector<bool>& masked, bool value) {
    return std::count(masked.begin(), masked.end(), value) == 40;
  };
  CHECK(all(masked_in(tracks[0]), true));
  CHECK(all(masked_in(tracks[1]), false));
  CHECK(all(masked_in(tracks[2]), true));  // through the whole clip, not only while it moves
}

TEST_CASE("--until-static: a car that stands for a second is free until it moves again") {
  const std::vector<ObjectTrack> tracks = tracks_of({kStops}, 40);
  REQUIRE(tracks.size() == 1);
  const std::vector<bool> masked = masked_in(tracks[0], 1.0);
  // It moves up to 1.0 s. A sighting has the votes of 0.25 s on either side.
  for (std::size_t i = 0; i < 40; ++i) {
    const double time_s = static_cast<double>(i) / kClipRate_hz;
    CAPTURE(time_s);
    if (i < 20) CHECK(masked[i]);
    if (time_s >= 1.0 + 0.25 + 1.0) CHECK(!masked[i]);
  }
}

TEST_CASE("an object keeps its identity behind another, by its velocity and its colours") {
  Block fast = kDriving;
  fast.px_per_image = {8, 0};
  fast.hidden_from = 8, fast.hidden_to = 20;  // 96 px: further than it is looked for around its last place
  const std::vector<ObjectTrack> tracks = tracks_of({fast, kParked}, 30);
  REQUIRE(tracks.size() == 2);
  CHECK(tracks[0].sightings.size() == 18);
  CHECK(tracks[0].sightings[8].frame == 20);
  for (const Sighting& s : tracks[0].sightings) CHECK(s.mask.box() == fast.at(static_cast<int>(s.frame)));
}

TEST_CASE("another object at the place where one was hidden is not taken for it") {
  Block hidden = kDriving, other = kDriving;
  hidden.hidden_from = 12, hidden.hidden_to = 1 << 20;
  other.hidden_from = 0, other.hidden_to = 20;
  SUBCASE("other colours") {
    other.colour = {40, 40, 130};
  }
  SUBCASE("another class") {
    other.class_name = "person";
  }
  CHECK(tracks_of({hidden, other}, 40).size() == 2);
}

TEST_CASE("an object that is hidden for longer than two seconds is a new one") {
  Block hidden = kParked;
  hidden.hidden_from = 10, hidden.hidden_to = 34;
  CHECK(tracks_of({hidden}, 40).size() == 2);
}

TEST_CASE("where the detector misses an object that is there, its mask is carried") {
  ObjectTracker tracker;
  for (int i = 0; i < 12; ++i) {
    TrackedImage image = clip_image({kDriving}, i);
    if (i == 5 || i == 6) image.instances.clear();
    tracker.add(image);
  }
  const std::vector<ObjectTrack> tracks = tracker.finish();
  REQUIRE(tracks.size() == 1);
  REQUIRE(tracks[0].sightings.size() == 12);
  for (const std::size_t i : {std::size_t{5}, std::size_t{6}}) {
    const Sighting& s = tracks[0].sightings[i];
    CHECK(s.carried);
    CHECK(s.judged == 0);
    const cv::Rect truth = kDriving.at(static_cast<int>(i));
    CHECK(std::abs(s.mask.box().x - truth.x) <= 1);
    CHECK(s.mask.box().size() == truth.size());
  }
}

TEST_CASE("features beside another object do not vote") {
  Block wall = kParked, person = kDriving;
  person.class_name = "person";
  person.at_start = wall.at_start + cv::Point(wall.at_start.width, 0);  // it touches
  person.px_per_image = {0, 0};
  TrackedImage first = clip_image({wall, person}, 0), second = clip_image({wall, person}, 1);
  ObjectTracker tracker;
  tracker.add(first), tracker.add(second);
  const std::vector<ObjectTrack> tracks = tracker.finish();
  REQUIRE(tracks.size() == 2);
  int inside = 0, clear = 0;
  for (const JudgedFeature& f : second.features) {
    const cv::Rect box = wall.at_start;
    const cv::Point p(f.keypoint.pt);
    const bool in = p.x >= box.x + 2 && p.x < box.br().x - 2 && p.y >= box.y + 2 && p.y < box.br().y - 2;
    inside += in ? 1 : 0;
    clear += in && p.x < box.br().x - 12 ? 1 : 0;
  }
  REQUIRE(clear < inside);
  CHECK(tracks[0].sightings[1].judged == clear);
}

}  // namespace object_tracker_test
