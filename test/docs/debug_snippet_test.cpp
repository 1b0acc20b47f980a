// SPDX-License-Identifier: MIT
// The page's answer to "nothing is rejected" names the input that could not be used.
#include <dynfilter/dynfilter.hpp>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "doctest/doctest.h"

TEST_CASE("docs/how-to/any_front_end.md: its debugging snippet prints that a grey image has three channels") {
  dynfilter::Pipeline pipeline(dynfilter::pipeline_from_text(
      "%YAML:1.0\n---\npipeline:\n  before_pose:\n    - epipolar\n", dynfilter::builtin_filters()));
  const std::vector<cv::KeyPoint> keypoints(20, cv::KeyPoint(10, 10, 31));
  dynfilter::FrameView view;
  view.keypoints = keypoints;
  view.grey = cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(90));
  const dynfilter::Verdict& verdict = pipeline.before_pose(view);
  std::ostringstream printed;
  std::streambuf* const before = std::cerr.rdbuf(printed.rdbuf());
#include "any_front_end_2.inc"
  std::cerr.rdbuf(before);
  CAPTURE(printed.str());
  CHECK(printed.str().find("note: grey cannot be used: wrong size or type\n") != std::string::npos);
}
