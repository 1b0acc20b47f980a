// SPDX-License-Identifier: MIT
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/pipeline/compose.hpp>
#include <dynfilter/pipeline/pipeline.hpp>

#include <dynfilter/pipeline/temporal_stage.hpp>
#include <dynfilter/pipeline/vote_stage.hpp>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "doctest/doctest.h"
#include "fakes.hpp"

namespace combinators_test {

using namespace dynfilter;
using fakes::Features;
using fakes::letters_of;
using fakes::says;
using fakes::Scripted;

namespace {

/// The verdict of a tree on nine features, without a floor.
Verdict judge(StagePtr root, std::size_t n = 9) {
  PipelineConfig config;
  config.floor.min_features = 0;
  config.before_pose = std::move(root);
  Pipeline pipeline(std::move(config));
  return pipeline.before_pose(Features(n).view());
}

StagePtr watch(std::vector<std::string>& log, const std::string& vote = "") {
  return stage(std::make_unique<Scripted>("watch", [&log, vote](const Evidence& evidence, Votes& votes) {
    std::string seen;
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      seen += !evidence.judged(i) ? '-' : evidence.prior(i) ? 'P' : evidence.seed(i) ? 's' : 'x';
      if (i < vote.size() && vote[i] == 'D') votes.cast(i, Vote::Dynamic);
      if (i < vote.size() && vote[i] == 'S') votes.cast(i, Vote::Static);
    }
    log.push_back(seen);
  }));
}

/// Says the letters of the frame with its id; counts its resets.
class Turns final : public Filter {
 public:
  Turns(std::string name, std::vector<std::string> letters, std::string* log, Needs needs = {})
      : name_(std::move(name)), letters_(std::move(letters)), log_(log), needs_(needs) {}
  std::string name() const override { return name_; }
  Needs needs() const override { return needs_; }
  void apply(const Evidence& evidence, Votes& votes) override {
    *log_ += name_;
    const std::string& letters = letters_[static_cast<std::size_t>(evidence.frame().id)];
    if (letters == "throw") throw std::runtime_error("no idea");
    if (letters == "doubt") return votes.doubt();
    for (std::size_t i = 0; i < letters.size(); ++i) {
      if (letters[i] == 'P') votes.mark_prior(i);
      if (letters[i] == 'S') votes.cast(i, Vote::Static);
      if (letters[i] == 'D') votes.cast(i, Vote::Dynamic);
    }
  }
  void reset() override { *log_ += "reset-" + name_; }

 private:
  std::string name_;
  std::vector<std::string> letters_;
  std::string* log_;
  Needs needs_;
};

/// One verdict per frame, of `first_available` of two members.
struct TwoMembers {
  TwoMembers(std::vector<std::string> a, std::vector<std::string> b, Needs needs_of_a = {}) {
    PipelineConfig config;
    config.floor.min_features = 0;
    config.before_pose = first_available(stage(std::make_unique<Turns>("a", std::move(a), &log, needs_of_a)),
                                         stage(std::make_unique<Turns>("b", std::move(b), &log)));
    pipeline = std::make_unique<Pipeline>(std::move(config));
  }
  const Verdict& judge(std::int64_t id, bool depth = false) {
    log.clear();
    FrameView frame = features.view(id);
    if (depth) frame.depth_m = depth_m;
    return pipeline->before_pose(frame);
  }

  std::string log;
  std::unique_ptr<Pipeline> pipeline;
  Features features{3};
  std::vector<float> depth_m = std::vector<float>(3, 1.0F);
};

}  // namespace

