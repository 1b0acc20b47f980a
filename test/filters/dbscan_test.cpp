// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/dbscan.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "doctest/doctest.h"

namespace dbscan_test {

using namespace dynfilter;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Features given as 3-D points before a camera, some of them dynamic by an earlier stage.
struct Cloud {
  std::vector<cv::KeyPoint> keypoints;
  std::vector<float> depth_m;
  std::vector<std::size_t> dynamic;
  Camera camera;

  Cloud() { camera.fx_px = camera.fy_px = 500, camera.cx_px = 320, camera.cy_px = 240; }
  void add(const cv::Point3f& p, bool moving) {
    if (moving) dynamic.push_back(keypoints.size());
    keypoints.emplace_back(320 + 500 * p.x / p.z, 240 + 500 * p.y / p.z, 1.0F);
    depth_m.push_back(p.z);
  }
  Votes votes(Filter& filter, std::int64_t id = 0) const {
    FrameEvidence evidence;
    FrameView frame;
    frame.id = id;
    frame.keypoints = keypoints;
    frame.depth_m = depth_m;
    frame.camera = camera;
    evidence.begin(frame, CallPoint::BeforePose);
    Votes votes;
    votes.reset(frame.size());
    for (const std::size_t i : dynamic) votes.cast(i, Vote::Dynamic);
    evidence.earlier_votes().learn(votes);
    votes.reset(frame.size());
    filter.apply(evidence, votes);
    return votes;
  }
};

/// Five dynamic features around (0, 0, 2), 5 cm apart.
Cloud person() {
  Cloud cloud;
  for (const cv::Point3f p : {cv::Point3f(0, 0, 2), cv::Point3f(0.05F, 0, 2), cv::Point3f(-0.05F, 0, 2),
                              cv::Point3f(0, 0.05F, 2), cv::Point3f(0, -0.05F, 2)})
    cloud.add(p, true);
  return cloud;
}

/// Two people of 120 features, half of them already dynamic, and a room.
Cloud room(float spread_m) {
  Cloud cloud;
  std::uint32_t state = 1;
  const auto uniform = [&] {
    state = state * 1664525U + 1013904223U;
    return static_cast<float>(state >> 8U) / 8388608.0F - 1;
  };
  for (int k = 0; k < 240; ++k) {
    const float x = k % 2 == 0 ? -0.8F : 0.8F;
    cloud.add({x + spread_m * uniform(), 2 * spread_m * uniform(), 2.5F + 0.3F * spread_m * uniform()},
              k % 4 < 2);
  }
  for (int k = 0; k < 100; ++k) cloud.add({2.5F * uniform(), 1.5F * uniform(), 4.5F}, false);
  return cloud;
}

}  // namespace

TEST_CASE("dbscan: what is within Eps of a core point goes, the rest is left unknown") {
  Cloud cloud = person();
  cloud.add({0.14F, 0.0F, 2}, false);      // 9 cm from a point of the cluster, 14 from its middle
  cloud.add({0.0F, 0.0F, 2.3F}, false);    // 30 cm behind
  cloud.add({1.0F, 0.0F, 2}, true);        // a lone dynamic feature
  cloud.add({1.05F, 0.0F, 2}, false);      // beside it
  cloud.add({0.02F, 0.02F, kNan}, false);  // no depth
  DbscanFilterParams params;
  params.eps_m = 0.1;
  DbscanFilter filter(params);
  const Votes votes = cloud.votes(filter);
  CHECK(votes[5] == Vote::Dynamic);
  CHECK(votes[6] == Vote::Unknown);
  CHECK(votes[8] == Vote::Unknown);
  CHECK(votes[9] == Vote::Unknown);
  CHECK(votes.count(Vote::Static) == 0);
  CHECK(votes.suspicion(5) == doctest::Approx(1 - 0.5 * 0.9).epsilon(0.01));
}

TEST_CASE("dbscan: without dynamic features, with one, with equal ones") {
  DbscanFilter filter;
  Cloud none;
  CHECK(none.votes(filter).size() == 0);
  for (int k = 0; k < 30; ++k) none.add({0, 0.01F * static_cast<float>(k), 2}, false);
  CHECK(none.votes(filter).count(Vote::Unknown) == 30);
  Cloud one = none;
  one.add({0, 0, 2}, true);
  CHECK(one.votes(filter).count(Vote::Dynamic) == 0);
  Cloud same;
  for (int k = 0; k < 20; ++k) same.add({0.3F, 0.2F, 2}, k < 10);
  CHECK(same.votes(filter).count(Vote::Dynamic) == 10);
  DbscanFilterParams params;
  params.adaptive = true;
  params.adaptive_min_points = 4;
  DbscanFilter adaptive(params);
  CHECK(same.votes(adaptive).count(Vote::Dynamic) == 10);  // no choice: eps_m and min_points apply
  CHECK_FALSE(adaptive.chosen());
}

TEST_CASE("dbscan: two people known by half go whole, the room stays") {
  DbscanFilter filter;
  const Votes votes = room(0.2F).votes(filter);
  int found = 0, wrong = 0;
  for (std::size_t i = 0; i < 240; ++i) found += i % 4 >= 2 && votes[i] == Vote::Dynamic ? 1 : 0;
  for (std::size_t i = 240; i < votes.size(); ++i) wrong += votes[i] == Vote::Dynamic ? 1 : 0;
  CHECK(found >= 110);
  CHECK(wrong == 0);
}

TEST_CASE("dbscan: adaptive parameters are chosen once, kept, and chosen again after a reset") {
  DbscanFilterParams params;
  params.adaptive = true;
  DbscanFilter filter(params);
  CHECK(person().votes(filter).size() == 5);  // too few to choose from
  CHECK_FALSE(filter.chosen());
  room(0.2F).votes(filter);
  REQUIRE(filter.chosen());
  const DbscanParams first = *filter.chosen();
  Cloud wide = room(0.35F);
  wide.votes(filter);
  CHECK(filter.chosen()->eps_m == first.eps_m);
  filter.reset();
  CHECK_FALSE(filter.chosen());
  wide.votes(filter);
  REQUIRE(filter.chosen());
  CHECK(filter.chosen()->eps_m > first.eps_m);
  filter.reset();
  room(6).votes(filter);  // neighbours are farther apart than 0.5 m
  CHECK_FALSE(filter.chosen());
}

TEST_CASE("dbscan: the order of the features does not matter") {
  const Cloud cloud = room(0.2F);
  Cloud reversed;
  for (std::size_t i = cloud.keypoints.size(); i-- > 0;) {
    const bool moving = std::find(cloud.dynamic.begin(), cloud.dynamic.end(), i) != cloud.dynamic.end();
    if (moving) reversed.dynamic.push_back(reversed.keypoints.size());
    reversed.keypoints.push_back(cloud.keypoints[i]);
    reversed.depth_m.push_back(cloud.depth_m[i]);
  }
  DbscanFilter filter;
  const Votes a = cloud.votes(filter), b = reversed.votes(filter);
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == b[a.size() - 1 - i]);
}

}  // namespace dbscan_test
