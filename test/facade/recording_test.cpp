// SPDX-License-Identifier: MIT
#include <dynfilter/facade/dynfilter.h>
#include <dynfilter/facade/facade.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/recorder/recording.hpp>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "doctest/doctest.h"
#include "io/tum_folder.hpp"
#include "support/layered_scene.hpp"

namespace facade_recording_test {

using namespace dynfilter;
using dynfilter_test::LayeredFrame;
using dynfilter_test::LayeredScene;

namespace {

[[maybe_unused]] constexpr const char* kYaml =
    "pipeline: { name: mine, before_pose: [ flow_consistency, { semantic_box: {} } ] }";
constexpr int kFrames = 4;

/// Replays what an interface recorded. Returns the calls whose verdict differs, or -1 if some are missing.
[[maybe_unused]] int differing_calls(const std::filesystem::path& file) {
  recorder::RecordingReader reader(file);
  CHECK(reader.notes().empty());  // it was closed
  Pipeline pipeline(config_of(reader.pipeline(), builtin_filters()));
  std::vector<KeyframeView> keyframes;
  int calls = 0, differ = 0;
  while (const auto event = reader.next()) {
    event->repeat(pipeline);
    if (event->kind != recorder::RecordedEvent::Kind::Frame) continue;
    const FrameView view = event->frame.view(keyframes);
    CHECK((view.detections && view.detections->detections.size() == 1 && !view.grey.empty()));
    const Verdict& again = pipeline.process(view, event->point, event->limits);
    differ += !event->verdict || recorder::difference(*event->verdict, again).any() ? 1 : 0;
    ++calls;
  }
  return calls == kFrames ? differ : -1;
}

}  // namespace

#ifdef DYNFILTER_FACADE_FROM_HEADERS
TEST_CASE("a library of the headers alone says that it has no recorder") {
  facade::DynFilter filter;
  REQUIRE(filter.load(kYaml));
  CHECK(!filter.record("run.dfr"));
  CHECK(filter.error() == "run.dfr: this program has the headers only: link dynfilter::recorder");
}
#else
TEST_CASE("the C++11 interface records what replays bit for bit") {
  const dynfilter_test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "run.dfr";
  facade::DynFilter filter;
  CHECK(!filter.record(file.string()));
  CHECK(filter.error() == "no pipeline is loaded");
  REQUIRE(filter.load(kYaml));
  REQUIRE(filter.record(file.string()));
  for (int k = 0; k < kFrames; ++k) {
    const LayeredFrame from = LayeredScene().frame(k);
    facade::Frame frame;
    frame.id = from.id, frame.timestamp_s = from.timestamp_s;
    frame.keypoints = from.keypoints, frame.grey = from.grey;
    frame.has_boxes = true;
    frame.boxes.resize(1);
    frame.boxes[0].box = from.boxes[0].box, frame.boxes[0].class_name = "person";
    facade::Verdicts verdicts;
    REQUIRE(filter.process(frame, facade::CallPoint::BeforePose, verdicts));
    if (k == 1) REQUIRE(filter.reset());
  }
  REQUIRE(filter.record(""));
  CHECK(differing_calls(file) == 0);
  CHECK(!filter.record(file.string(), 0));
  CHECK(filter.error().find("at least 1 MB") != std::string::npos);
}

TEST_CASE("the C interface records what replays bit for bit") {
  const dynfilter_test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "run.dfr";
  dynfilter_filter* filter = dynfilter_create_from_text(kYaml, nullptr, 0);
  REQUIRE(filter != nullptr);
  REQUIRE(dynfilter_record(filter, file.c_str(), 100) == 0);
  for (int k = 0; k < kFrames; ++k) {
    const LayeredFrame from = LayeredScene().frame(k);
    std::vector<dynfilter_keypoint> keypoints;
    for (const cv::KeyPoint& point : from.keypoints)
      keypoints.push_back({point.pt.x, point.pt.y, point.size, point.angle, point.response, point.octave});
    const cv::Rect2f& box = from.boxes[0].box;
    const dynfilter_box person = {box.x, box.y, box.width, box.height, 0.9F, 0, -1, "person", nullptr, 0};
    dynfilter_frame frame;
    dynfilter_frame_init(&frame);
    frame.id = from.id, frame.timestamp_s = from.timestamp_s;
    frame.keypoint_count = keypoints.size(), frame.keypoints = keypoints.data();
    frame.width_px = from.grey.cols, frame.height_px = from.grey.rows, frame.grey = from.grey.data;
    frame.has_boxes = 1, frame.box_count = 1, frame.boxes = &person;
    dynfilter_verdicts verdicts;
    REQUIRE(dynfilter_process(filter, &frame, DYNFILTER_BEFORE_POSE, &verdicts) == 0);
    if (k == 1) REQUIRE(dynfilter_reset(filter) == 0);
  }
  dynfilter_destroy(filter);  // closes it
  CHECK(differing_calls(file) == 0);
}
#endif

}  // namespace facade_recording_test
