// SPDX-License-Identifier: MIT
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <dynfilter/filters/semantic_mask.hpp>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"
#include "grid_scene.hpp"

namespace semantic_mask_test {

using namespace dynfilter;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

SemanticMaskParams rejecting(double dilate_px = 0) {
  SemanticMaskParams params;
  params.role = SemanticRole::Reject;
  params.dilate_px = dilate_px;
  return params;
}
Votes apply(const FrameView& frame, const SemanticMaskParams& params, FrameEvidence& evidence) {
  SemanticMaskFilter filter(params);
  return votes_of(filter, evidence, frame);
}
Votes apply(const FrameView& frame, const SemanticMaskParams& params) {
  FrameEvidence evidence;
  return apply(frame, params, evidence);
}
/// 110 x 110 with `label` in a rectangle.
cv::Mat mask_with(const cv::Rect& place, int label = 255) {
  cv::Mat mask = cv::Mat::zeros(110, 110, CV_8UC1);
  mask(place).setTo(label);
  return mask;
}
FrameView with_mask(const GridScene& scene, const cv::Mat& mask, std::int64_t id = 0) {
  FrameView frame = scene.view(id);
  frame.detections.reset();
  frame.grey = cv::Mat::zeros(110, 110, CV_8UC1);
  frame.mask = MaskInput{-1, mask};
  return frame;
}
std::size_t dynamic(const FrameView& frame, const SemanticMaskParams& params) {
  return apply(frame, params).count(Vote::Dynamic);
}

}  // namespace

TEST_CASE("near() is at() on the mask dilated with a disc, pixel by pixel") {
  cv::Mat mask = cv::Mat::zeros(60, 70, CV_8UC1);
  mask(cv::Rect(20, 25, 7, 3)).setTo(1);
  mask.at<std::uint8_t>(0, 69) = 200;
  mask.at<std::uint8_t>(59, 0) = 3;
  for (const int radius : {0, 1, 4, 9, 15}) {
    cv::Mat disc(2 * radius + 1, 2 * radius + 1, CV_8UC1), dilated;
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x)
        disc.at<std::uint8_t>(y + radius, x + radius) = x * x + y * y <= radius * radius ? 1 : 0;
    cv::dilate(mask, dilated, disc);
    const MaskLookup lookup(mask, mask.size());
    int different = 0;
    for (int y = 0; y < mask.rows; ++y)
      for (int x = 0; x < mask.cols; ++x)
        different += lookup.near({static_cast<float>(x), static_cast<float>(y)}, radius) !=
                     (dilated.at<std::uint8_t>(y, x) != 0);
    CHECK(different == 0);
  }
}

TEST_CASE("features on the mask are suspects or dynamic, the others unknown, or static where asked") {
  const GridScene scene;
  // x 20..50, y 30..50: 4 x 3 features.
  const FrameView frame = with_mask(scene, mask_with({20, 30, 31, 21}));
  SemanticMaskParams params = rejecting();
  CHECK(dynamic(frame, params) == 12);
  CHECK(apply(frame, params).count(Vote::Unknown) == 69);
  params.role = SemanticRole::Prior;
  CHECK(apply(frame, params).count_prior() == 12);
  CHECK(apply(frame, params).count(Vote::Dynamic) == 0);
}

TEST_CASE("dilation reaches dilate_px from the mask, and the margin is less suspicious") {
  const GridScene scene;
  const FrameView frame = with_mask(scene, mask_with({36, 36, 9, 9}));  // 36..44
  const Votes votes = apply(frame, rejecting(15));
  CHECK(votes[scene.at(40, 40)] == Vote::Dynamic);
  CHECK(votes[scene.at(50, 40)] == Vote::Dynamic);  // 6 px away
  CHECK(votes[scene.at(50, 50)] == Vote::Dynamic);  // 8.5
  CHECK(votes[scene.at(60, 40)] == Vote::Unknown);  // 16
  CHECK(votes.suspicion(scene.at(40, 40)) > votes.suspicion(scene.at(50, 40)));
  CHECK(votes.count(Vote::Dynamic) == 9);
}

TEST_CASE("labels choose among the classes of a label image") {
  const GridScene scene;
  cv::Mat labels = mask_with({15, 15, 10, 10}, 15);
  labels(cv::Rect(35, 15, 10, 10)).setTo(7);
  const FrameView frame = with_mask(scene, labels);
  SemanticMaskParams params = rejecting();
  CHECK(dynamic(frame, params) == 2);
  params.labels = {15};
  CHECK(apply(frame, params)[scene.at(20, 20)] == Vote::Dynamic);
  CHECK(dynamic(frame, params) == 1);
  // The other label is not used: only (20, 20) and features within 20 px of 15..24.
  params.dilate_px = 20;
  CHECK(apply(frame, params)[scene.at(50, 20)] == Vote::Unknown);
  params.labels = {300};
  CHECK_THROWS_AS(SemanticMaskFilter{params}, ConfigError);
}

TEST_CASE("a mask of another size covers the image all the same") {
  const GridScene scene;
  const cv::Mat full = mask_with({20, 30, 32, 22});
  for (const double scale : {0.5, 2.0}) {
    cv::Mat other;
    cv::resize(full, other, cv::Size(), scale, scale, cv::INTER_NEAREST);
    CHECK(dynamic(with_mask(scene, other), rejecting()) == 12);
    CHECK(dynamic(with_mask(scene, other), rejecting(9.6)) ==
          dynamic(with_mask(scene, full), rejecting(9.6)));
  }
  CHECK(dynamic(with_mask(scene, cv::Mat(1, 1, CV_8UC1, cv::Scalar(1))), rejecting()) == 81);
  for (const cv::Size size : {cv::Size(1241, 376), cv::Size(752, 480), cv::Size(320, 240)}) {
    FrameView frame = with_mask(scene, cv::Mat::zeros(size, CV_8UC1));
    frame.grey = cv::Mat::zeros(size, CV_8UC1);
    frame.mask->labels.at<std::uint8_t>(40, 60) = 1;
    CHECK(dynamic(frame, rejecting()) == 1);
  }
}

