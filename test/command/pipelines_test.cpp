// SPDX-License-Identifier: MIT
#include "run_command.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

TEST_CASE("filters lists rejectors and combinators, and prints a card") {
  const CommandResult list = run_dynfilter("filters");
  CHECK(list.exit_code == 0);
  for (const char* name :
       {"semantic_box", "epipolar", "trajectory_consistency", "oracle", "sequence", "by_region"}) {
    CAPTURE(name);
    CHECK(contains(list.out, name));
    const CommandResult card = run_dynfilter(std::string("filters ") + name);
    CHECK(card.exit_code == 0);
    CHECK(card.out.rfind(std::string(name) + ": ", 0) == 0);
    CHECK(run_dynfilter(std::string("filters --json ") + name).out[0] == '{');
  }
  const CommandResult card = run_dynfilter("filters semantic_box");
  CHECK(contains(card.out, "min_score"));
  CHECK(contains(card.out, "[0 to 1]"));
  CHECK(contains(run_dynfilter("filters --json").out, "\"combinators\""));
  check_refused("filters semantic_bo",
                "unknown filter `semantic_bo` (did you mean `semantic_box`?); known filters: ");
  check_refused("filters --plugin nowhere.so", "nowhere.so");
}

TEST_CASE("check prints the stages of every preset and what they need") {
  int presets = 0;
  for (const auto& entry :
       fs::directory_iterator(fs::path(DYNFILTER_SOURCE_DIR) / "examples" / "pipelines")) {
    if (entry.path().extension() != ".yaml") continue;
    const std::string name = entry.path().stem().string();
    CAPTURE(name);
    const CommandResult by_name = run_dynfilter("check " + name);
    CHECK(by_name.exit_code == 0);
    CHECK(by_name.err.empty());
    CHECK(by_name.out.rfind(name + ": well formed", 0) == 0);
    CHECK(run_dynfilter("check '" + entry.path().string() + "' --json").exit_code == 0);
    ++presets;
  }
  CHECK(presets >= 7);
  const CommandResult rts = run_dynfilter("check rts_slam");
  for (const char* part :
       {"before_pose", "semantic_box", "needs boxes", "epipolar", "trajectory_consistency"}) {
    CAPTURE(part);
    CHECK(contains(rts.out, part));
  }
}

TEST_CASE("the oracle says that it needs labels") {
  for (const std::string arguments :
       {"check oracle", "check oracle --json", "filters oracle", "filters oracle --json"})
    CHECK_MESSAGE(contains(run_dynfilter(arguments).out, "labels of the sequence"), arguments);
  CHECK(!contains(run_dynfilter("check dynfilter").out, "labels"));
}

TEST_CASE("check refuses bad pipelines with one line that says where and what") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "p.yaml").string();
  const auto refused = [&](const std::string& text, const std::string& reason) {
    write_text(file, text);
    CAPTURE(text);
    check_refused("check " + file, reason);
  };
  const std::string head = "%YAML:1.0\n---\npipeline:\n  name: p\n";
  refused("this is { not [ YAML", "p.yaml");
  refused("\x01\x02\xff\xfe", "p.yaml");
  refused("", "p.yaml");
  refused("%YAML:1.0\n---\nother: 1\n", "expected the key `pipeline`");
  refused(head + "  before_pose:\n    - epipolarr\n",
          "unknown filter `epipolarr` (did you mean `epipolar`?)");
  refused(head + "  before_pos:\n    - epipolar\n", "unknown key `before_pos` (did you mean `before_pose`?)");
  refused(head + "  before_pose:\n    - epipolar: { max_distance: 1.0 }\n",
          "unknown key `max_distance` (did you mean `max_distance_px`?)");
  refused(head + "  before_pose:\n    - epipolar: { max_distance_px: wide }\n", "max_distance_px");
  refused(head + "  before_pose:\n    - epipolar: { max_distance_px: -1.0 }\n", "max_distance_px");
  refused(head + "  before_pose:\n    - semantic_box: { role: maybe }\n",
          "expected one of prior, reject, got `maybe`");
  check_refused("check nowhere.yaml", "nowhere.yaml: no such pipeline file");
  check_refused("check nosuchpreset", "presets: ");
  check_refused("check rtsslam", "neither a file nor a preset (did you mean `rts_slam`?); presets: ");
  check_refused("check dynfiltr.yaml", "no such pipeline file (did you mean `dynfilter`?)");
  check_refused("check", "PIPELINE is required");
}

TEST_CASE("presets are listed with what they are about") {
  const CommandResult result = run_dynfilter("presets");
  CHECK(result.exit_code == 0);
  CHECK(contains(result.out, "\n  rts_slam\n    "));
  CHECK(contains(result.out, "\n  yolo_fastest\n"));
  CHECK(contains(result.out, "The default: rejects what moves against the background"));
  CHECK(contains(run_dynfilter("presets --json").out, "\"name\": \"dynfilter\""));
}