// Every pair of votes: SSS UUU DDD against SUD SUD SUD.
TEST_CASE("any, all and sequence follow their truth tables for every pair") {
  CHECK(letters_of(judge(any(stage(says("a", "SSSUUUDDD")), stage(says("b", "SUDSUDSUD"))))) == "SUDUUDDDD");
  CHECK(letters_of(judge(all(stage(says("a", "SSSUUUDDD")), stage(says("b", "SUDSUDSUD"))))) == "SSSSUUSUD");
  CHECK(letters_of(judge(sequence(stage(says("a", "SSSUUUDDD")), stage(says("b", "SUDSUDSUD"))))) ==
        "SSDSUDDDD");
  CHECK(letters_of(judge(negate(stage(says("a", "SUD"))), 3)) == "DUS");
}

TEST_CASE("vote of two members: one vote is any, two are all, for every pair") {
  const auto both = [](double min_votes) {
    VoteParams params;
    params.min_votes = min_votes;
    return vote(params, stage(says("a", "SSSUUUDDD")), stage(says("b", "SUDSUDSUD")));
  };
  CHECK(letters_of(judge(both(1))) == "SUDUUDDDD");
  CHECK(letters_of(judge(both(2))) == "SSSSUUSUD");
}

TEST_CASE("vote by share and with weights, and the members that said so are the reasons") {
  const auto three = [](VoteParams params) {
    return vote(std::move(params), stage(says("a", "DDDDS")), stage(says("b", "SDUSD")),
                stage(says("c", "SSSUD")));
  };
  CHECK(letters_of(judge(three({}), 5)) == "SDUUD");  // 2 of 3
  VoteParams weighted;
  weighted.weights = {3, 1, 1};  // a decides
  CHECK(letters_of(judge(three(weighted), 5)) == "DDDDS");
  const Verdict verdict = judge(three({}), 5);
  CHECK(verdict.reason(1) == "a+b");
  CHECK(verdict.reason(0).empty());
  VoteParams wrong;
  wrong.weights = {1, 2};
  CHECK_THROWS_AS(three(wrong), ConfigError);
}

TEST_CASE("vote: the suspicion is the members' mean by weight") {
  VoteParams params;
  params.weights = {3, 1};
  const Verdict verdict = judge(vote(params, stage(says("a", "DSD")), stage(says("b", "SDD"))), 3);
  CHECK(verdict.suspicion[0] == 0.75F);
  CHECK(verdict.suspicion[1] == 0.25F);
  CHECK(verdict.suspicion[2] == 1.0F);
}

TEST_CASE("two notes are one with a semicolon, and a missing one leaves no trace") {
  std::string note = "old";
  join_notes(note, "", "");
  CHECK(note.empty());
  join_notes(note, "a", "");
  CHECK(note == "a");
  join_notes(note, "", "b");
  CHECK(note == "b");
  join_notes(note, "a", "b");
  CHECK(note == "a; b");
}

TEST_CASE("strict: guilty until proven static, and the reason says who was not satisfied") {
  const Verdict verdict = judge(strict(sequence(stage(says("a", "SUDU")), stage(says("b", "UUUS")))), 4);
  CHECK(letters_of(verdict) == "SDDS");
  CHECK(verdict.reason(1) == "strict");
  CHECK(verdict.reason(2) == "a");
}

TEST_CASE("gate lets `then` judge where `if` is dynamic and `else` where it is static") {
  CHECK(letters_of(judge(gate(stage(says("if", "SSSUUUDDD")), stage(says("then", "SUDSUDSUD"))))) ==
        "UUUUUUSUD");
  CHECK(letters_of(judge(gate(stage(says("if", "SSSUUUDDD")), stage(says("then", "SUDSUDSUD")),
                              stage(says("else", "DDUSUDSUD"))))) == "DDUUUUSUD");
}

TEST_CASE("by_region asks `inside` for prior suspects and `outside` for the others") {
  CHECK(letters_of(judge(sequence(stage(says("prior", "PPPUUU")),
                                  by_region(stage(says("in", "SUDSUD")), stage(says("out", "DDDSUD")))),
                         6)) == "SUDSUD");
}

