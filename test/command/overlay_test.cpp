// SPDX-License-Identifier: MIT
// What a picture says at a glance: what slides along an edge is a dash along it, what counts less is darker.
#include <cmath>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"
#include "running/overlay.hpp"

namespace overlay_test {

using namespace dynfilter;
using command::MarkedFeature;

namespace {

constexpr int kTitle_px = 28;  ///< above the picture, which is drawn at one and a half times its size

/// Green of the pixel at an offset from a feature of a black picture, without the legend.
int green(const MarkedFeature& feature, cv::Point off_px) {
  command::OverlayFrame frame;
  frame.colour = cv::Mat(100, 200, CV_8UC3, cv::Scalar(0, 0, 0));
  frame.features = {feature};
  const cv::Mat drawn = command::Overlay().draw(frame);
  const cv::Point at(cvRound(feature.pixel.x * 1.5F), cvRound(feature.pixel.y * 1.5F) + kTitle_px);
  return drawn.at<cv::Vec3b>(at + off_px)[1];
}

}  // namespace

TEST_CASE("overlay: a kept feature that slides along an edge is a dash along it") {
  MarkedFeature corner{{60, 40}, Vote::Static, false, 0}, across = corner, down = corner;
  across.edge = {1, 0};
  down.edge = {0, 1};
  CHECK(green(corner, {0, 0}) == 220);
  CHECK(green(corner, {6, 0}) == 0);
  CHECK(green(across, {6, 0}) == 220);
  CHECK(green(across, {-6, 0}) == 220);
  CHECK(green(across, {0, 6}) == 0);
  CHECK(green(down, {0, 6}) == 220);
  CHECK(green(down, {6, 0}) == 0);
}

TEST_CASE("overlay: the smaller a weight, the darker the dot, but never dark") {
  MarkedFeature feature{{60, 40}, Vote::Static, false, 0};
  int last = 255;
  for (const float weight : {1.0F, 0.5F, 0.1F, 0.0F}) {
    feature.weight = weight;
    const int seen = green(feature, {0, 0});
    CHECK(seen < last);
    last = seen;
  }
  CHECK(last >= 220 / 3);
}

}  // namespace overlay_test
