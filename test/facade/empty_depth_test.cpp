// SPDX-License-Identifier: MIT
// Through the C and the C++11 interface, too, depths without a valid value are no depths.
#include <dynfilter/facade/dynfilter.h>
#include <dynfilter/facade/facade.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "doctest/doctest.h"
#include "support/layered_scene.hpp"

namespace empty_depth_test {

using dynfilter_test::LayeredFrame;
using dynfilter_test::LayeredScene;
namespace facade = dynfilter::facade;

namespace {

struct Outcome {
  std::vector<std::int8_t> decision;
  std::string note;  ///< of `first_available`
  bool operator==(const Outcome& o) const { return decision == o.decision && note == o.note; }
};

/// What one camera gives; with `filled` the depths and columns that it lacks are there, without a valid
/// value.
struct Frame {
  Frame(int k, bool filled) : layers(LayeredScene().frame(k)) {
    if (!filled) return;
    depths.assign(layers.size(), -1), columns = depths;
    depth = cv::Mat::zeros(layers.grey.size(), CV_16UC1);
  }
  LayeredFrame layers;
  std::vector<float> depths, columns;
  cv::Mat depth;
};

Outcome by_cxx11(facade::DynFilter& filter, const Frame& from) {
  facade::Frame frame;
  frame.id = from.layers.id, frame.timestamp_s = from.layers.timestamp_s;
  frame.keypoints = from.layers.keypoints;
  frame.grey = from.layers.grey, frame.depth = from.depth;
  frame.depth_m = from.depths, frame.right_u_px = from.columns;
  frame.has_camera = true;
  frame.camera.fx_px = frame.camera.fy_px = LayeredScene::kFocal_px;
  frame.camera.cx_px = LayeredScene::kCentreX_px, frame.camera.cy_px = LayeredScene::kCentreY_px;
  frame.camera.baseline_fx_px_m = LayeredScene::kBaseline_px_m;
  facade::Verdicts verdicts;
  REQUIRE(filter.process(frame, facade::CallPoint::BeforePose, verdicts));
  return {verdicts.decision, filter.reports()[3].note};
}

Outcome by_c(dynfilter_filter* filter, const Frame& from) {
  std::vector<dynfilter_keypoint> keypoints;
  for (const cv::KeyPoint& k : from.layers.keypoints)
    keypoints.push_back({k.pt.x, k.pt.y, k.size, k.angle, k.response, k.octave});
  dynfilter_frame frame;
  dynfilter_frame_init(&frame);
  frame.id = from.layers.id, frame.timestamp_s = from.layers.timestamp_s;
  frame.keypoint_count = keypoints.size(), frame.keypoints = keypoints.data();
  frame.width_px = LayeredScene::kWidth, frame.height_px = LayeredScene::kHeight;
  frame.grey = from.layers.grey.data;
  if (!from.depths.empty()) {
    frame.depth_m = from.depths.data(), frame.right_u_px = from.columns.data();
    frame.depth = from.depth.data, frame.depth_type = DYNFILTER_DEPTH_U16, frame.depth_unit_m = 1e-3;
  }
  frame.has_camera = 1;
  frame.fx_px = frame.fy_px = LayeredScene::kFocal_px;
  frame.cx_px = LayeredScene::kCentreX_px, frame.cy_px = LayeredScene::kCentreY_px;
  frame.baseline_fx_px_m = LayeredScene::kBaseline_px_m;
  dynfilter_verdicts verdicts;
  REQUIRE(dynfilter_process(filter, &frame, DYNFILTER_BEFORE_POSE, &verdicts) == 0);
  dynfilter_stage_report report;
  REQUIRE(dynfilter_get_stage_report(filter, 3, &report, sizeof(report)) == 0);
  return {{verdicts.decision, verdicts.decision + verdicts.count}, report.note};
}

}  // namespace

TEST_CASE("one camera through the C and the C++11 interface: depths of -1 change nothing, and flow judges") {
  facade::DynFilter with, without;
  const std::string preset = DYNFILTER_SOURCE_DIR "/examples/pipelines/dynfilter.yaml";
  REQUIRE(with.load(preset));
  REQUIRE(without.load(preset));
  dynfilter_filter* c = dynfilter_create(preset.c_str(), nullptr, 0);
  REQUIRE(c != nullptr);
  int dynamic = 0;
  for (int k = 0; k < 5; ++k) {
    const Outcome expected = by_cxx11(without, Frame(k, false));
    CHECK((by_cxx11(with, Frame(k, true)) == expected));
    CHECK((by_c(c, Frame(k, true)) == expected));
    for (const std::int8_t decision : expected.decision) dynamic += decision > 0 ? 1 : 0;
    if (k > 2) CHECK(expected.note == "judged by flow_consistency (background_motion skipped: no depth)");
  }
  CHECK(dynamic > 0);
  dynfilter_destroy(c);
}

}  // namespace empty_depth_test
