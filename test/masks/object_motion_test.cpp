// SPDX-License-Identifier: MIT
#include "masks/object_motion.hpp"

#include <algorithm>
#include <functional>

#include "doctest/doctest.h"

using namespace dynfilter::masks;

namespace object_motion_test {

/// 10 images a second with 8 votes each, of which `dynamic(time)` are for motion.
ObjectTrack track(double seconds, const std::function<int(double)>& dynamic) {
  ObjectTrack out;
  for (int i = 0; i <= seconds * 10; ++i) {
    Sighting s;
    s.frame = static_cast<std::size_t>(i), s.time_s = i / 10.0;
    s.dynamic = dynamic(s.time_s), s.judged = 8;
    out.sightings.push_back(s);
  }
  return out;
}

TEST_CASE("half of the votes make an object move") {
  CHECK(is_mover(track(2, [](double) { return 4; })));
  CHECK(!is_mover(track(2, [](double) { return 3; })));
}

TEST_CASE("a few wrong votes do not make a parked car drive") {
  // In one image all are wrong: 8 of the 40 votes of half a second.
  CHECK(!is_mover(track(5, [](double t) { return t == 2.0 ? 8 : 0; })));
  // In three images they win a part of a second, but less than half a second.
  const ObjectTrack brief = track(5, [](double t) { return t > 1.95 && t < 2.25 ? 7 : 0; });
  const std::vector<bool> moving = moving_in(brief);
  CHECK(std::count(moving.begin(), moving.end(), true) >= 1);
  CHECK(!is_mover(brief));
  CHECK(is_mover(track(5, [](double t) { return t > 1.95 && t < 2.65 ? 7 : 0; })));
}

TEST_CASE("without votes, or with few, an object does not move") {
  ObjectTrack few = track(0.2, [](double) { return 1; });
  for (Sighting& s : few.sightings) s.judged = 1;
  CHECK(!is_mover(few));
  CHECK(!is_mover(ObjectTrack()));
  CHECK(masked_in(ObjectTrack(), 1.0).empty());
}

TEST_CASE("a mover is masked in all of its sightings, also before it moves") {
  const ObjectTrack late = track(4, [](double t) { return t > 3 ? 8 : 0; });
  const std::vector<bool> masked = masked_in(late);
  CHECK(std::count(masked.begin(), masked.end(), true) == 41);
}

TEST_CASE("with a time limit it is masked again when it moves again") {
  const ObjectTrack again = track(6, [](double t) { return t < 1 || t > 4 ? 8 : 0; });
  const std::vector<bool> masked = masked_in(again, 1.0);
  CHECK(masked[5]);
  CHECK(masked[19]);   // 1.9 s: it moved 1 s ago
  CHECK(!masked[25]);  // 2.5 s
  CHECK(!masked[35]);
  CHECK(masked[45]);
  const std::vector<bool> at_once = masked_in(again, 0.0);
  CHECK(at_once[5]);
  CHECK(!at_once[20]);
}

}  // namespace object_motion_test
