// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "doctest/doctest.h"
#include "render/detector_model.hpp"

namespace detector_model_test {

using namespace dynfilter;
using namespace dynfilter::render;

namespace {

const std::vector<Detectable> kObjects{{0, "person"}, {0, "person"}, {62, "tv"}};

cv::Mat with_boxes(const cv::Rect& first, const cv::Rect& second, const cv::Rect& screen) {
  cv::Mat instance = cv::Mat::zeros(480, 640, CV_16UC1);
  instance(first).setTo(1);
  instance(second).setTo(2);
  instance(screen).setTo(3);
  return instance;
}

const cv::Mat kApart = with_boxes({50, 100, 120, 300}, {400, 80, 100, 320}, {250, 200, 80, 60});
const cv::Mat kOverlapping = with_boxes({200, 100, 120, 300}, {240, 200, 110, 200}, {20, 20, 80, 60});

DetectorFaults flawless() {
  DetectorFaults faults;
  faults.missed_share = faults.box_jitter = faults.score_noise = faults.merged_share = 0;
  return faults;
}

}  // namespace

TEST_CASE("without faults every object has the box of its pixels") {
  Random random(1);
  const auto found = DetectorModel(flawless()).detect(kApart, kObjects, random);
  REQUIRE(found.size() == 3);
  int people = 0;
  for (const Detection& d : found) {
    CHECK(d.score > 0.5F);
    if (d.class_name == "tv") {
      CHECK(d.class_id == 62);
      CHECK(d.box == cv::Rect2f(250, 200, 80, 60));
    } else {
      ++people;
      CHECK(d.class_id == 0);
      CHECK((d.box == cv::Rect2f(50, 100, 120, 300) || d.box == cv::Rect2f(400, 80, 100, 320)));
    }
  }
  CHECK(people == 2);
}

TEST_CASE("what is hardly visible is not found, an empty picture has nothing") {
  Random random(1);
  const DetectorModel model(flawless());
  CHECK(model.detect(cv::Mat::zeros(480, 640, CV_16UC1), kObjects, random).empty());
  CHECK(model.detect(with_boxes({0, 0, 10, 10}, {100, 0, 12, 12}, {300, 300, 50, 50}), kObjects, random)
            .size() == 1);
}

TEST_CASE("faults come at the rates asked for") {
  const DetectorFaults faults;
  const DetectorModel model(faults);
  int found = 0, pictures = 4000;
  double shift = 0;
  for (int i = 0; i < pictures; ++i) {
    Random random(9, static_cast<std::uint64_t>(i));
    for (const Detection& d : model.detect(kApart, kObjects, random)) {
      ++found;
      CHECK(d.score >= 0.26F);
      CHECK(d.score <= 0.99F);
      if (d.class_name == "tv") shift += std::pow(d.box.x - 250, 2);
    }
  }
  CHECK(found / (3.0 * pictures) == doctest::Approx(1 - faults.missed_share).epsilon(0.01));
  CHECK(std::sqrt(shift / pictures) == doctest::Approx(80 * faults.box_jitter).epsilon(0.1));
}

TEST_CASE("two people who overlap share a box now and then, people apart never") {
  DetectorFaults faults = flawless();
  faults.merged_share = 0.5;
  const DetectorModel model(faults);
  int merged = 0;
  for (int i = 0; i < 1000; ++i) {
    Random random(3, static_cast<std::uint64_t>(i));
    CHECK(model.detect(kApart, kObjects, random).size() == 3);
    const auto found = model.detect(kOverlapping, kObjects, random);
    if (found.size() == 3) continue;
    ++merged;
    CHECK(found.size() == 2);
    CHECK(std::any_of(found.begin(), found.end(),
                      [](const Detection& d) { return d.box == cv::Rect2f(200, 100, 150, 300); }));
  }
  CHECK(merged > 430);
  CHECK(merged < 570);
}

}  // namespace detector_model_test
