// SPDX-License-Identifier: MIT
#include <dynfilter/config/registry.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"
#include "fakes.hpp"
#include "render/sequence_renderer.hpp"

namespace presets_test {

using namespace dynfilter;

namespace {

Registry registry() {
  Registry r = builtin_filters();
  r.add({{"oracle", "registered by the command", {}, {}},
         [](const YamlNode&) { return fakes::says("oracle", ""); }});
  return r;
}
std::string file_of(const std::string& preset) {
  return std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/" + preset + ".yaml";
}
Pipeline load(const std::string& preset) {
  return Pipeline(pipeline_from_file(file_of(preset), registry()));
}

struct HostFrame {
  render::RenderedFrame image;
  cv::Mat grey;
  std::vector<cv::KeyPoint> keypoints;
};

/// The first frames of a rendered sequence: rendering them takes longer than judging them.
const std::vector<HostFrame>& host_frames() {
  static const std::vector<HostFrame> all = [] {
    render::SequenceOptions options;
    options.scene = "walking_xyz";
    options.frames = 3;
    render::SequenceRenderer renderer(options);
    const cv::Ptr<cv::ORB> orb = cv::ORB::create(500);
    std::vector<HostFrame> made(3);
    for (int k = 0; k < 3; ++k) {
      HostFrame& one = made[static_cast<std::size_t>(k)];
      one.image = renderer.frame(k);
      cv::cvtColor(one.image.colour, one.grey, cv::COLOR_BGR2GRAY);
      orb->detect(one.grey, one.keypoints);
    }
    return made;
  }();
  return all;
}

std::vector<Verdict> verdicts_on_images(const std::string& preset, int threads) {
  const int before = cv::getNumThreads();
  cv::setNumThreads(threads);
  Pipeline pipeline = load(preset);
  std::vector<Verdict> verdicts;
  for (const HostFrame& from : host_frames()) {
    FrameView frame;
    frame.id = static_cast<std::int64_t>(verdicts.size());
    frame.timestamp_s = from.image.timestamp_s;
    frame.keypoints = from.keypoints;
    frame.grey = from.grey;
    frame.depth = from.image.depth;
    frame.depth_unit_m = 1.0 / 5000;
    frame.camera = freiburg3_camera();
    if (from.image.detections) frame.detections = DetectionInput{-1, *from.image.detections};
    verdicts.push_back(pipeline.before_pose(frame));
  }
  cv::setNumThreads(before);
  return verdicts;
}

}  // namespace

TEST_CASE("every preset loads, names itself as its file, and judges every exact scene") {
  int presets = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines")) {
    const std::string preset = entry.path().stem().string();
    CAPTURE(preset);
    ++presets;
    for (const testing::Preset kind : testing::all_presets()) {
      Pipeline pipeline = load(preset);
      CHECK(pipeline.name() == preset);
      const testing::ExactScene scene = testing::preset(kind).with_detections();
      for (int k = 0; k < 4; ++k) {
        const testing::ExactFrame frame = scene.frame(k);
        const Verdict& verdict = pipeline.before_pose(frame.view());
        CHECK(verdict.size() == frame.size());
        for (const StageReport& stage : verdict.report.stages) CHECK_FALSE(stage.failed);
      }
    }
  }
  CHECK(presets >= 7);
}

// What is published keeps its fixed thresholds.
TEST_CASE("rts_slam is the only preset whose thresholds follow the measured noise") {
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines")) {
    const std::string preset = entry.path().stem().string();
    CAPTURE(preset);
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    CHECK((text.find("measured_noise: true") != std::string::npos) == (preset == "rts_slam"));
  }
}

TEST_CASE(
    "rts_slam: seeds lie outside of the boxes, a box that hides most of the movers cannot take the model "
    "over") {
  Pipeline pipeline = load("rts_slam");
  const testing::ExactScene scene =
      testing::preset(testing::Preset::Majority).with_detections().pixel_noise(0.2).depth_noise(0.001);
  for (int k = 0; k < 10; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    const Verdict& verdict = pipeline.before_pose(frame.view());
    if (k < 5) continue;
    int dynamic = 0, found = 0, fixed = 0, kept = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      dynamic += frame.truth[i] == testing::Truth::Dynamic ? 1 : 0;
      found += frame.truth[i] == testing::Truth::Dynamic && !verdict.keep(i) ? 1 : 0;
      fixed += frame.truth[i] == testing::Truth::Static ? 1 : 0;
      kept += frame.truth[i] == testing::Truth::Static && verdict.keep(i) ? 1 : 0;
    }
    CHECK(found >= 0.9 * dynamic);
    CHECK(kept >= 0.7 * fixed);
  }
}

TEST_CASE("dynfilter: movers are found without boxes, and what stands still in a box stays") {
  for (const bool boxes : {false, true})
    for (const bool moves : {false, true}) {
      testing::ExactScene scene =
          testing::ExactScene().pixel_noise(0.1).depth_noise(0.001).mover(testing::MovingBox(60)
                                                                              .at({-0.3, -0.35, 2.5})
                                                                              .moving({0.02, 0.033, 0.01})
                                                                              .still_until(moves ? 0 : 99));
      if (boxes) scene.with_detections();
      Pipeline pipeline = load("dynfilter");
      for (int k = 0; k < 8; ++k) {
        const testing::ExactFrame frame = scene.frame(k);
        const Verdict& verdict = pipeline.before_pose(frame.view());
        if (k < 4) continue;
        int on_mover = 0, gone = 0, lost = 0;
        for (std::size_t i = 0; i < frame.size(); ++i) {
          on_mover += frame.label[i] > 0 ? 1 : 0;
          gone += frame.label[i] > 0 && !verdict.keep(i) ? 1 : 0;
          lost += frame.label[i] == 0 && !verdict.keep(i) ? 1 : 0;
        }
        if (moves) CHECK(gone >= 0.95 * on_mover);
        if (!moves) CHECK(gone <= 0.05 * on_mover);
        CHECK(lost <= 0.03 * static_cast<double>(frame.size()));
      }
    }
}

TEST_CASE("mono: the stages that need depth are skipped with a note, the others judge") {
  Pipeline pipeline = load("rts_slam");
  const testing::ExactScene scene = testing::preset(testing::Preset::General).with_detections().mono();
  for (int k = 0; k < 2; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    const Verdict& verdict = pipeline.before_pose(frame.view());
    int skipped = 0;
    for (const StageReport& stage : verdict.report.stages)
      skipped += stage.skipped && stage.name == "trajectory_consistency" && stage.note == "skipped: no depth"
                     ? 1
                     : 0;
    if (k == 0) continue;  // no correspondences either
    CHECK(skipped == 2);
    CHECK(verdict.report.rejected > 0);
  }
}

TEST_CASE("same input, same verdicts, bit for bit: twice, and with one and two threads") {
  for (const char* preset : {"rts_slam", "rts_slam_published", "dynfilter"}) {
    const auto a = verdicts_on_images(preset, 1), b = verdicts_on_images(preset, 1),
               c = verdicts_on_images(preset, 2);
    REQUIRE(a.size() == 3);
    CHECK(a[2].report.rejected > 20);
    for (std::size_t k = 0; k < a.size(); ++k)
      for (const Verdict* other : {&b[k], &c[k]}) {
        CHECK(a[k].decision == other->decision);
        CHECK(a[k].suspicion == other->suspicion);
        CHECK(a[k].reasons == other->reasons);
      }
  }
}

}  // namespace presets_test
