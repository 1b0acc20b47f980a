// SPDX-License-Identifier: MIT
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/floor.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>

#include "doctest/doctest.h"
#include "fakes.hpp"

namespace floor_test {

using namespace dynfilter;
using fakes::Features;
using fakes::letters_of;

namespace {

Verdict all_dynamic(const std::vector<float>& suspicion) {
  Verdict verdict;
  const std::size_t n = suspicion.size();
  verdict.decision.assign(n, Vote::Dynamic);
  verdict.suspicion = suspicion;
  verdict.restored.assign(n, 0);
  verdict.reasons.assign(n, 1);
  return verdict;
}

FloorParams nothing() {
  FloorParams params;
  params.min_features = 0;
  return params;
}

}  // namespace

TEST_CASE("the least suspicious come back first, as unknown, and just enough of them") {
  FloorParams params = nothing();
  params.min_features = 2;
  Verdict verdict = all_dynamic({0.9F, 0.6F, 1.0F, 0.7F});
  Floor(params).apply(Features(4).view(), 0, verdict);
  CHECK(letters_of(verdict) == "DUDU");
  CHECK(verdict.report.restored == 2);
  CHECK(verdict.restored == std::vector<std::uint8_t>{0, 1, 0, 1});
  CHECK(verdict.report.notes == std::vector<std::string>{"floor: 2 features restored"});
}

TEST_CASE("the floor does nothing where enough is kept") {
  FloorParams params = nothing();
  params.min_features = 1;
  Verdict verdict = all_dynamic({0.9F, 0.6F});
  verdict.decision[0] = Vote::Unknown;
  Floor(params).apply(Features(2).view(), 0, verdict);
  CHECK(letters_of(verdict) == "UD");
  CHECK(verdict.report.notes.empty());
}

TEST_CASE("a share is rounded up, and more than there is cannot be restored") {
  FloorParams params = nothing();
  params.min_share = 0.3;
  Verdict verdict = all_dynamic({0.9F, 0.6F, 0.8F, 0.7F});  // 0.3 * 4 = 1.2
  Floor(params).apply(Features(4).view(), 0, verdict);
  CHECK(verdict.kept() == 2);
  params.min_features = 100;
  verdict = all_dynamic({0.9F, 0.6F});
  Floor(params).apply(Features(2).view(), 0, verdict);
  CHECK(verdict.kept() == 2);
}

TEST_CASE("restore_all brings everything back once the floor is reached") {
  FloorParams params = nothing();
  params.min_features = 1;
  params.restore_all = true;
  Verdict verdict = all_dynamic({0.9F, 0.6F, 0.8F});
  Floor(params).apply(Features(3).view(), 0, verdict);
  CHECK(verdict.kept() == 3);
}

TEST_CASE("coverage: each grid cell that holds features gets its least suspicious one") {
  FloorParams params = nothing();
  params.min_grid_coverage = 1;
  params.grid_columns = params.grid_rows = 2;
  const Features features(4);  // at 0, 10, 20, 30: two in the first cell, two in the last
  FrameView frame = features.view();
  frame.grey = cv::Mat::zeros(40, 40, CV_8UC1);
  Verdict verdict = all_dynamic({0.9F, 0.6F, 0.7F, 0.8F});
  Floor(params).apply(frame, 0, verdict);
  CHECK(letters_of(verdict) == "DUUD");
}

TEST_CASE("coverage without an image: the grid covers the extent of the features, in both directions") {
  FloorParams params = nothing();
  params.min_grid_coverage = 1;
  for (const bool upright : {true, false}) {
    CAPTURE(upright);
    params.grid_columns = upright ? 1 : 2;
    params.grid_rows = upright ? 2 : 1;
    Features features(4);  // 0, 10 | 20, 30: the middle of [0, 31) is between them
    for (cv::KeyPoint& keypoint : features.keypoints) (upright ? keypoint.pt.x : keypoint.pt.y) = 5;
    Verdict verdict = all_dynamic({0.9F, 0.6F, 0.7F, 0.8F});
    Floor(params).apply(features.view(), 0, verdict);
    CHECK(letters_of(verdict) == "DUUD");
  }
}

// The last feature is at 30: the extent is [0, 31), and its middle 15.5.
TEST_CASE("coverage without an image: the extent ends one pixel after the last feature") {
  FloorParams params = nothing();
  params.min_grid_coverage = 1;
  for (const bool upright : {true, false}) {
    CAPTURE(upright);
    params.grid_columns = upright ? 1 : 2;
    params.grid_rows = upright ? 2 : 1;
    Features features(4);
    const float places[] = {0, 15, 15.75F, 30};
    for (std::size_t i = 0; i < 4; ++i)
      features.keypoints[i].pt = upright ? cv::Point2f(5, places[i]) : cv::Point2f(places[i], 5);
    Verdict verdict = all_dynamic({0.9F, 0.6F, 0.7F, 0.8F});
    Floor(params).apply(features.view(), 0, verdict);
    CHECK(letters_of(verdict) == "DUUD");
  }
}

TEST_CASE("coverage: rows and columns are different cells, and a share of them is rounded up") {
  FloorParams params = nothing();
  params.grid_columns = params.grid_rows = 2;
  Features features(4);
  features.keypoints[0].pt = {5, 5}, features.keypoints[1].pt = {35, 5};
  features.keypoints[2].pt = {5, 35}, features.keypoints[3].pt = {35, 35};
  FrameView frame = features.view();
  frame.grey = cv::Mat::zeros(40, 40, CV_8UC1);
  const auto restored = [&](double coverage) {
    params.min_grid_coverage = coverage;
    Verdict verdict = all_dynamic({0.6F, 0.7F, 0.8F, 0.9F});
    Floor(params).apply(frame, 0, verdict);
    return letters_of(verdict);
  };
  CHECK(restored(1) == "UUUU");
  CHECK(restored(0.3) == "UUDD");  // 1.2 of four cells
  CHECK(restored(0.2) == "UDDD");
}

TEST_CASE("coverage: a cell that keeps a feature gets no other one, however little that is suspected") {
  FloorParams params = nothing();
  params.min_grid_coverage = 1;
  params.grid_columns = params.grid_rows = 2;
  const Features features(4);  // at 0, 10 | 20, 30
  FrameView frame = features.view();
  frame.grey = cv::Mat::zeros(40, 40, CV_8UC1);
  Verdict verdict = all_dynamic({0.1F, 0.1F, 0.7F, 0.8F});
  verdict.decision[0] = Vote::Static;
  Floor(params).apply(frame, 0, verdict);
  CHECK(letters_of(verdict) == "SDUD");
  CHECK(verdict.report.notes == std::vector<std::string>{"floor: 1 features restored"});
}

TEST_CASE("coverage restores only what is missing: cells that keep a feature need none") {
  FloorParams params = nothing();
  params.min_grid_coverage = 0.5;  // of the two occupied cells: one
  params.grid_columns = params.grid_rows = 2;
  Verdict verdict = all_dynamic({0.9F, 0.6F, 0.7F, 0.8F});
  Floor(params).apply(Features(4).view(), 0, verdict);
  CHECK(letters_of(verdict) == "DUDD");
  verdict = all_dynamic({0.9F, 0.6F, 0.7F, 0.8F});
  verdict.decision[0] = Vote::Static;
  Floor(params).apply(Features(4).view(), 0, verdict);
  CHECK(letters_of(verdict) == "SDDD");
  CHECK(verdict.report.notes.empty());
}

TEST_CASE(
    "of equally suspicious features the topmost comes back first, then the leftmost, NaN as the corner") {
  FloorParams params = nothing();
  const auto first_of = [&](cv::Point2f a, cv::Point2f b) {
    params.min_features = 1;
    Features features(2);
    features.keypoints[0].pt = a, features.keypoints[1].pt = b;
    Verdict verdict = all_dynamic({0.9F, 0.9F});
    Floor(params).apply(features.view(), 0, verdict);
    return letters_of(verdict) == "UD" ? 0 : 1;
  };
  CHECK(first_of({30, 10}, {10, 20}) == 0);
  CHECK(first_of({10, 20}, {30, 10}) == 1);
  CHECK(first_of({30, 10}, {10, 10}) == 1);
  CHECK(first_of({10, 10}, {30, 10}) == 0);
  const float nan = std::nanf("");
  CHECK(first_of({10, 10}, {nan, 50}) == 1);
  CHECK(first_of({10, 10}, {50, nan}) == 1);
  CHECK(first_of({nan, 50}, {10, 10}) == 0);
}

TEST_CASE("no features, NaN positions and features outside of the image are no trouble") {
  FloorParams params = nothing();
  params.min_features = 5;
  params.min_grid_coverage = 1;
  Verdict none = all_dynamic({});
  Floor(params).apply(Features(0).view(), 0, none);
  CHECK(none.size() == 0);
  Features odd(3);
  odd.keypoints[0].pt = {std::nanf(""), -5};
  odd.keypoints[1].pt = {1e9F, 1e9F};
  FrameView frame = odd.view();
  frame.grey = cv::Mat::zeros(40, 40, CV_8UC1);
  Verdict verdict = all_dynamic({0.9F, 0.6F, 0.7F});
  Floor(params).apply(frame, 0, verdict);
  CHECK(verdict.kept() == 3);
}

}  // namespace floor_test