TEST_CASE("first_available: the first member with its inputs judges, the others do not run") {
  const auto needing = [](Input input, const std::string& name, const std::string& letters) {
    return stage(std::make_unique<Scripted>(
        name,
        [letters](const Evidence&, Votes& votes) {
          for (std::size_t i = 0; i < letters.size(); ++i)
            if (letters[i] == 'D') votes.cast(i, Vote::Dynamic);
        },
        Needs{input, Input::None, 0}));
  };
  const auto tree = [&] {
    return first_available(needing(Input::Depth, "deep", "DUU"), needing(Input::None, "flat", "UDU"),
                           needing(Input::None, "last", "UUD"));
  };
  CHECK(letters_of(judge(tree(), 3)) == "UDU");
  PipelineConfig config;
  config.floor.min_features = 0;
  config.before_pose = tree();
  Pipeline pipeline(std::move(config));
  const Features features(3);
  FrameView frame = features.view();
  const std::vector<float> depth_m(3, 1.0F);
  frame.depth_m = depth_m;
  const Verdict verdict = pipeline.before_pose(frame);
  CHECK(letters_of(verdict) == "DUU");
  CHECK(verdict.reason(0) == "deep");
  REQUIRE(verdict.report.stages.size() == 4);
  CHECK_FALSE(verdict.report.stages[1].skipped);
  CHECK(verdict.report.stages[2].note == "skipped: an earlier member judged");
  CHECK(verdict.report.stages[3].skipped);
}

TEST_CASE("first_available: a member that abstained on the whole frame has not judged") {
  TwoMembers two({"UUU", "UUS", "throw", "UPU", "UUU"}, {"UDU", "DDD", "DUU", "UUD", "UUU"});
  const Verdict& abstained = two.judge(0);
  CHECK(letters_of(abstained) == "UDU");
  CHECK(abstained.reason(1) == "b");
  CHECK(abstained.report.stages[0].note == "judged by b (a abstained on the whole frame)");
  CHECK(two.log == "ab");

  // One vote is a judgement. It is not mixed with that of another member.
  const Verdict& judged = two.judge(1);
  CHECK(letters_of(judged) == "UUS");
  CHECK(judged.report.stages[0].note.empty());
  CHECK(judged.report.stages[2].note == "skipped: an earlier member judged");
  CHECK(two.log == "a");

  const Verdict& failed = two.judge(2);
  CHECK(letters_of(failed) == "DUU");
  CHECK(failed.report.stages[0].note == "judged by b (a failed)");

  const Verdict& marked = two.judge(3);
  CHECK(letters_of(marked) == "UUD");
  CHECK(marked.prior[1] == 1);

  const Verdict& none = two.judge(4);
  CHECK(letters_of(none) == "UUU");
  CHECK(none.report.stages[0].note ==
        "no member judged (a abstained on the whole frame, b abstained on the whole frame)");
}

TEST_CASE("first_available: a member that doubts has judged") {
  TwoMembers two({"doubt", "UUU"}, {"DDD", "DDD"});
  const Verdict& doubted = two.judge(0);
  CHECK(letters_of(doubted) == "UUU");
  CHECK(doubted.report.stages[1].doubted);
  CHECK(two.log == "a");
  CHECK(letters_of(two.judge(1)) == "DDD");
  CHECK_FALSE(two.pipeline->before_pose(two.features.view(1)).report.stages[1].doubted);
}

TEST_CASE("first_available: an input that is missing in one frame passes the turn for this frame") {
  TwoMembers two({"SSS", "SSS", "SSS", "SSS"}, {"UUD", "UUD", "UUD", "UUD"}, {Input::Depth, Input::None, 0});
  CHECK(letters_of(two.judge(0)) == "UUD");
  CHECK(two.pipeline->before_pose(two.features.view(0)).report.stages[0].note ==
        "judged by b (a skipped: no depth)");
  CHECK(letters_of(two.judge(1, true)) == "SSS");
  two.depth_m.assign(3, -1.0F);  // as hosts fill what they lack
  CHECK(letters_of(two.judge(2, true)) == "UUD");
  two.depth_m.assign(3, 1.0F);
  CHECK(letters_of(two.judge(3, true)) == "SSS");
}

