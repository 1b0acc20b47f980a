// SPDX-License-Identifier: MIT
// Every combinator has an example in examples/combinators, which does something on a short scene.
#include <algorithm>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/combinator_table.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <filesystem>

#include "doctest/doctest.h"

namespace combinator_examples_test {

using namespace dynfilter;

const std::filesystem::path kFolder = std::filesystem::path(DYNFILTER_SOURCE_DIR) / "examples/combinators";

/// The verdict on the last of eight frames in which a sixth of the points moves.
Verdict last_verdict(const std::filesystem::path& file) {
  Pipeline pipeline(pipeline_from_file(file.string(), builtin_filters()));
  const testing::ExactScene scene = testing::preset(testing::Preset::General)
                                        .pixel_noise(0.3)
                                        .with_poses()
                                        .with_detections()
                                        .with_descriptors()
                                        .with_map_points();
  Verdict verdict;
  for (int k = 0; k < 8; ++k) verdict = pipeline.before_pose(scene.frame(k).view());
  return verdict;
}

TEST_CASE("every combinator has an example that runs and rejects features") {
  for (const CombinatorEntry& entry : combinator_table()) {
    CAPTURE(entry.card.name);
    const std::filesystem::path file = kFolder / (entry.card.name + ".yaml");
    REQUIRE(std::filesystem::exists(file));
    const Verdict verdict = last_verdict(file);
    for (const StageReport& stage : verdict.report.stages) {
      CAPTURE(stage.path);
      CHECK_FALSE(stage.failed);
    }
    const auto& stages = verdict.report.stages;
    const auto combinator = std::find_if(stages.begin(), stages.end(), [&](const StageReport& stage) {
      return stage.name == entry.card.name;
    });
    REQUIRE(combinator != stages.end());
    CHECK_FALSE(combinator->skipped);
    CHECK(combinator->judged > 0);
    CHECK(combinator->dynamic > 0);
    CHECK(verdict.report.rejected > 0);
  }
}

TEST_CASE("every example is of a combinator") {
  for (const auto& file : std::filesystem::directory_iterator(kFolder)) {
    const std::string name = file.path().stem().string();
    CAPTURE(name);
    CHECK(std::any_of(combinator_table().begin(), combinator_table().end(),
                      [&](const CombinatorEntry& entry) { return entry.card.name == name; }));
  }
}

}  // namespace combinator_examples_test
