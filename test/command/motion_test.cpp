// SPDX-License-Identifier: MIT
#include "run_command.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

double f1_of(const std::string& json, const std::string& clip) {
  return number_in(json, "\"name\": \"" + clip + "\"", "f1");
}
double total_f1(const std::string& json, const std::string& what) {
  return number_in(json, "\"f1\": {", what);
}

/// JSON text; empty without the data.
std::string judged(const char* folder, const char* pipeline, const char* more = "") {
  const fs::path data = fs::path(DYNFILTER_DATA_DIR) / "motion" / folder;
  if (!fs::exists(data)) {
    MESSAGE("skipped: no ../shared/data");
    return "";
  }
  const CommandResult result =
      run_dynfilter("motion '" + data.string() + "' --json --pipeline " + pipeline + more);
  CAPTURE(result.err);
  CHECK(result.exit_code == 0);
  return result.out;
}

}  // namespace

TEST_CASE("motion counts verdicts at the last visible frame") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "clip.txt").string();
  write_text(file, "# Any clip\n# points 2 frames 2 width 640 height 480\n1 1 2 3 4\n2 5 6 7 8\n");
  const CommandResult none = run_dynfilter("motion " + file + " --pipeline none");
  CHECK(none.exit_code == 0);
  CHECK(contains(none.out, "clip"));
  CHECK(contains(none.out, "label > 1"));
  const std::string json = run_dynfilter("motion --json " + folder.path().string() + " --pipeline none").out;
  CHECK(contains(json, "\"recall\": 0.0"));
  CHECK(contains(json, "\"precision\": null"));
  CHECK(contains(json, "\"positives\": 1"));
  CHECK(
      contains(run_dynfilter("motion --json --positive mismatches -p none " + file).out, "\"positives\": 0"));
}

// Of label 1 and 2: three points that stand and one that moves, and the other way round; or none of label 2.
std::string clip_text(bool with_mover) {
  std::string text = "# Any clip\n# points 4 frames 3 width 640 height 480\n";
  for (int p = 0; p < 4; ++p) text += std::string(p == 3 && with_mover ? "2" : "1") + " 10 10 20 20 30 30\n";
  return text;
}

TEST_CASE("motion: precision, recall and F1 where nothing is rejected or nothing is to be found") {
  const TemporaryFolder folder;
  write_text(folder.path() / "a.txt", clip_text(true));
  write_text(folder.path() / "b.txt", clip_text(false));
  const CommandResult text = run_dynfilter("motion " + folder.path().string() + " -p none");
  CAPTURE(text.out);
  CHECK(text.exit_code == 0);
  CHECK(!contains(text.out, "nan"));
  CHECK(contains(text.out, "precision is not defined: nothing is rejected in any file\n"));
  CHECK(contains(text.out, "* recall over 1 of 2 files: in the others nothing is to be found\n"));
  const std::string json = run_dynfilter("motion --json " + folder.path().string() + " -p none").out;
  CHECK(number_in(json, "\"name\": \"a\"", "f1") == 0);  // something to find, nothing rejected
  CHECK(number_in(json, "\"name\": \"b\"", "f1") == 1);  // nothing to find, nothing rejected
  CHECK(number_in(json, "\"precision\": {", "files") == 0);
  CHECK(number_in(json, "\"recall\": {", "files") == 1);
  CHECK(number_in(json, "\"f1\": {", "mean") == 0.5);
}

