// SPDX-License-Identifier: MIT
#include <opencv2/core.hpp>

#include "doctest/doctest.h"
#include "eval/classification.hpp"

using namespace dynfilter::eval;

TEST_CASE("the truth is read at the rounded pixel; outside nobody knows") {
  cv::Mat truth(4, 6, CV_8UC1, cv::Scalar(0));
  truth.at<std::uint8_t>(2, 3) = 255;
  truth.at<std::uint8_t>(2, 4) = 128;
  CHECK(truth_at(truth, {3.4F, 1.6F}) == TruthPixel::Dynamic);
  CHECK(truth_at(truth, {3.6F, 2.0F}) == TruthPixel::DontCare);
  CHECK(truth_at(truth, {2.4F, 2.0F}) == TruthPixel::Static);
  CHECK(truth_at(truth, {-0.4F, 0.0F}) == TruthPixel::Static);
  CHECK(truth_at(truth, {6.0F, 2.0F}) == TruthPixel::DontCare);
  CHECK(truth_at(truth, {-0.6F, 2.0F}) == TruthPixel::DontCare);
  CHECK(truth_at(truth, {NAN, 2.0F}) == TruthPixel::DontCare);
  CHECK(truth_at(cv::Mat(), {0, 0}) == TruthPixel::DontCare);
}

TEST_CASE("precision, recall and static kept of a counted case") {
  Classification c;
  for (int i = 0; i < 9; ++i) c.add(TruthPixel::Dynamic, true);
  c.add(TruthPixel::Dynamic, false);
  for (int i = 0; i < 3; ++i) c.add(TruthPixel::Static, true);
  for (int i = 0; i < 12; ++i) c.add(TruthPixel::Static, false);
  for (int i = 0; i < 100; ++i) c.add(TruthPixel::DontCare, i % 2 == 0);
  Classification pooled;
  pooled.add(c);
  pooled.add(c);
  CHECK(pooled.recall() == doctest::Approx(0.9));
  CHECK(pooled.precision() == doctest::Approx(0.75));
  CHECK(pooled.static_kept() == doctest::Approx(0.8));
  CHECK(pooled.dont_care == 200);
  CHECK(std::isnan(Classification().recall()));
}
