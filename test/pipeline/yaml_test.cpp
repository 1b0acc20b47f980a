// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <fstream>
#include <sstream>

#include <dynfilter/pipeline/combinator_table.hpp>

#include "doctest/doctest.h"
#include "fakes.hpp"
#include "support/parameter_tables.hpp"
#include "support/time_limit.hpp"

namespace yaml_test {

using namespace dynfilter;

namespace {

struct LimitParams {
  double limit_px = 1;
  static const FieldTable<LimitParams>& fields() {
    static const FieldTable<LimitParams> table{
        real("limit_px", &LimitParams::limit_px, "px", {0, 10}, "a limit")};
    return table;
  }
};

/// Dynamic where x exceeds the limit.
class Limit final : public Filter {
 public:
  using Params = LimitParams;
  static constexpr const char* kName = "limit";
  static constexpr const char* kSummary = "x beyond a limit";
  explicit Limit(Params params = Params()) : params_(params) {}
  std::string name() const override { return kName; }
  Needs needs() const override { return {}; }
  void apply(const Evidence& evidence, Votes& votes) override {
    for (std::size_t i = 0; i < evidence.size(); ++i)
      votes.cast(
          i, static_cast<double>(evidence.pixels()[i].x) > params_.limit_px ? Vote::Dynamic : Vote::Static);
  }

