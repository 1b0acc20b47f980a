// SPDX-License-Identifier: MIT
// A late instance mask, given again with the next frames, each time in another buffer. The host fills its
// memory with garbage and frees it after each call. test/fuzz does the same with all arrays and every preset.
#include <dynfilter/facade/dynfilter.h>
#include <cstdint>
#include <dynfilter/facade/facade.hpp>
#include <opencv2/core.hpp>
#include <vector>

#include "doctest/doctest.h"
#include "fuzz/lent_memory.hpp"

namespace facade_memory_test {

using namespace dynfilter;
using fuzz::Host;
using fuzz::LentMemory;

namespace {

constexpr int kWidth = 640, kHeight = 480, kFrames = 6, kFeatures = 50;
constexpr const char* kPipeline =
    "pipeline:\n  before_pose:\n    - semantic_mask: { source: instances, role: reject, dilate_px: 0 }\n"
    "  floor: { min_features: 0, min_share: 0 }\n";
const cv::Rect kBox(100, 100, 200, 250);

float column_px(int feature) {
  return 20.0F + 10.0F * static_cast<float>(feature);
}
/// Row 200 crosses the box; its left half is on the mask.
constexpr float kRow_px = 200;

cv::Mat half_mask() {
  cv::Mat mask = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  mask(cv::Rect(kBox.x, kBox.y, kBox.width / 2, kBox.height)).setTo(cv::Scalar(1));
  return mask;
}

/// Rejected features per frame. The result of frame 0 comes with all later frames.
std::vector<std::size_t> rejected_in_c(std::uint8_t garbage) {
  dynfilter_filter* filter = dynfilter_create_from_text(kPipeline, nullptr, 0);
  REQUIRE(filter != nullptr);
  std::vector<std::size_t> rejected;
  for (int k = 0; k < kFrames; ++k) {
    LentMemory memory(Host::Frees, garbage);
    dynfilter_frame frame;
    dynfilter_frame_init(&frame);
    frame.id = k, frame.timestamp_s = k / 30.0;
    std::vector<dynfilter_keypoint> keypoints;
    for (int i = 0; i < kFeatures; ++i) keypoints.push_back({column_px(i), kRow_px, 31, 0, 1, 0});
    frame.keypoints = memory.array(keypoints.data(), keypoints.size());
    frame.keypoint_count = keypoints.size();
    frame.width_px = kWidth, frame.height_px = kHeight;
    const cv::Mat grey = memory.image(cv::Mat::zeros(kHeight, kWidth, CV_8UC1));
    const cv::Mat mask = memory.image(half_mask());
    frame.grey = grey.data, frame.grey_stride_bytes = grey.step;
    dynfilter_box box{};
    box.x_px = 100, box.y_px = 100, box.width_px = 200, box.height_px = 250, box.score = 0.9F,
    box.track_id = -1;
    box.class_name = memory.text("person"), box.mask = mask.data, box.mask_stride_bytes = mask.step;
    frame.has_boxes = k > 0 ? 1 : 0, frame.box_count = 1, frame.boxes = memory.array(&box, 1);
    frame.boxes_frame_id = 0;
    dynfilter_verdicts verdicts;
    REQUIRE(dynfilter_process(filter, &frame, DYNFILTER_BEFORE_POSE, &verdicts) == 0);
    memory.take_back();
    rejected.push_back(verdicts.rejected);
  }
  dynfilter_destroy(filter);
  return rejected;
}

std::vector<std::size_t> rejected_in_cxx11(Host host, std::uint8_t garbage) {
  facade::DynFilter filter;
  REQUIRE(filter.load_text(kPipeline));
  std::vector<std::size_t> rejected;
  for (int k = 0; k < kFrames; ++k) {
    LentMemory memory(host, garbage);
    facade::Frame frame;
    frame.id = k, frame.timestamp_s = k / 30.0;
    for (int i = 0; i < kFeatures; ++i) frame.keypoints.emplace_back(column_px(i), kRow_px, 31.0F);
    frame.grey = memory.image(cv::Mat::zeros(kHeight, kWidth, CV_8UC1));
    frame.has_boxes = k > 0, frame.boxes_frame_id = 0;
    frame.boxes.resize(1);
    frame.boxes[0].box = kBox, frame.boxes[0].class_name = "person", frame.boxes[0].score = 0.9F;
    frame.boxes[0].mask = memory.image(half_mask());
    facade::Verdicts verdicts;
    REQUIRE(filter.process(frame, facade::CallPoint::BeforePose, verdicts));
    frame = facade::Frame();
    CHECK(memory.take_back() == 0);
    rejected.push_back(verdicts.rejected);
  }
  return rejected;
}

}  // namespace

TEST_CASE("a late mask is read from the library's own memory") {
  // On the mask: 10 features from column 100 to 190; nothing moves, and without boxes nothing is rejected.
  const std::vector<std::size_t> expected{0, 10, 10, 10, 10, 10};
  CHECK((rejected_in_c(0x00) == expected));
  CHECK((rejected_in_c(0xff) == expected));
  for (const Host host : {Host::Frees, Host::Reuses}) {
    CHECK((rejected_in_cxx11(host, 0x00) == expected));
    CHECK((rejected_in_cxx11(host, 0xff) == expected));
  }
}

}  // namespace facade_memory_test
