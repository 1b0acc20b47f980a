// SPDX-License-Identifier: MIT
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/plugin/loader.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>

#include "doctest/doctest.h"

namespace pipeline_test {

using namespace dynfilter;
namespace fs = std::filesystem;

namespace {

std::vector<Verdict> verdicts_of(const std::string& yaml, const Registry& registry, int frames) {
  const testing::ExactScene scene =
      testing::preset(testing::Preset::General).pixel_noise(0.3).with_detections();
  Pipeline pipeline(pipeline_from_text(yaml, registry));
  std::vector<Verdict> verdicts;
  for (int k = 0; k < frames; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    verdicts.push_back(pipeline.before_pose(frame.view()));
  }
  return verdicts;
}

const StageReport* report_of(const Verdict& verdict, const std::string& name) {
  for (const StageReport& stage : verdict.report.stages)
    if (stage.name == name) return &stage;
  return nullptr;
}

}  // namespace

TEST_CASE("a plugin that throws is named in the report, its votes do not count, and the frame goes on") {
  Registry registry = builtin_filters();
  load_plugin(fs::path(DYNFILTER_BAD_PLUGINS_DIR) / "throws_in_apply.so", registry);
  const std::string with = "{ before_pose: [ throws_in_apply, { semantic_box: { role: reject } } ] }";
  const std::string without = "{ before_pose: [ { semantic_box: { role: reject } } ] }";
  const auto verdicts = verdicts_of("pipeline: " + with, registry, 3);
  const auto expected = verdicts_of("pipeline: " + without, registry, 3);
  for (std::size_t k = 0; k < verdicts.size(); ++k) {
    const StageReport* stage = report_of(verdicts[k], "throws_in_apply");
    REQUIRE(stage != nullptr);
    CHECK(stage->failed);
    CHECK(stage->note == "failed: the sensor melted");
    CHECK(stage->dynamic == 0);
    CHECK(verdicts[k].decision == expected[k].decision);
  }
}

TEST_CASE("a plugin that throws from its constructor or its needs is named, with its place in the file") {
  Registry registry = builtin_filters();
  for (const char* file : {"throws_when_made.so", "throws_in_needs.so"})
    load_plugin(fs::path(DYNFILTER_BAD_PLUGINS_DIR) / file, registry);
  const auto complaint = [&](const std::string& stage) -> std::string {
    try {
      pipeline_from_text("pipeline: { before_pose: [ epipolar, { " + stage + " } ] }", registry);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  const std::string at = "pipeline.before_pose[1].";
  CHECK(complaint("named_p: { limit_px: 7 }") ==
        at + "named_p: filter `named_p` cannot be made: no licence for 7");
  CHECK(complaint("named_p: { limit_px: 9 }") ==
        at + "named_p: filter `named_p` cannot be made: an unknown exception");
  CHECK(complaint("moody: { limit_px: 7 }") ==
        at + "moody: filter `moody` cannot be made: filter `moody`: its needs: ask me later");
  CHECK(complaint("moody: { limit_px: 9 }") ==
        at + "moody: filter `moody` cannot be made: filter `moody`: its needs: an unknown exception");
  CHECK(complaint("moody: { limit_px: 1 }").empty());
}

TEST_CASE("a plugin that throws from reset is named in the reports, and the frames go on") {
  Registry registry = builtin_filters();
  load_plugin(fs::path(DYNFILTER_BAD_PLUGINS_DIR) / "throws_in_needs.so", registry);
  Pipeline pipeline(pipeline_from_text(
      "pipeline: { before_pose: [ { moody: { limit_px: 5 } }, { semantic_box: { role: reject } } ] }",
      registry));
  const testing::ExactScene scene = testing::preset(testing::Preset::General).with_detections();
  CHECK_FALSE(report_of(pipeline.before_pose(scene.frame(0).view()), "moody")->failed);
  pipeline.reset();
  const testing::ExactFrame frame = scene.frame(1);
  const Verdict& verdict = pipeline.before_pose(frame.view());
  CHECK(report_of(verdict, "moody")->failed);
  CHECK(report_of(verdict, "moody")->note == "failed: reset: I remember everything");
  CHECK(verdict.report.rejected > 0);
}

TEST_CASE("a filter gives the same verdicts from its plugin as from its header, bit for bit") {
  const Registry headers = builtin_filters();
  int compared = 0;
  for (const std::string& name : headers.names()) {
    const fs::path file = fs::path(DYNFILTER_PLUGINS_DIR) / (name + ".so");
    if (!fs::exists(file)) continue;
    CAPTURE(name);
    Registry plugin;
    CHECK(load_plugin(file, plugin) == std::vector<std::string>{name});
    const std::string yaml = "pipeline: { before_pose: [ " + name + " ] }";
    const auto a = verdicts_of(yaml, headers, 8), b = verdicts_of(yaml, plugin, 8);
    for (std::size_t k = 0; k < a.size(); ++k) {
      CHECK(a[k].decision == b[k].decision);
      CHECK(a[k].suspicion == b[k].suspicion);
      CHECK(a[k].prior == b[k].prior);
    }
    CHECK(a.back().size() > 0);
    ++compared;
  }
  if (compared == 0) MESSAGE("skipped: built without DYNFILTER_BUILD_PLUGINS");
  if (compared > 0) CHECK(compared == static_cast<int>(headers.names().size()));
}

}  // namespace pipeline_test
