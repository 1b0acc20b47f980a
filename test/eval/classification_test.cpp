// SPDX-License-Identifier: MIT
#include <dynfilter/eval/classification.hpp>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"

using namespace dynfilter::eval;

TEST_CASE("the truth is read at the rounded pixel; outside nobody knows") {
  cv::Mat truth(4, 6, CV_8UC1, cv::Scalar(0));
  truth.at<std::uint8_t>(2, 3) = 255;
  truth.at<std::uint8_t>(2, 4) = 128;
  CHECK(truth_at(truth, {3.4F, 1.6F}) == Truth::Dynamic);
  CHECK(truth_at(truth, {3.6F, 2.0F}) == Truth::DontCare);
  CHECK(truth_at(truth, {2.4F, 2.0F}) == Truth::Static);
  CHECK(truth_at(truth, {-0.4F, 0.0F}) == Truth::Static);
  CHECK(truth_at(truth, {6.0F, 2.0F}) == Truth::DontCare);
  CHECK(truth_at(truth, {-0.6F, 2.0F}) == Truth::DontCare);
  CHECK(truth_at(truth, {NAN, 2.0F}) == Truth::DontCare);
  CHECK(truth_at(cv::Mat(), {0, 0}) == Truth::DontCare);
}

TEST_CASE("precision, recall and static kept of a counted case") {
  Classification c;
  for (int i = 0; i < 9; ++i) c.add(Truth::Dynamic, true);
  c.add(Truth::Dynamic, false);
  for (int i = 0; i < 3; ++i) c.add(Truth::Static, true);
  for (int i = 0; i < 12; ++i) c.add(Truth::Static, false);
  for (int i = 0; i < 100; ++i) c.add(Truth::DontCare, i % 2 == 0);
  Classification pooled;
  pooled.add(c);
  pooled.add(c);
  CHECK(pooled.recall() == doctest::Approx(0.9));
  CHECK(pooled.precision() == doctest::Approx(0.75));
  CHECK(pooled.static_kept() == doctest::Approx(0.8));
  CHECK(pooled.dont_care == 200);
  CHECK(std::isnan(Classification().recall()));
}
