// SPDX-License-Identifier: MIT
#include <dynfilter/facade/dynfilter.h>

#include <cstring>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/facade/facade.hpp>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <thread>
#include <vector>

#include "doctest/doctest.h"
#include "pipeline/whole_pixel_scene.hpp"

namespace facade_prepare_test {

namespace facade = dynfilter::facade;

const char* const kFlow =
    "pipeline:\n  correspondence: { flow: { engine: guided, window_px: 16, levels: 4 } }\n"
    "  before_pose: [ epipolar ]\n";

facade::Frame frame_of(int k) {
  const whole_pixel_scene::Frame scene(k);
  facade::Frame frame;
  frame.id = k, frame.timestamp_s = scene.view().timestamp_s;
  frame.keypoints.assign(scene.view().keypoints.begin(), scene.view().keypoints.end());
  frame.grey = scene.view().grey.clone();
  return frame;
}

dynfilter_frame c_frame(const facade::Frame& from, std::vector<dynfilter_keypoint>& keypoints) {
  dynfilter_frame frame;
  dynfilter_frame_init(&frame);
  frame.id = from.id, frame.timestamp_s = from.timestamp_s;
  keypoints.clear();
  for (const cv::KeyPoint& k : from.keypoints)
    keypoints.push_back({k.pt.x, k.pt.y, k.size, k.angle, k.response, k.octave});
  frame.keypoint_count = keypoints.size(), frame.keypoints = keypoints.data();
  frame.width_px = from.grey.cols, frame.height_px = from.grey.rows;
  frame.grey = from.grey.data, frame.grey_stride_bytes = from.grey.step;
  return frame;
}

TEST_CASE(
    "prepare through the C++11 and the C interface: verdicts as without it, and a note for another stamp") {
  facade::DynFilter without, with;
  REQUIRE(without.load_text(kFlow));
  CHECK_FALSE(with.prepare(cv::Mat(), 0));
  CHECK(with.error() == "no pipeline is loaded");
  REQUIRE(with.load_text(kFlow));
  const std::unique_ptr<dynfilter_filter, void (*)(dynfilter_filter*)> c(
      dynfilter_create_from_text(kFlow, nullptr, 0), dynfilter_destroy);
  for (int k = 0; k < 5; ++k) {
    const facade::Frame frame = frame_of(k);
    std::vector<dynfilter_keypoint> keypoints;
    dynfilter_frame in_c = c_frame(frame, keypoints);
    std::thread([&] {
      CHECK(with.prepare(frame.grey, frame.timestamp_s));
      CHECK(dynfilter_prepare(c.get(), &in_c) == 0);
    }).join();
    facade::Verdicts expected, verdicts;
    dynfilter_verdicts c_verdicts;
    REQUIRE(without.process(frame, facade::CallPoint::BeforePose, expected));
    REQUIRE(with.process(frame, facade::CallPoint::BeforePose, verdicts));
    REQUIRE(dynfilter_process(c.get(), &in_c, DYNFILTER_BEFORE_POSE, &c_verdicts) == 0);
    CHECK(verdicts.decision == expected.decision);
    CHECK(verdicts.suspicion == expected.suspicion);
    CHECK(std::memcmp(c_verdicts.decision, expected.decision.data(), expected.decision.size()) == 0);
    CHECK(verdicts.notes.empty());
    CHECK(std::string(c_verdicts.notes).empty());
  }
  const facade::Frame frame = frame_of(5);
  facade::Verdicts verdicts;
  CHECK(with.prepare(frame.grey, 77));
  REQUIRE(with.process(frame, facade::CallPoint::BeforePose, verdicts));
  REQUIRE(verdicts.notes.size() == 1);
  CHECK(verdicts.notes[0].find("prepare()") == 0);
}

TEST_CASE("prepare of the C interface refuses what it cannot read") {
  const std::unique_ptr<dynfilter_filter, void (*)(dynfilter_filter*)> c(
      dynfilter_create_from_text(kFlow, nullptr, 0), dynfilter_destroy);
  std::vector<dynfilter_keypoint> keypoints;
  const facade::Frame frame = frame_of(0);
  dynfilter_frame in_c = c_frame(frame, keypoints);
  CHECK(dynfilter_prepare(nullptr, &in_c) != 0);
  CHECK(dynfilter_prepare(c.get(), nullptr) != 0);
  in_c.grey_stride_bytes = 5;
  CHECK(dynfilter_prepare(c.get(), &in_c) != 0);
  CHECK(std::string(dynfilter_last_error(c.get())).find("grey_stride_bytes") != std::string::npos);
  in_c.grey_stride_bytes = 0, in_c.struct_size = 3;
  CHECK(dynfilter_prepare(c.get(), &in_c) != 0);
  CHECK(std::string(dynfilter_last_error(c.get())).find("struct_size") != std::string::npos);
}

}  // namespace facade_prepare_test