TEST_CASE("motion with a pipeline whose stages were all skipped says so and fails") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "clip.txt").string(),
                    pipeline = (folder.path() / "p.yaml").string();
  write_text(file, clip_text(true));
  write_text(pipeline,
             "%YAML:1.0\n---\npipeline:\n  before_pose:\n    - semantic_box: { role: reject }\n"
             "    - depth_consistency\n");
  const CommandResult result = run_dynfilter("motion " + file + " -p " + pipeline);
  CAPTURE(result.err);
  CHECK(result.exit_code == 1);
  CHECK(contains(result.err, "all stages were skipped in all frames"));
  CHECK(contains(result.err, "semantic_box: skipped: no boxes"));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  write_text(pipeline, "%YAML:1.0\n---\npipeline:\n  after_pose:\n    - depth_consistency\n");
  const CommandResult never = run_dynfilter("motion " + file + " -p " + pipeline);
  CHECK(never.exit_code == 1);
  CHECK(contains(never.err, "no stage at before_pose"));
  // One that is not skipped is enough.
  write_text(
      pipeline,
      "%YAML:1.0\n---\npipeline:\n  before_pose:\n    - semantic_box: { role: reject }\n    - epipolar\n");
  const CommandResult some = run_dynfilter("motion " + file + " -p " + pipeline);
  CHECK(some.exit_code == 0);
  CHECK(contains(some.err, "every point of every frame is unknown"));
}

TEST_CASE("motion refuses bad input with one line") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "clip.txt").string();
  check_refused("motion", "TRACKS is required");
  check_refused("motion nowhere.txt --pipeline none", "nowhere.txt: no such file");
  check_refused("motion " + folder.path().string() + " --pipeline none", "holds no track files");
  write_text(file, "# points 1 frames 1 width 640 height 480\n1 2 3\n");
  check_refused("motion " + file + " --pipeline nonsense", "nonsense");
  write_text(file, "1 2 3\n");
  check_refused("motion " + file + " --pipeline none", "clip.txt: expected the header");
  write_text(file, "# points 1 frames 1 width 640 height 480\n1 2\n");
  check_refused("motion " + file + " --pipeline none", "clip.txt:2: expected a label");
}

TEST_CASE("dynfilter_mono on the KT3DMoSeg clips, movers against background: the goals" *
          doctest::test_suite("shared_data")) {
  const std::string json = judged("kt3dmoseg", "dynfilter_mono");
  if (json.empty()) return;
  CHECK(total_f1(json, "mean") >= 0.93);
  CHECK(total_f1(json, "median") >= 0.93);
  // In no clip is the background mistaken for the mover.
  CHECK(total_f1(json, "min") >= 0.85);
  CHECK(f1_of(json, "seq028_clip02") >= 0.85);  // 14 of 187 points move
  CHECK(f1_of(json, "seq095_clip01") >= 0.90);  // 81 % of the points move
}

// Gaps are times: for a clip declared at half or twice the rate, half or twice as many frames are used.
TEST_CASE("dynfilter_mono on the KT3DMoSeg clips does not hang on the frame rate" *
          doctest::test_suite("shared_data")) {
  for (const char* rate : {" --rate-hz 5", " --rate-hz 7", " --rate-hz 14", " --rate-hz 20"}) {
    CAPTURE(rate);
    const std::string json = judged("kt3dmoseg", "dynfilter_mono", rate);
    if (json.empty()) return;
    CHECK(total_f1(json, "mean") >= 0.90);
  }
}

TEST_CASE("dynfilter_mono on the Hopkins155 clips, all but the widest motion: the goals" *
          doctest::test_suite("shared_data")) {
  const std::string json = judged("hopkins155", "dynfilter_mono");
  if (json.empty()) return;
  CHECK(total_f1(json, "mean") >= 0.80);
  CHECK(total_f1(json, "median") >= 0.90);
}

TEST_CASE("multi_model, a plugin, on the AdelaideRMF pairs: the goals" * doctest::test_suite("shared_data")) {
  const std::string json = judged("adelaide_rmf", DYNFILTER_SOURCE_DIR "/examples/multi_model/mismatch.yaml",
                                  " --plugin " DYNFILTER_MULTI_MODEL_PLUGIN);
  if (json.empty()) return;
  CHECK(total_f1(json, "mean") >= 0.97);
  CHECK(total_f1(json, "min") >= 0.93);
}