 private:
  Params params_;
};

Registry registry() {
  Registry r;
  r.add<Limit>();
  r.add({{"mark", "marks the first feature", {}, {}},
         [](const YamlNode&) { return fakes::says("mark", "P"); }});
  return r;
}

PipelineConfig read(const std::string& text) {
  return pipeline_from_text(text, registry());
}

std::string error_of(const std::string& text) {
  try {
    read(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

std::string combinator_names() {
  std::string text;
  for (const CombinatorEntry& entry : combinator_table())
    text += (text.empty() ? "" : ", ") + entry.card.name;
  return text;
}

std::string judge(const std::string& stages, std::size_t n = 3) {
  Pipeline pipeline(read("pipeline:\n  floor: { min_features: 0 }\n  before_pose:\n" + stages));
  return fakes::letters_of(pipeline.before_pose(fakes::Features(n).view()));
}

}  // namespace

// Features at x = 0, 10, 20.
TEST_CASE("stages with and without parameters, as lists and as combinators") {
  CHECK(judge("    - limit\n") == "SDD");
  CHECK(judge("    - limit: { limit_px: 10 }\n") == "SSD");
  CHECK(judge("    any:\n      - limit: { limit_px: 10 }\n      - limit: { limit_px: 5 }\n") == "SDD");
  CHECK(judge("    all: [ { limit: { limit_px: 10 } }, limit ]\n") == "SSD");
  CHECK(judge("    not: limit\n") == "DSS");
  CHECK(judge("    strict: mark\n") == "DDD");
  CHECK(judge("    gate: { if: limit, then: { limit: { limit_px: 10 } } }\n") == "USD");
  CHECK(judge("    - mark\n    - by_region: { inside: { not: limit }, outside: { limit: { limit_px: 10 } } "
              "}\n") == "DSD");
}

TEST_CASE("a pipeline is a map among others, as in a settings file of ORB-SLAM") {
  const PipelineConfig config = read(
      "%YAML:1.0\n---\nCamera.fx: 535.4\nORBextractor.nFeatures: 1000\npipeline:\n  name: mine\n  "
      "max_time_gap_s: 3\n"
      "  correspondence: { source: flow, flow: { window_px: 15 } }\n  floor: { min_share: 0.2 }\n"
      "  before_pose: []\n  at_keyframe:\n    - limit\n");
  CHECK(config.name == "mine");
  CHECK(config.params.max_time_gap_s == 3.0);
  CHECK(config.correspondence.source == CorrespondenceSource::Flow);
  CHECK(config.correspondence.flow.window_px == 15);
  CHECK(config.floor.min_share == 0.2);
  CHECK(config.before_pose == nullptr);
  CHECK(config.after_pose == nullptr);
  REQUIRE(config.at_keyframe != nullptr);
  CHECK(config.at_keyframe->name() == "sequence");
}

TEST_CASE("each mistake is one line with the path and what was expected") {
  const std::string head = "pipeline:\n  before_pose:\n";
  CHECK(error_of("other: 1\n") == "expected the key `pipeline`");
  CHECK(error_of("pipeline:\n  stages: [ limit ]\n") ==
        "pipeline: unknown key `stages`; known keys: name, about, max_time_gap_s, first_frame_suspects, "
        "budget_ms, "
        "correspondence, floor, initialisation, before_pose, "
        "after_pose, at_keyframe");
  CHECK(
      error_of(head + "    - limt\n") ==
      "pipeline.before_pose[0]: unknown filter `limt` (did you mean `limit`?); known filters: limit, mark, " +
          combinator_names());
  CHECK(error_of(head + "    - limit: { limit_px: 11 }\n") ==
        "pipeline.before_pose[0].limit.limit_px: expected 0 to 10, got `11`");
  CHECK(error_of(head + "    - any:\n        - limit: { limit: 1 }\n") ==
        "pipeline.before_pose[0].any[0].limit: unknown key `limit` (did you mean `limit_px`?); known keys: "
        "limit_px");
  CHECK(error_of(head + "    - limit: { limit_px: big }\n") ==
        "pipeline.before_pose[0].limit.limit_px: expected a number, got `big`");
  CHECK(error_of(head + "    - any: []\n") == "pipeline.before_pose[0].any: expected at least one stage");
  CHECK(error_of(head + "    - any: limit\n") == "pipeline.before_pose[0].any: expected a list, got `limit`");
  CHECK(error_of(head + "    - gate: { if: limit }\n") ==
        "pipeline.before_pose[0].gate: expected the key `then`");
  CHECK(
      error_of(head + "    - gate: { if: limit, them: limit }\n") ==
      "pipeline.before_pose[0].gate: unknown key `them` (did you mean `then`?); known keys: if, then, else");
  CHECK(error_of(head + "    - { limit: {}, mark: {} }\n") ==
        "pipeline.before_pose[0]: expected one stage, `name` or `name: { parameters }`");
  CHECK(error_of("pipeline:\n  max_time_gap_s: -1\n") == "pipeline.max_time_gap_s: expected >= 0, got `-1`");
  CHECK(error_of("pipeline:\n  correspondence: { flow: { window_px: 3 } }\n") ==
        "pipeline.correspondence.flow.window_px: expected 5 to 63, got `3`");
  CHECK(error_of("pipeline:\n  correspondence: { sauce: flow }\n")
            .find("pipeline.correspondence: unknown key `sauce`; known keys: source, ") == 0);
  CHECK(error_of("pipeline:\n  floor: { min_share: 2 }\n") ==
        "pipeline.floor.min_share: expected 0 to 1, got `2`");
}

TEST_CASE("5,000 stages, beside each other or in pairs, are refused in time") {
  std::string flat = "pipeline:\n  before_pose:\n", pairs = flat;
  for (int i = 0; i < 5000; ++i) {
    flat += "    - limit\n";
    pairs += "    - any: [ limit, limit ]\n";
  }
  for (const std::string& text : {flat, pairs}) {
    std::string error;
    const double taken_s = dynfilter_test::seconds([&] { error = error_of(text); });
    CHECK(error.find("expected at most 64 stages") != std::string::npos);
    CHECK(taken_s < dynfilter_test::kMost_s);
  }
}

TEST_CASE("a call point has at most as many stages as a verdict has reasons") {
  std::string stages = "pipeline:\n  before_pose:\n";
  for (int i = 0; i < 63; ++i) stages += "    - limit\n";  // and the list itself
  CHECK(error_of(stages) == "no error");
  CHECK(error_of(stages + "    - limit\n") ==
        "pipeline.before_pose[63]: expected at most 64 stages, combinators counted");
}

TEST_CASE("a file's name stands before the error") {
  CHECK_THROWS_WITH_AS(pipeline_from_file("/no/such/file.yaml", registry()),
                       "/no/such/file.yaml: cannot be read", ConfigError);
}

TEST_CASE("every combinator has a card, and every card a combinator") {
  for (const CombinatorEntry& entry : combinator_table())
    CHECK(error_of("pipeline:\n  before_pose:\n    - " + entry.card.name + ": 1\n").find("unknown filter") ==
          std::string::npos);
}

TEST_CASE("combinators with parameters read them beside their stages") {  // x = 0, 10, 20, 30
  CHECK(
      judge(
          "    vote: { of: [ limit, { limit: { limit_px: 10 } }, { limit: { limit_px: 5 } } ], min_votes: 2 "
          "}\n",
          4) == "SDDD");
  CHECK(judge("    vote: { of: [ { not: limit }, limit ], weights: [ 3, 1 ] }\n", 4) == "DSSS");
  const std::string head = "pipeline:\n  before_pose:\n    - ";
  CHECK(error_of(head + "vote: { of: [ limit ], weights: [ 1, 2 ] }\n") ==
        "pipeline.before_pose[0].vote.weights: expected one per member, got 2 for 1");
  CHECK(error_of(head + "vote: { of: limit }\n") ==
        "pipeline.before_pose[0].vote.of: expected a list, got `limit`");
  CHECK(error_of(head + "vote: { min_votes: 2 }\n") == "pipeline.before_pose[0].vote: expected the key `of`");
  CHECK(error_of(head + "vote: { of: [ limit ], min_vote: 2 }\n") ==
        "pipeline.before_pose[0].vote: unknown key `min_vote` (did you mean `min_votes`?); known keys: of, "
        "min_votes, min_share, weights");
  CHECK(error_of(head + "vote: { of: [ limit, limit ], weights: [ 1, 2000000 ] }\n") ==
        "pipeline.before_pose[0].vote.weights: expected 0 to 1e+06, got `2e+06`");
  CHECK(error_of(head + "vote: { of: [ limit ], weights: person }\n") ==
        "pipeline.before_pose[0].vote.weights: expected a number, got `person`");
  CHECK(
      error_of(head + "object_vote: { of: limit, objects: box }\n") ==
      "pipeline.before_pose[0].object_vote.objects: expected one of boxes, instances, mask, components, got "
      "`box` (did you mean `boxes`?)");
}

// DYNFILTER_UPDATE_DOCS=1 writes the tables instead.
TEST_CASE("docs/reference/pipelines.md has the combinators and their parameters") {
  const std::string path = std::string(DYNFILTER_SOURCE_DIR) + "/docs/reference/pipelines.md";
  const std::string begin = "<!-- combinators -->\n", end = "<!-- end of combinators -->";
  std::stringstream text, wanted;
  text << std::ifstream(path).rdbuf();
  std::string page = text.str();
  wanted << "| combinator | form | a feature is dynamic |\n|---|---|---|\n";
  for (const CombinatorEntry& entry : combinator_table())
    wanted << "| `" << entry.card.name << "` | `" << entry.card.form << "` | " << entry.card.dynamic
           << " |\n";
  for (const CombinatorEntry& entry : combinator_table()) {
    if (entry.card.parameters.empty()) continue;
    wanted << "\n| `" << entry.card.name << "` | default | meaning |\n"
           << dynfilter_test::parameter_rows(entry.card.parameters);
  }
  const auto from = page.find(begin), to = page.find(end);
  REQUIRE(from != std::string::npos);
  REQUIRE(to != std::string::npos);
  if (std::getenv("DYNFILTER_UPDATE_DOCS") != nullptr)
    std::ofstream(path) << page.replace(from + begin.size(), to - from - begin.size(), wanted.str());
  else
    CHECK(page.substr(from + begin.size(), to - from - begin.size()) == wanted.str());
}

TEST_CASE("docs/reference/pipelines.md has the keys of a pipeline") {
  using dynfilter_test::parameter_table;
  dynfilter_test::check_parameter_tables("docs/reference/pipelines.md",
                                         {{"pipeline", parameter_table<PipelineParams>()},
                                          {"floor", parameter_table<FloorParams>()},
                                          {"correspondence", parameter_table<CorrespondenceParams>()},
                                          {"flow", parameter_table<FlowParams>()},
                                          {"descriptors", parameter_table<DescriptorMatchParams>()},
                                          {"initialisation", parameter_table<InitialisationParams>()}});
}

}  // namespace yaml_test
