// SPDX-License-Identifier: MIT
#include <dynfilter/semantic/box_masks.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <limits>

#include "doctest/doctest.h"
#include "render/sequence_renderer.hpp"

namespace box_masks_test {

using namespace dynfilter;

namespace {

/// A wall at 4 m, and a person of 20 x 60 pixels at 2 m in front of it.
const cv::Rect kPerson(40, 20, 20, 60);
cv::Mat room() {
  cv::Mat depth(100, 120, CV_16UC1, cv::Scalar(20000));
  depth(kPerson).setTo(10000);
  return depth;
}
constexpr double kUnit_m = 1 / 5000.0;

Detection person_box(const cv::Rect2f& box) {
  Detection detection;
  detection.box = box;
  detection.class_id = 0;
  detection.class_name = "person";
  detection.score = 0.9F;
  return detection;
}

cv::Mat mask_of(const cv::Mat& depth, const cv::Rect2f& box, double unit_m = kUnit_m,
                BoxMaskParams params = {}) {
  params.close_px = 0;
  std::vector<Detection> detections{person_box(box)};
  BoxMasks(params).add(detections, depth, unit_m);
  return detections[0].mask;
}

bool is(const cv::Mat& mask, const cv::Rect& expected) {
  cv::Mat wanted = cv::Mat::zeros(100, 120, CV_8UC1);
  wanted(expected).setTo(255);
  return mask.size() == wanted.size() && cv::countNonZero(mask != wanted) == 0;
}

}  // namespace

TEST_CASE("the mask of a box is the person, not the wall behind") {
  CHECK(is(mask_of(room(), {30, 10, 40, 80}), kPerson));
  CHECK(is(mask_of(room(), {41, 20, 18, 60}), kPerson));  // an arm beyond the box, within 5 % of it
  cv::Mat metres;
  room().convertTo(metres, CV_32FC1, kUnit_m);
  CHECK(is(mask_of(metres, {30, 10, 40, 80}, 1), kPerson));
}

TEST_CASE("what stands in front of the person is left out, and so is another person beside it") {
  cv::Mat depth = room();
  depth(cv::Rect(30, 75, 40, 15)).setTo(5000);  // a desk at 1 m over the feet
  CHECK(is(mask_of(depth, {30, 10, 40, 80}), {40, 20, 20, 55}));
  depth = room();
  depth(cv::Rect(65, 20, 10, 60)).setTo(9000);  // 1.8 m, does not touch
  CHECK(is(mask_of(depth, {35, 10, 40, 80}), kPerson));
}

TEST_CASE("holes are closed; without depth in the box there is no mask") {
  cv::Mat depth = room();
  depth(cv::Rect(48, 40, 3, 3)).setTo(0);
  std::vector<Detection> detections{person_box({30, 10, 40, 80})};
  BoxMasks().add(detections, depth, kUnit_m);
  CHECK(cv::countNonZero(detections[0].mask(kPerson)) == kPerson.area());
  CHECK(mask_of(cv::Mat::zeros(100, 120, CV_16UC1), {30, 10, 40, 80}).empty());
  cv::Mat odd(100, 120, CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  CHECK(mask_of(odd, {30, 10, 40, 80}, 1).empty());
}

TEST_CASE("odd boxes and depth of another kind") {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const cv::Rect2f& box : {cv::Rect2f(0, 0, 0, 10),
                                {500, 500, 10, 10},
                                {-90, -90, 50, 50},
                                {0, 0, inf, 10},
                                {nan, 0, 10, 10},
                                {10, 10, -5, -5}})
    CHECK(mask_of(room(), box).empty());
  CHECK(mask_of(room(), {-1000, -1000, 3000, 3000}).size() == cv::Size(120, 100));
  CHECK(mask_of(cv::Mat(100, 120, CV_8UC1, cv::Scalar(9)), {30, 10, 40, 80}).empty());
  CHECK(mask_of(cv::Mat(), {30, 10, 40, 80}).empty());
}

TEST_CASE("only boxes that are wanted get a mask; one that is there stays") {
  std::vector<Detection> detections(4, person_box({30, 10, 40, 80}));
  detections[1].class_name = "tv";
  detections[2].score = 0.3F;
  detections[3].mask = cv::Mat(100, 120, CV_8UC1, cv::Scalar(255));
  detections[3].score = 0.5F;
  detections[3].class_id = 6;
  BoxMasks().add(detections, room(), kUnit_m);
  CHECK(!detections[0].mask.empty());
  CHECK(detections[1].mask.empty());
  CHECK(detections[2].mask.empty());
  CHECK(cv::countNonZero(detections[3].mask) == 12000);
  const cv::Mat labels = merged_masks(detections, {120, 100});
  // The higher score is on top.
  CHECK(cv::countNonZero(labels == 1) == cv::countNonZero(detections[0].mask));
  CHECK(cv::countNonZero(labels == 7) == 12000 - cv::countNonZero(detections[0].mask));
  detections[3].class_id = std::numeric_limits<int>::max();  // of a program, or a file: any number
  CHECK(cv::countNonZero(merged_masks(detections, {120, 100}) == 255) == cv::countNonZero(labels == 7));
}

namespace {

class Stub : public SemanticProvider {
 public:
  struct Params {
    static const FieldTable<Params>& fields() {
      static const FieldTable<Params> none;
      return none;
    }
  };
  static constexpr const char* kName = "stub";
  static constexpr const char* kSummary = "one person";
  explicit Stub(const Params& /*params*/) {}
  std::string name() const override { return kName; }
  std::optional<SemanticResult> infer(const SemanticImage& image) override {
    SemanticResult result;
    result.frame_id = image.frame_id;
    result.detections = {person_box({30, 10, 40, 80})};
    return result;
  }
};

}  // namespace

TEST_CASE("box_masks in a detector's YAML: masks where there is a depth image") {
  ProviderRegistry registry;
  registry.add<Stub>();
  const auto make = [&](const std::string& keys) {
    return read_detector(YamlDocument::from_text("detector: { type: stub" + keys + " }"), registry, {})
        .make();
  };
  SemanticImage image;
  image.frame_id = 5;
  image.pixels = cv::Mat::zeros(100, 120, CV_8UC3);
  const auto masked = make(", box_masks: { classes: [ person ] }");
  CHECK(masked->name() == "stub");
  CHECK(!masked->infer(image)->labels);
  image.depth = room();
  image.depth_unit_m = kUnit_m;
  const auto result = masked->infer(image);
  CHECK(result->frame_id == 5);
  REQUIRE(result->labels);
  CHECK(result->labels->at<std::uint8_t>(50, 50) == 1);
  CHECK(result->labels->at<std::uint8_t>(50, 35) == 0);
  CHECK(result->detections->at(0).mask.size() == cv::Size(120, 100));
  CHECK(!make("")->infer(image)->labels);
  CHECK_THROWS_WITH_AS(
      make(", box_masks: { class: [ a ] }"),
      "detector.box_masks: unknown key `class` (did you mean `classes`?); known keys: classes", ConfigError);
}

// A person behind another one in a shared box is missing.
// Objects that people carry belong to them.
TEST_CASE("rendered people: most of them is in the masks, and hardly anything that stands still") {
  render::SequenceOptions options;
  options.scene = "walking_static";
  options.frames = 40;
  options.detector.missed_share = options.detector.merged_share = 0;
  render::SequenceRenderer renderer(options);
  for (const int index : {5, 35}) {
    const render::RenderedFrame frame = renderer.frame(index);
    REQUIRE(frame.detections);
    std::vector<Detection> detections = *frame.detections;
    BoxMasks().add(detections, frame.depth, 1 / render::kDepthUnitsPerM);
    const cv::Mat mask = merged_masks(detections, frame.colour.size()) != 0, mover = frame.truth.labels != 0;
    cv::Mat boxes = cv::Mat::zeros(mask.size(), CV_8UC1);
    for (const Detection& d : detections)
      if (d.class_name == "person") boxes(cv::Rect(d.box)).setTo(255);
    const double people = cv::countNonZero(frame.truth.person);
    const double found = cv::countNonZero(mask & frame.truth.person) / people;
    const double still = cv::countNonZero(mask & ~mover) / static_cast<double>(cv::countNonZero(mask));
    const double still_in_boxes =
        cv::countNonZero(boxes & ~mover) / static_cast<double>(cv::countNonZero(boxes));
    CAPTURE(found);
    CAPTURE(still);
    CAPTURE(still_in_boxes);
    CHECK(people > 20000);
    CHECK(found > 0.8);
    CHECK(still < 0.1);
    CHECK(still_in_boxes > 0.3);
  }
}

}  // namespace box_masks_test
