// SPDX-License-Identifier: MIT
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/box_foreground.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <dynfilter/filters/semantic_box.hpp>
#include <limits>

#include "doctest/doctest.h"
#include "grid_scene.hpp"

namespace semantic_box_test {

using namespace dynfilter;
using Scene = GridScene;

namespace {

Votes apply(const FrameView& frame, const SemanticBoxParams& params, FrameEvidence& evidence) {
  SemanticBoxFilter filter(params);
  Votes votes;
  votes.reset(frame.size());
  evidence.begin(frame, CallPoint::BeforePose);
  filter.apply(evidence, votes);
  return votes;
}
Votes apply(const FrameView& frame, const SemanticBoxParams& params = {}) {
  FrameEvidence evidence;
  return apply(frame, params, evidence);
}
SemanticBoxParams rejecting() {
  SemanticBoxParams params;
  params.role = SemanticRole::Reject;
  return params;
}

}  // namespace

TEST_CASE("features in a box, its border included, are suspects or dynamic, the others unknown") {
  Scene scene;
  scene.boxes = {Scene::detection(20, 30, 30, 20)};  // x 20..50, y 30..50: 4 x 3 features
  const Votes prior = apply(scene.view());
  CHECK(prior.count_prior() == 12);
  CHECK(prior.count(Vote::Unknown) == 81);
  CHECK(prior.prior(scene.at(20, 30)));
  CHECK(prior.prior(scene.at(50, 50)));
  CHECK_FALSE(prior.prior(scene.at(60, 40)));
  const Votes reject = apply(scene.view(), rejecting());
  CHECK(reject.count(Vote::Dynamic) == 12);
  CHECK(reject.count(Vote::Unknown) == 69);
  CHECK(reject.count_prior() == 0);
}

TEST_CASE("class and score decide which boxes count") {
  Scene scene;
  scene.boxes = {Scene::detection(15, 15, 10, 10, "tv"), Scene::detection(35, 15, 10, 10, "dog"),
                 Scene::detection(55, 15, 10, 10, "person", 0.2F)};
  CHECK(apply(scene.view(), rejecting()).count(Vote::Dynamic) == 1);  // the dog at (40, 20)
  SemanticBoxParams params = rejecting();
  params.classes = {"tv"};
  CHECK(apply(scene.view(), params).count(Vote::Dynamic) == 1);  // at (20, 20)
  params.classes = {"person"};
  params.min_score = 0.1;
  CHECK(apply(scene.view(), params).count(Vote::Dynamic) == 1);
}

TEST_CASE("empty boxes, boxes outside of the image and NaN boxes hold nothing") {
  Scene scene;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  scene.boxes = {Scene::detection(25, 25, 0, 0), Scene::detection(500, 500, 50, 50),
                 Scene::detection(nan, 0, 100, 100), Scene::detection(60, 60, -20, -20)};
  CHECK(apply(scene.view(), rejecting()).count(Vote::Dynamic) == 0);
}

TEST_CASE("boxes of an older frame move with the features inside, or are dropped when too old") {
  Scene before;
  before.boxes = {Scene::detection(20, 30, 30, 20)};
  Scene now = before;
  for (cv::KeyPoint& keypoint : now.keypoints)
    keypoint.pt += cv::Point2f(40, 0);  // everything moved to the right
  std::vector<std::int32_t> index(81);
  for (int i = 0; i < 81; ++i) index[static_cast<std::size_t>(i)] = i;
  index[now.at(20, 30)] = -1;  // one feature inside is not found: it moves with the others

  FrameEvidence evidence;
  apply(before.view(0), rejecting(), evidence);
  evidence.end(false);
  FrameView frame = now.view(1);
  frame.matches = HostMatches{0, index};
  frame.detections = DetectionInput{0, before.boxes};
  const Votes votes = apply(frame, rejecting(), evidence);
  CHECK(votes.count(Vote::Dynamic) == 12);
  CHECK(votes[now.at(20, 30)] == Vote::Dynamic);
  CHECK(votes[now.at(60, 30)] == Vote::Unknown);

  SemanticBoxParams params = rejecting();
  params.max_age_frames = 0;
  CHECK(apply(frame, params, evidence).count(Vote::Dynamic) == 0);
}

TEST_CASE("refine: depth keeps the wall behind a person") {
  Scene scene;
  scene.boxes = {Scene::detection(15, 15, 60, 70)};
  FrameView frame = scene.view();
  frame.depth = cv::Mat(110, 110, CV_32FC1, cv::Scalar(3.5));    // the wall
  frame.depth(cv::Rect(30, 15, 30, 95)).setTo(cv::Scalar(1.8));  // the person, x 30..60
  SemanticBoxParams params = rejecting();
  params.refine = BoxRefinement::Depth;
  const Votes votes = apply(frame, params);
  CHECK(votes[scene.at(40, 40)] == Vote::Dynamic);
  CHECK(votes[scene.at(50, 70)] == Vote::Dynamic);
  CHECK(votes[scene.at(20, 40)] == Vote::Unknown);
  CHECK(votes[scene.at(70, 40)] == Vote::Unknown);
  frame.depth.setTo(cv::Scalar(2.0));  // one surface: the whole box is the person
  CHECK(apply(frame, params).count(Vote::Dynamic) == 6 * 7);
}

}  // namespace semantic_box_test
