// SPDX-License-Identifier: MIT
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/hosts/host_semantics.hpp>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "doctest/doctest.h"

namespace host_semantics_test {

using namespace dynfilter;

namespace {

cv::Mat mask_of(double value) {
  return cv::Mat(48, 64, CV_8UC1, cv::Scalar(value));
}
bool all_are(const cv::Mat& mask, double value) {
  return !mask.empty() && cv::countNonZero(mask != value) == 0;
}
FrameView judged(const HostSemantics& semantics) {
  FrameView view;
  semantics.add_to(view);
  return view;
}

}  // namespace

TEST_CASE("what is set for the next frame is a copy, for all its call points") {
  HostSemantics semantics;
  cv::Mat labels = mask_of(1), instance = mask_of(2);
  for (int frame = 0; frame < 3; ++frame) {
    labels.setTo(cv::Scalar(1)), instance.setTo(cv::Scalar(2));
    semantics.set_mask(labels, -1);
    Detection detection;
    detection.mask = instance;
    semantics.set_detections({detection}, -1);
    detection.mask.release();
    CHECK(has_sole_owner(labels));
    CHECK(has_sole_owner(instance));
    labels.setTo(cv::Scalar(0)), instance.setTo(cv::Scalar(0));
    semantics.begin({});
    for (int call = 0; call < 2; ++call) {
      const FrameView view = judged(semantics);
      REQUIRE((view.mask && view.detections && view.detections->detections.size() == 1));
      CHECK(all_are(view.mask->labels, 1));
      CHECK(all_are(view.detections->detections[0].mask, 2));
    }
  }
  semantics.begin({});  // nothing was set for this frame
  CHECK(!judged(semantics).mask);
  CHECK(!judged(semantics).detections);
}

TEST_CASE("masks that are given away are not copied") {
  HostSemantics semantics;
  std::vector<Detection> detections(1);
  detections[0].mask = mask_of(3);
  const std::uint8_t* const pixels = detections[0].mask.data;
  semantics.set_detections(std::move(detections), -1);
  semantics.begin({});
  CHECK(judged(semantics).detections->detections[0].mask.data == pixels);
}

}  // namespace host_semantics_test
