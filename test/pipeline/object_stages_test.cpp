// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/random.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <dynfilter/pipeline/compose.hpp>
#include <dynfilter/pipeline/detail/object_regions.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <limits>
#include <opencv2/imgproc.hpp>

#include <dynfilter/pipeline/cluster_expand.hpp>
#include <dynfilter/pipeline/depth_layers.hpp>
#include <dynfilter/pipeline/object_vote.hpp>

#include "doctest/doctest.h"
#include "fakes.hpp"

namespace object_stages_test {

using namespace dynfilter;
using fakes::Features;
using fakes::letters_of;
using fakes::says;

namespace {

Detection box(float x, float y, float w, float h, const char* name = "person", float score = 0.9F) {
  Detection d;
  d.box = {x, y, w, h};
  d.class_name = name;
  d.score = score;
  return d;
}
Pipeline pipeline_of(StagePtr root) {
  PipelineConfig config;
  config.floor.min_features = 0;
  config.before_pose = std::move(root);
  return Pipeline(std::move(config));
}
/// Features at (0, 0), (10, 10), ... and the votes of a stage on them.
std::string judge(const FrameView& frame, const ObjectVoteParams& params, const std::string& letters) {
  Pipeline pipeline = pipeline_of(object_vote(params, stage(says("a", letters))));
  return letters_of(pipeline.before_pose(frame));
}
std::string judge(const std::vector<Detection>& boxes, const ObjectVoteParams& params,
                  const std::string& letters) {
  const Features features(letters.size());
  FrameView frame = features.view();
  frame.detections = DetectionInput{-1, boxes};
  return judge(frame, params, letters);
}

}  // namespace

TEST_CASE("a share of the votes on a box decides for all of its features") {
  const std::vector<Detection> one{box(5, 5, 40, 40)};  // features 1 to 4
  ObjectVoteParams params;
  CHECK(judge(one, params, "UDDSUU") == "UDDDDU");  // 2 of 3
  CHECK(judge(one, params, "UDSSUU") == "USSSSU");
  // One vote is not enough: the stage's votes stay.
  CHECK(judge(one, params, "UDUUUU") == "UDUUUU");
  CHECK(judge(one, params, "DDDSUS") == "DDDDDS");  // of no object: kept
  params.others = OtherFeatures::Drop;
  CHECK(judge(one, params, "DDDSUS") == "UDDDDU");
  CHECK(judge(one, params, "DDUUUS") == "UUUUUU");
  params.min_count = 1;
  params.min_share = 0.25;
  CHECK(judge(one, params, "UDSSSU") == "UDDDDU");
  params.min_share = 0.26;
  CHECK(judge(one, params, "UDSSSU") == "USSSSU");
}

TEST_CASE("a feature of two boxes is dynamic if one of them moves; classes and scores choose the boxes") {
  const std::vector<Detection> two{box(5, 5, 20, 20, "person"), box(15, 15, 30, 30, "chair", 0.5F)};
  ObjectVoteParams params;
  CHECK(judge(two, params, "USDSSU") == "USSSSU");  // one vote of two wanted
  params.min_count = 1;
  // Person 1 of 2, chair 1 of 3: feature 2 is of both.
  CHECK(judge(two, params, "USDSSU") == "UDDSSU");
  params.min_count = 2;
  params.min_share = 0.6;
  CHECK(judge(two, params, "UDDSSU") == "UDDSSU");
  params.region.classes = {"chair"};
  CHECK(judge(two, params, "UDDSSU") == "UDSSSU");
  params.region.classes = {};
  params.region.except_classes = {"person"};
  CHECK(judge(two, params, "UDDSSU") == "UDSSSU");
  params.region.min_score = 0.6;
  CHECK(judge(two, params, "UDDSSU") == "UDDSSU");
}

TEST_CASE("boxes outside the image, empty, inverted and not finite are no objects") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Detection> odd{box(500, 500, 50, 50), box(25, 25, 0, 0),
                                   box(45, 45, -40, -40), box(kNan, 0, 99, 99),
                                   box(0, 0, kNan, 99),   box(5, 5, 40, 40, "person", kNan),
                                   box(-99, -99, 50, 50), box(1e38F, 0, 3e38F, 9)};
  ObjectVoteParams params;
  params.min_count = 1;
  params.region.min_score = 0;
  params.region.near_px = 10;
  CHECK(judge(odd, params, "UDSSSU") == "UDSSSU");
}