TEST_CASE("first_available: a member that did not run is reset before its next turn, others never") {
  TwoMembers two({"UUU", "UUU", "SSS", "SSS", "UUU", "UUU"}, {"D", "D", "D", "D", "D", "D"});
  std::vector<std::string> logs;
  for (int id = 0; id < 6; ++id) two.judge(id), logs.push_back(two.log);
  CHECK(logs == std::vector<std::string>{"ab", "ab", "a", "a", "areset-bb", "ab"});
  two.pipeline->reset();
  CHECK(two.log == "abreset-areset-b");
  two.judge(0);
  CHECK(two.log == "ab");
}

TEST_CASE("later stages of a sequence see survivors only, and suspects are no seeds") {
  std::vector<std::string> log;
  judge(sequence(stage(says("a", "DPSU")), watch(log), watch(log)), 4);
  CHECK(log == std::vector<std::string>{"-Pss", "-Pss"});
}

TEST_CASE("members of any do not see each other; members of all see who is still in question") {
  std::vector<std::string> log;
  judge(any(stage(says("a", "DSU")), watch(log)), 3);
  judge(all(stage(says("a", "DSU")), watch(log)), 3);
  CHECK(log == std::vector<std::string>{"sss", "P-s"});
}

TEST_CASE("what an inner sequence suspects is not seen outside of it, but its verdict is") {
  std::vector<std::string> log;
  judge(any(sequence(stage(says("a", "DP")), stage(says("b", "UU"))), watch(log)), 2);
  judge(sequence(sequence(stage(says("a", "DP"))), watch(log)), 2);
  CHECK(log == std::vector<std::string>{"ss", "-P"});
}

TEST_CASE("reasons name the leaves that said dynamic, and only where the verdict is dynamic") {
  const Verdict verdict =
      judge(any(all(stage(says("a", "DDS")), stage(says("b", "DSS"))), stage(says("c", "DDS"))), 3);
  CHECK(letters_of(verdict) == "DDS");
  CHECK(verdict.reason(0) == "a+b+c");
  CHECK(verdict.reason(1) == "c");
  CHECK(verdict.reason(2).empty());
}

TEST_CASE("a member without its inputs takes no part in any, is passed over in a sequence, blocks all") {
  const auto blind = [] {
    return stage(std::make_unique<Scripted>(
        "blind", [](const Evidence&, Votes& v) { v.cast(0, Vote::Dynamic); },
        Needs{Input::Depth, Input::None, 0}));
  };
  const Verdict in_any = judge(any(blind(), stage(says("a", "SUD"))), 3);
  CHECK(letters_of(in_any) == "SUD");
  CHECK(in_any.report.stages[1].skipped);
  CHECK(in_any.report.stages[1].note == "skipped: no depth");
  CHECK(letters_of(judge(sequence(blind(), stage(says("a", "SUD"))), 3)) == "SUD");
  CHECK(letters_of(judge(all(blind(), stage(says("a", "SUD"))), 3)) == "SUU");
  VoteParams counted;
  counted.min_votes = 2;
  CHECK(letters_of(judge(vote({}, blind(), stage(says("a", "SUD"))), 3)) == "SUD");
  CHECK(letters_of(judge(vote(counted, blind(), stage(says("a", "SUD"))), 3)) == "SUU");
  CHECK(letters_of(judge(vote({}, blind()), 3)) == "UUU");
}