TEST_CASE("keypoints on the edge, beyond it, and nowhere read nothing out of bounds") {
  const float places[][2] = {{0, 0},    {109, 109}, {110, 110}, {110, 50},  {-0.4F, 5},
                             {-50, 50}, {500, 500}, {kNan, 5},  {5, -kNan}, {1e30F, -1e30F}};
  std::vector<cv::KeyPoint> keypoints;
  for (const auto& place : places) keypoints.emplace_back(place[0], place[1], 1.0F);
  GridScene scene;
  scene.keypoints = keypoints;
  const FrameView frame = with_mask(scene, cv::Mat(110, 110, CV_8UC1, cv::Scalar(255)));
  CHECK(dynamic(frame, rejecting()) == 5);
  CHECK(dynamic(frame, rejecting(60)) == 6);  // (-50, 50) is 50 px from the image
}

TEST_CASE("masks of another type, empty ones and none at all leave everything unknown") {
  const GridScene scene;
  FrameEvidence evidence;
  const auto all_unknown = [&](const FrameView& frame, const SemanticMaskParams& params) {
    return apply(frame, params, evidence).count(Vote::Unknown) == frame.size();
  };
  const SemanticMaskParams params = rejecting();
  CHECK(all_unknown(with_mask(scene, cv::Mat(110, 110, CV_32FC1, cv::Scalar(1))), params));
  CHECK(evidence.input_notes() == std::vector<std::string>{"mask cannot be used: wrong size or type"});
  CHECK(all_unknown(with_mask(scene, cv::Mat(110, 110, CV_8UC3, cv::Scalar::all(1))), params));
  CHECK(all_unknown(with_mask(scene, cv::Mat()), params));
  FrameView frame = scene.view();
  frame.detections.reset();
  CHECK(all_unknown(frame, params));
  for (std::size_t n : {0U, 1U, 2U}) {
    GridScene few;
    few.keypoints.resize(n);
    CHECK(dynamic(with_mask(few, cv::Mat(110, 110, CV_8UC1, cv::Scalar(1))), rejecting()) == n);
  }
}

TEST_CASE("a late mask is held against where the features were, lost ones go with the others") {
  const GridScene before;
  GridScene now = before;
  for (cv::KeyPoint& keypoint : now.keypoints) keypoint.pt += cv::Point2f(40, 0);
  std::vector<std::int32_t> index = GridScene::same();
  index[now.at(20, 30)] = -1;
  const cv::Mat mask = mask_with({20, 30, 31, 21});
  FrameEvidence evidence;
  apply(with_mask(before, mask, 0), rejecting(), evidence);
  evidence.end(false);
  FrameView frame = with_mask(now, mask, 1);
  frame.matches = HostMatches{0, index};
  frame.mask->frame_id = 0;
  const Votes votes = apply(frame, rejecting(), evidence);
  CHECK(votes.count(Vote::Dynamic) == 12);
  CHECK(votes[now.at(20, 30)] == Vote::Dynamic);
  CHECK(votes[now.at(60, 30)] == Vote::Unknown);

  SemanticMaskParams params = rejecting();
  params.max_age_frames = 0;
  CHECK(apply(frame, params, evidence).count(Vote::Dynamic) == 0);
  frame.mask->frame_id = 7;  // in the future
  CHECK(apply(frame, rejecting(), evidence).count(Vote::Dynamic) == 0);
  frame.mask->frame_id = 0;
  evidence.reset();
  const Votes forgotten = apply(frame, rejecting(), evidence);
  CHECK(forgotten.count(Vote::Dynamic) == 0);
  CHECK(forgotten.notes() == "masks of frame 0, which is not kept");
}

TEST_CASE("instance masks: classes, scores, and masks that are none") {
  GridScene scene;
  const auto instance = [](const cv::Mat& mask, const char* name, float score) {
    Detection d = GridScene::detection(0, 0, 100, 100, name, score);
    d.mask = mask;
    return d;
  };
  scene.boxes = {instance(mask_with({15, 15, 10, 10}), "person", 0.9F),
                 instance(mask_with({35, 15, 10, 10}), "tv", 0.9F),
                 instance(mask_with({55, 15, 10, 10}), "person", 0.1F),
                 instance(mask_with({75, 15, 10, 10}), "person", kNan),
                 instance(cv::Mat(110, 110, CV_32FC1, cv::Scalar(1)), "person", 0.9F),
                 instance(cv::Mat(), "person", 0.9F)};
  FrameView frame = scene.view();
  frame.grey = cv::Mat::zeros(110, 110, CV_8UC1);
  SemanticMaskParams params = rejecting();
  params.source = MaskSource::Instances;
  const Votes votes = apply(frame, params);
  CHECK(votes.count(Vote::Dynamic) == 1);
  CHECK(votes[scene.at(20, 20)] == Vote::Dynamic);
  params.classes = {};
  CHECK(dynamic(frame, params) == 2);  // the person and the tv; a NaN score is not above 0.4
  scene.boxes = {GridScene::detection(0, 0, 100, 100)};
  CHECK(apply(scene.view(), params).count(Vote::Unknown) == 81);
}

}  // namespace semantic_mask_test