TEST_CASE("one vote within 15 px of the mask condemns all of it, not what is beside") {
  const Features features(8);
  FrameView frame = features.view();
  cv::Mat mask = cv::Mat::zeros(100, 100, CV_8UC1);
  mask(cv::Rect(28, 28, 15, 15)).setTo(255);  // 28 to 42: features 3 and 4
  mask(cv::Rect(58, 58, 5, 5)).setTo(7);      // feature 6
  frame.mask = MaskInput{-1, mask};
  ObjectVoteParams params;
  params.region.objects = ObjectSource::Mask;
  params.region.near_px = 15;
  params.min_count = 1;
  params.min_share = 0;
  params.others = OtherFeatures::Drop;
  CHECK(judge(frame, params, "SSDSSSSS") == "UUUDDUDU");  // feature 2 is 11 px off
  CHECK(judge(frame, params, "SDSSSSSS") == "UUUSSUSU");  // 25 px
  params.region.objects = ObjectSource::Components;
  CHECK(judge(frame, params, "SSDSSSSS") == "UUUDDUSU");  // only the part that is near
  params.region.labels = {7};
  CHECK(judge(frame, params, "SSDSSSSD") == "UUUUUUDU");  // feature 7 is 11 px from the other one
  frame.mask.reset();
  CHECK(judge(frame, params, "SSDSSSSS") == "UUUUUUUU");
  params.others = OtherFeatures::Keep;
  CHECK(judge(frame, params, "SSDSSSSS") == "SSDSSSSS");
}

TEST_CASE("instance masks are objects; the report counts those that move, the reason is the vote") {
  const Features features(6);
  FrameView frame = features.view();
  Detection d = box(0, 0, 100, 100);
  d.mask = cv::Mat::zeros(50, 50, CV_8UC1);
  d.mask(cv::Rect(8, 8, 25, 25)).setTo(1);
  const std::vector<Detection> list{d, box(0, 0, 9, 9)};
  frame.detections = DetectionInput{-1, list};
  ObjectVoteParams params;
  params.region.objects = ObjectSource::Instances;
  Pipeline pipeline = pipeline_of(object_vote(params, stage(says("a", "SDDSSS"))));
  const Verdict& verdict = pipeline.before_pose(frame);
  CHECK(letters_of(verdict) == "SDDDSS");
  CHECK(verdict.report.stages[0].note == "1 of 2 objects move");
  CHECK(verdict.reason(1) == "object_vote+a");
  CHECK(verdict.reason(3) == "object_vote");
}

TEST_CASE("components of random masks are those of OpenCV") {
  Random random(3, 1);
  MaskComponents components;
  for (const int density : {20, 45, 60, 90}) {
    cv::Mat mask(37, 53, CV_8UC1), labels;
    for (int y = 0; y < mask.rows; ++y)
      for (int x = 0; x < mask.cols; ++x) mask.at<std::uint8_t>(y, x) = random.below(100) < density ? 9 : 0;
    const int count = cv::connectedComponents(mask, labels, 8) - 1;
    components.build(MaskLookup(mask, mask.size()));
    CHECK(components.count() == count);
    std::vector<int> twin(static_cast<std::size_t>(count) + 1, -1);
    int different = 0;
    for (int y = 0; y < mask.rows; ++y)
      for (int x = 0; x < mask.cols; ++x) {
        int own = -1;
        components.around({static_cast<float>(x), static_cast<float>(y)}, 0, [&](int c) { own = c; });
        const int label = labels.at<int>(y, x);
        different += (own < 0) != (label == 0);
        if (label == 0 || own < 0) continue;
        int& known = twin[static_cast<std::size_t>(label)];
        if (known < 0) known = own;
        different += known != own;
      }
    CHECK(different == 0);
  }
}

namespace {

/// Twelve features in a row, 20 px apart, with depths; a stage that says `letters` under `grow`.
struct Row {
  Row() : depth(100, 300, CV_32FC1, cv::Scalar(3)) {
    for (int i = 0; i < 12; ++i) keypoints.emplace_back(static_cast<float>(20 * i + 10), 50.0F, 1.0F);
    camera.fx_px = camera.fy_px = 300;
    camera.cx_px = 150;
    camera.cy_px = 50;
  }
  void paint(int first, int last, double z_m) { depth.colRange(20 * first, 20 * last + 20).setTo(z_m); }
  Verdict judge(StagePtr root) const {
    FrameView frame;
    frame.keypoints = keypoints;
    frame.depth = depth;
    frame.camera = camera;
    Pipeline pipeline = pipeline_of(std::move(root));
    return pipeline.before_pose(frame);
  }
  std::string expand(const ClusterExpandParams& params, const std::string& letters) const {
    return letters_of(judge(cluster_expand(params, stage(says("a", letters)))));
  }
  std::string layers(const DepthLayersParams& params, const std::string& letters) const {
    return letters_of(judge(depth_layers(params, stage(says("a", letters)))));
  }
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat depth;
  Camera camera;
};

}  // namespace