TEST_CASE("a stage that throws is named and reported, and the frame goes on") {
  const auto thrower = [] {
    return stage(std::make_unique<Scripted>("thrower", [](const Evidence&, Votes& votes) {
      votes.cast(0, Vote::Dynamic);
      throw std::runtime_error("out of luck");
    }));
  };
  const Verdict verdict = judge(sequence(thrower(), stage(says("a", "SUD"))), 3);
  CHECK(letters_of(verdict) == "SUD");
  REQUIRE(verdict.report.stages.size() == 3);
  CHECK(verdict.report.stages[1].failed);
  CHECK(verdict.report.stages[1].name == "thrower");
  CHECK(verdict.report.stages[1].note == "failed: out of luck");
}

TEST_CASE("a filter that changes the number of votes is reported as failed") {
  const Verdict verdict = judge(
      sequence(stage(std::make_unique<Scripted>("resizer", [](const Evidence&, Votes& v) { v.reset(1); })),
               stage(says("a", "SUD"))),
      3);
  CHECK(letters_of(verdict) == "SUD");
  CHECK(verdict.report.stages[1].failed);
}

namespace {

/// Frames of a few features that the host tracks, with the votes of one member per frame.
struct Story {
  std::string letters;
  Pipeline pipeline;

  explicit Story(const TemporalParams& params = TemporalParams()) : pipeline(config(params)) {}

  std::string tell(std::int64_t id, const std::string& said,
                   const std::vector<std::int64_t>& map_points = {}) {
    letters = said;
    const Features features(said.size());
    std::vector<std::int32_t> same(said.size());
    for (std::size_t i = 0; i < same.size(); ++i) same[i] = static_cast<std::int32_t>(i);
    FrameView frame = features.view(id);
    frame.matches = HostMatches{id - 1, same};
    frame.map_point_ids = map_points;
    return letters_of(pipeline.before_pose(frame));
  }

 private:
  PipelineConfig config(const TemporalParams& params) {
    PipelineConfig result;
    result.floor.min_features = 0;
    result.before_pose =
        temporal(params, stage(std::make_unique<Scripted>("told", [this](const Evidence&, Votes& votes) {
                   for (std::size_t i = 0; i < letters.size(); ++i) {
                     if (letters[i] == 'S') votes.cast(i, Vote::Static);
                     if (letters[i] == 'D') votes.cast(i, Vote::Dynamic);
                   }
                 })));
    return result;
  }
};

}  // namespace

// Log-odds in steps of ln 3 with memory 0.8: three static votes are -1.10, -1.98, -2.68.
// A dynamic one gives -1.05, a second +0.26. An unknown one keeps 0.8 of the value.
TEST_CASE("temporal: one stray vote does not decide, two do, and unknown keeps what the past says") {
  Story story;
  CHECK(story.tell(0, "SSDU") == "SSDU");
  CHECK(story.tell(1, "SSDU") == "SSDU");
  CHECK(story.tell(2, "SSDU") == "SSDU");
  CHECK(story.tell(3, "DUUS") == "SSDS");
  CHECK(story.tell(4, "DUSD") == "DSDD");
  story.pipeline.reset();
  CHECK(story.tell(5, "UUUU") == "UUUU");
}

TEST_CASE("temporal: the belief goes with the map point, whichever feature sees it") {
  Story story;
  const std::vector<std::int64_t> first{7, 8, -1}, swapped{8, 7, -1};
  CHECK(story.tell(0, "DSD", first) == "DSD");
  CHECK(story.tell(1, "UUU", swapped) == "SDU");
}

// One vote is as sure as the threshold: it reaches the threshold, and 1.8 of it exceeds it.
TEST_CASE("temporal: a belief at the threshold is unknown, one above it is dynamic") {
  TemporalParams params;
  params.reliability = params.threshold = 0.75;
  params.memory = 0.8;
  Story story(params);
  CHECK(story.tell(0, "DS") == "US");
  CHECK(story.tell(1, "DS") == "DS");
}

TEST_CASE("temporal: bad parameters are named") {
  TemporalParams params;
  params.reliability = 0.4;
  CHECK_THROWS_AS(Story{params}, ConfigError);
}

}  // namespace combinators_test
