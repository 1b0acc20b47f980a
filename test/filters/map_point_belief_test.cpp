// SPDX-License-Identifier: MIT
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/map_point_belief.hpp>

#include "doctest/doctest.h"
#include "grid_scene.hpp"

namespace map_point_belief_test {

using namespace dynfilter;

namespace {

struct Points {
  FrameView view(std::int64_t id, bool masked) {
    FrameView frame = scene.view(id);
    frame.detections.reset();
    frame.map_point_ids = ids;
    frame.camera = Camera();  // provides the image size only
    frame.camera->width_px = frame.camera->height_px = 110;
    if (!mask.empty() && masked) frame.mask = MaskInput{-1, mask};
    return frame;
  }
  Vote judge(std::int64_t id, bool masked = true) {
    const Votes votes = votes_of(filter, evidence, view(id, masked));
    evidence.end(false);
    return votes[scene.at(50, 50)];
  }
  Points() {
    for (std::size_t i = 0; i < 81; ++i) ids[i] = static_cast<std::int64_t>(i);
    evidence.set_history(20);
  }
  GridScene scene;
  std::vector<std::int64_t> ids = std::vector<std::int64_t>(81);
  cv::Mat mask = cv::Mat(110, 110, CV_8UC1, cv::Scalar(255));
  MapPointBeliefFilter filter;
  FrameEvidence evidence;
};

}  // namespace

// From 0.5: n masks on and m off give odds of 9^(n - m).
TEST_CASE("beliefs are the product of the evidence, and are kept from frame to frame") {
  Points points;
  CHECK(points.judge(0, false) == Vote::Unknown);
  CHECK(points.judge(1) == Vote::Dynamic);
  CHECK(points.judge(2, false) == Vote::Dynamic);
  CHECK(points.judge(3) == Vote::Dynamic);
  points.mask.setTo(0);
  CHECK(points.judge(4) == Vote::Dynamic);  // 2 against 1
  CHECK(points.judge(5) == Vote::Unknown);
  CHECK(points.judge(6) == Vote::Static);
  points.filter.reset();
  CHECK(points.judge(7, false) == Vote::Unknown);
}

TEST_CASE("no belief is beyond recall, and what was not seen for long starts again") {
  Points points;
  for (int k = 0; k < 200; ++k) points.judge(k);
  points.mask.setTo(0);
  int frames = 0;
  while (points.judge(200 + frames) == Vote::Dynamic) ++frames;
  CHECK(frames <= 12);
  points.mask.setTo(255);
  for (int k = 0; k < 40; ++k) points.judge(300 + k);
  std::fill(points.ids.begin(), points.ids.end(), -1);
  for (int k = 0; k < 320; ++k) points.judge(400 + k, false);
  CHECK(points.judge(720, false) == Vote::Unknown);
  for (std::size_t i = 0; i < 81; ++i) points.ids[i] = static_cast<std::int64_t>(i);
  CHECK(points.judge(721, false) == Vote::Unknown);
}

TEST_CASE("features without a map point are unknown, the mask's size and the order do not matter") {
  Points points;
  points.mask = cv::Mat(11, 11, CV_8UC1, cv::Scalar(1));
  points.ids[points.scene.at(20, 20)] = -1;
  const FrameView frame = points.view(0, true);
  const Votes votes = votes_of(points.filter, points.evidence, frame);
  CHECK(votes.count(Vote::Dynamic) == 80);
  CHECK(votes[points.scene.at(20, 20)] == Vote::Unknown);
  for (const std::size_t n : {0U, 1U, 2U}) {
    Points few;
    few.scene.keypoints.resize(n);
    few.ids.resize(n);
    CHECK(votes_of(few.filter, few.evidence, few.view(0, true)).count(Vote::Dynamic) == n);
  }
}

}  // namespace map_point_belief_test