TEST_CASE("cluster_expand in 3-D stops where the next surface is, and where the static are more") {
  Row row;
  row.paint(3, 8, 1.5);  // 20 px are 0.1 m there, 0.2 m on the wall
  ClusterExpandParams params;
  params.radius_m = 0.21;
  params.min_neighbours = 1;
  params.rounds = 1;
  // Two to the right; left is the edge at 3.
  CHECK(row.expand(params, "UUUUDUUUUUUU") == "UUUDDDDUUUUU");
  params.rounds = 10;
  CHECK(row.expand(params, "UUUUDUUUUUUU") == "UUUDDDDDDUUU");
  params.min_share = 0.6;
  CHECK(row.expand(params, "UUUUDSSSSUUU") == "UUUUDSSSSUUU");  // 3: half of its neighbours
  params.min_share = 0.5;
  CHECK(row.expand(params, "UUUUDSSSSUUU") == "UUUDDDDDDUUU");  // and grown again
  params.min_neighbours = 2;
  CHECK(row.expand(params, "UUUUDUUUUUUU") == "UUUUDUUUUUUU");
  CHECK(row.expand(params, "UUUUUUUUUUUU") == "UUUUUUUUUUUU");
  row.depth.setTo(0);
  params.min_neighbours = 1;
  CHECK(row.expand(params, "UUUUDUUUUUUU") == "UUUUDUUUUUUU");
}

TEST_CASE("cluster_expand in the image needs no depth") {
  Row row;
  row.depth.setTo(0);
  ClusterExpandParams params;
  params.space = ExpandSpace::Image;
  params.radius_px = 25;
  params.min_neighbours = 2;
  params.rounds = 5;
  CHECK(row.expand(params, "UDUDSSUUUUUU") == "UDDDSSUUUUUU");
  for (cv::KeyPoint& keypoint : row.keypoints) keypoint.pt = {50, 50};  // all identical
  CHECK(row.expand(params, "UDDDUUUUUUUS") == "DDDDDDDDDDDD");
  row.keypoints[0].pt = {std::numeric_limits<float>::quiet_NaN(), 1e30F};
  CHECK(row.expand(params, "UDDDUUUUUUUS") == "UDDDDDDDDDDD");
}

TEST_CASE("cluster_expand over the depth image ends at its jumps and at its reach") {
  Row row;
  row.paint(3, 8, 1.5);
  ClusterExpandParams params;
  params.space = ExpandSpace::Depth;
  params.max_reach_m = 0;
  const Verdict verdict = row.judge(cluster_expand(params, stage(says("a", "UUUUDSUUUUUU"))));
  CHECK(letters_of(verdict) == "UUUDDDDDDUUU");
  CHECK(verdict.report.stages[0].note == "5 features added");
  CHECK(verdict.reason(5) == "cluster_expand");
  params.max_reach_m = 0.25;  // of 0.1 m from feature to feature
  CHECK(row.expand(params, "UUUUDUUUUUUU") == "UUUDDDDUUUUU");
  row.keypoints[11].pt = {300, 100};
  row.keypoints[0].pt = {-1e9F, std::numeric_limits<float>::infinity()};
  CHECK(row.expand(params, "DUUUDUUUUUUD").substr(3, 4) == "DDDD");
}

TEST_CASE("depth_layers fills large layers up and lets small ones go") {
  Row row;
  row.paint(2, 8, 1.5);
  row.paint(5, 5, 2.2);  // something behind the object
  row.paint(10, 10, 1.5);
  DepthLayersParams params;
  params.min_points = 3;
  params.margin_px = 25;
  // Layer 1.5 m: 2, 3, 7; from 1 to 8 in the image. 2.2 m (5) and 3 m (0) are single points.
  CHECK(row.layers(params, "DUDDUDSDUUUU") == "UUDDDUDDDUUU");
  params.min_points = 1;  // 1 is within 25 px of 0 and at the same depth, so it is included
  CHECK(row.layers(params, "DUDDUDSDUUUU") == "DDDDDDDDDUUU");
  params.max_gap_m = 2;  // one layer of all
  CHECK(row.layers(params, "DUDDUDSDUUUU") == "DDDDDDDDDUUU");
  params.max_gap_m = 0.2;
  params.min_share = 0.5;
  CHECK(row.layers(params, "DUDDUDSDUUUU") == "UUDDDUDDDUUU");  // 3 of 5
  CHECK(row.layers(params, "UUUSUUUUUUUU") == "UUUSUUUUUUUU");
  row.depth.colRange(60, 80).setTo(0);  // 3 has no depth now: it keeps its vote
  CHECK(row.layers(params, "UUUDUUUUUUUU") == "UUUDUUUUUUUU");
}

TEST_CASE("the order of the features does not matter to what stages make of them") {
  Row row, turned;
  row.paint(3, 8, 1.5);
  turned.paint(3, 8, 1.5);
  std::reverse(turned.keypoints.begin(), turned.keypoints.end());
  for (const std::string letters : {"UUUUDUUUUUUU", "DUDDUDSDUUUU", "SDDUUDDSSUDU"}) {
    const std::string back(letters.rbegin(), letters.rend());
    ClusterExpandParams expand;
    expand.radius_m = 0.21;
    expand.min_neighbours = 1;
    DepthLayersParams layers;
    layers.min_points = 2;
    std::string a = turned.expand(expand, back), b = turned.layers(layers, back);
    std::reverse(a.begin(), a.end());
    std::reverse(b.begin(), b.end());
    CHECK(row.expand(expand, letters) == a);
    CHECK(row.layers(layers, letters) == b);
  }
}

}  // namespace object_stages_test
