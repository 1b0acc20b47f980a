// SPDX-License-Identifier: MIT
#include <chrono>
#include <dynfilter/core/error.hpp>
#include <dynfilter/pipeline/compose.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "doctest/doctest.h"
#include "fakes.hpp"

namespace budget_test {

using namespace dynfilter;
using fakes::Features;
using fakes::letters_of;
using fakes::says;
using fakes::Scripted;

namespace {

constexpr double kBudget_ms = 5;

/// Exceeds the budget on frame 1 only, and then says what `letters` say.
StagePtr slow(const std::string& letters) {
  return stage(std::make_unique<Scripted>("slow", [letters](const Evidence& evidence, Votes& votes) {
    if (evidence.frame().id == 1)
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(2 * kBudget_ms));
    for (std::size_t i = 0; i < letters.size(); ++i)
      if (letters[i] != 'U') votes.cast(i, letters[i] == 'D' ? Vote::Dynamic : Vote::Static);
  }));
}

Pipeline pipeline_of(StagePtr root, double budget_ms) {
  PipelineConfig config;
  config.params.budget_ms = budget_ms;
  config.floor.min_features = 0;
  config.before_pose = std::move(root);
  return Pipeline(std::move(config));
}

const StageReport& report_of(const Verdict& verdict, const std::string& name) {
  for (const StageReport& report : verdict.report.stages)
    if (report.name == name) return report;
  FAIL("no stage ", name);
  return verdict.report.stages.front();
}

}  // namespace

TEST_CASE("after the budget later rejectors are skipped, which is said, and what was voted counts") {
  const Features features(4);
  // A budget that a quick frame never exceeds, whatever else the machine does, is a minute.
  for (const double budget_ms : {kBudget_ms, 6e4, 0.0}) {
    CAPTURE(budget_ms);
    Pipeline pipeline =
        pipeline_of(sequence(slow("DSUU"), stage(says("b", "UUDU")), stage(says("c", "UUUD"))), budget_ms);
    const Verdict& verdict = pipeline.before_pose(features.view(1));
    const bool late = budget_ms == kBudget_ms;
    CHECK(letters_of(verdict) == (late ? "DSUU" : "DSDD"));
    CHECK_FALSE(report_of(verdict, "slow").skipped);
    for (const char* name : {"b", "c"}) {
      CHECK(report_of(verdict, name).skipped == late);
      CHECK(report_of(verdict, name).note == (late ? "skipped: over the time budget" : ""));
    }
    REQUIRE(verdict.report.notes.size() == (late ? 1U : 0U));
    if (late) CHECK(verdict.report.notes[0] == "over the time budget of 5 ms at `slow`, 2 rejectors skipped");
    CHECK(verdict.size() == 4);
    CHECK(verdict.report.rejected == (late ? 1U : 3U));
  }
}

TEST_CASE("each call has its own budget, and the last stage may be the late one") {
  const Features features(2);
  Pipeline pipeline = pipeline_of(sequence(stage(says("a", "SU")), slow("UD")), kBudget_ms);
  const Verdict& late = pipeline.before_pose(features.view(1));
  CHECK(letters_of(late) == "SD");
  REQUIRE(late.report.notes.size() == 1);
  CHECK(late.report.notes[0] == "over the time budget of 5 ms at `slow`");
}

TEST_CASE("a lack of time rejects nothing: strict, not, all, gate") {
  const Features features(3);
  const auto verdict_of = [&](StagePtr tail) {
    Pipeline pipeline = pipeline_of(sequence(slow("UUU"), std::move(tail)), kBudget_ms);
    return letters_of(pipeline.before_pose(features.view(1)));
  };
  CHECK(verdict_of(strict(stage(says("a", "SDU")))) == "UUU");
  CHECK(verdict_of(negate(stage(says("a", "SDU")))) == "UUU");
  CHECK(verdict_of(all(stage(says("a", "DDD")), stage(says("b", "DDD")))) == "UUU");
  CHECK(verdict_of(any(stage(says("a", "DDD")), stage(says("b", "DDD")))) == "UUU");
  CHECK(verdict_of(gate(stage(says("a", "DDD")), stage(says("b", "DDD")))) == "UUU");
  CHECK(verdict_of(first_available(stage(says("a", "DDD")), stage(says("b", "DDD")))) == "UUU");
  // Late within strict: what was found before counts, what was not asked is not rejected.
  Pipeline pipeline = pipeline_of(strict(sequence(slow("SDU"), stage(says("b", "UUS")))), kBudget_ms);
  CHECK(letters_of(pipeline.before_pose(features.view(1))) == "SDU");
}

TEST_CASE("a budget out of range is refused") {
  CHECK_THROWS_AS(pipeline_of(stage(says("a", "S")), -1), ConfigError);
}

}  // namespace budget_test
