// SPDX-License-Identifier: MIT
#include <algorithm>
#include <sstream>
#include <vector>

#include "run_command.hpp"
#include "walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

const std::vector<std::string>& subcommands() {
  static const std::vector<std::string> names{"filters", "check", "presets",    "synth", "run",  "replay",
                                              "compare", "bench", "map",        "masks", "eval", "detect",
                                              "motion",  "serve", "completion", "man"};
  return names;
}

/// The longest line that has a blank to break it at.
std::size_t longest_line(const std::string& text) {
  std::size_t longest = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.find('/') == std::string::npos) longest = std::max(longest, line.size());
  return longest;
}

CommandResult shell(const std::string& command) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string();
  const int status = std::system(("( " + command + " ) >" + out + " 2>&1").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(out), ""};
}

bool has_program(const std::string& name) {
  return shell("command -v " + name).exit_code == 0;
}

std::string walking() {
  return "'" + Walking::shared().folder().string() + "'";
}

}  // namespace

TEST_CASE("help, lists and tables fit 80 columns, or what COLUMNS says") {
  for (const std::string& name : subcommands()) {
    CAPTURE(name);
    CHECK(longest_line(run_dynfilter("help " + name).out) <= 80);
    CHECK(contains(run_dynfilter("help " + name).out, "Usage: dynfilter " + name));
  }
  CHECK(longest_line(run_dynfilter("--help").out) <= 80);
  for (const std::string what : {"presets", "filters", "filters background_motion", "filters by_region",
                                 "check dynfilter", "check rts_slam"}) {
    CAPTURE(what);
    CHECK(longest_line(run_dynfilter(what).out) <= 80);
  }
  const CommandResult narrow = shell("COLUMNS=60 '" DYNFILTER_COMMAND "' help run");
  CHECK(longest_line(narrow.out) <= 60);
  CHECK(longest_line(shell("COLUMNS=160 '" DYNFILTER_COMMAND "' help run").out) > 100);
}

TEST_CASE("an unknown option or scene: the nearest name, also where another option is missing") {
  const std::string run = "run " + walking();
  check_refused(run + " --pipline none", "unknown option `--pipline` (did you mean `--pipeline`?)");
  check_refused(run + " --pipeline none --frmes=3", "unknown option `--frmes` (did you mean `--frames`?)");
  check_refused(run + " --pipeline none --colour",
                "unknown option `--colour`; `dynfilter help run` lists them");
  check_refused("synth walking_xzy /no/such/folder",
                "unknown scene `walking_xzy` (did you mean `walking_xyz`?)");
}

TEST_CASE("control characters of a file do not reach the terminal with an error") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "poses.txt";
  write_text(file, "1.0 x\x1b[31m\xc2\x9b 0 0 0 0 0 1\n");
  check_refused("eval '" + file.string() + "' '" + file.string() + "'",
                "poses.txt:1: 'x?[31m\?\?' is not a number");
}

TEST_CASE("compare: as wide as the terminal, all columns on request, none without an entry") {
  const std::string compare = "compare " + walking() + " --pipelines none,rts_slam_s";
  const CommandResult narrow = run_dynfilter(compare);
  CAPTURE(narrow.out);
  CHECK(longest_line(narrow.out) <= 80);
  CHECK(contains(narrow.out, "\nNot shown: "));
  for (const char* column : {"tracked", "ATE m", "recall", "kept"}) CHECK(contains(narrow.out, column));
  const CommandResult wide = run_dynfilter(compare + " --wide");
  for (const char* column : {"sequence", "precision", "features", "rejected", "filters ms"}) {
    CAPTURE(column);
    CHECK(contains(wide.out, column));
  }
  CHECK(!contains(wide.out, "Not shown"));
  CHECK(!contains(wide.out, "RPE"));  // shorter than a second: no row has one
}

TEST_CASE("compare: medians are of one scene, never over several") {
  const TemporaryFolder folder;
  const std::string other = (folder.path() / "desk").string();
  REQUIRE(run_dynfilter("synth static_desk " + other + " --frames 14 --no-right").exit_code == 0);
  const std::string both = "compare " + walking() + " " + other + " --pipelines none --frames 3";
  const CommandResult one_each = run_dynfilter(both);
  CHECK(one_each.exit_code == 0);
  CHECK(!contains(one_each.out, "median"));
  const CommandResult json = run_dynfilter(both + " --json --variants");
  CAPTURE(json.err);
  const std::string medians = json.out.substr(json.out.find("\"medians\""));
  CHECK(contains(medians, "\"scene\": \"walking_static\""));
  CHECK(contains(medians, "\"scene\": \"static_desk\""));
  CHECK(!contains(medians, "\"runs\": 12"));
}

TEST_CASE("run and compare --verbose say what each stage did, and summary.json has it") {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string();
  const std::string run = "run " + walking() + " --pipeline dynaslam --no-masks --frames 5 ";
  const CommandResult text = run_dynfilter(run + "--out " + out);
  CAPTURE(text.out);
  REQUIRE(text.exit_code == 0);
  CHECK(longest_line(text.out) <= 80);
  for (const char* part : {"judged", "dynamic", "unknown", "skipped", " ms\n", "  sequence (before_pose)",
                           "\n    semantic_mask ", "\n  - semantic_mask: skipped: no mask (5 frames)\n"}) {
    CAPTURE(part);
    CHECK(contains(text.out, part));
  }
  const std::string summary = read_text(fs::path(out) / "summary.json");
  CHECK(number_in(summary, "\"name\": \"semantic_mask\"", "skipped") == 5);
  CHECK(number_in(summary, "\"note\": \"skipped: no mask\"", "frames") == 5);
  CHECK(number_in(summary, "\"name\": \"semantic_mask\"", "judged") ==
        number_in(summary, "", "features_mean"));
  CHECK(number_in(summary, "\"call_point\": \"after_pose\"", "ms") > 0);
  const CommandResult verbose =
      run_dynfilter("compare " + walking() + " --pipelines dynaslam --no-masks --frames 5 --verbose");
  CHECK(contains(verbose.out, "\ndynaslam on walking\n"));
  CHECK(contains(verbose.out, "\n  - semantic_mask: skipped: no mask (5 frames)\n"));
}

TEST_CASE("run: results of another run are replaced only with --force") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const std::string run = "run " + walking() + " --frames 3 --out '" + out.string() + "' --pipeline ";
  fs::create_directories(out);
  write_text(out / "notes.txt", "mine");  // a folder with other things is fine
  REQUIRE(run_dynfilter(run + "none").exit_code == 0);
  const std::string before = read_text(out / "summary.json");
  check_refused(run + "oracle", "holds the results of another run (summary.json)");
  check_refused(run + "oracle", "--force");
  CHECK(read_text(out / "summary.json") == before);
  REQUIRE(run_dynfilter(run + "oracle --force").exit_code == 0);
  CHECK(read_text(out / "summary.json") != before);
  CHECK(read_text(out / "notes.txt") == "mine");
}

TEST_CASE("a run in which every feature is unknown says so, and which option helps") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "p.yaml").string();
  write_text(
      file,
      "%YAML:1.0\n---\npipeline:\n  name: boxes\n  before_pose:\n    - semantic_box: { role: reject }\n");
  const std::string run = "run " + walking() + " --frames 3 --pipeline ";
  const std::string note = "every feature of every frame is unknown";
  const std::string json = run_dynfilter(run + file + " --no-detections --json").out;
  CHECK(contains(json, note));
  CHECK(contains(json, "semantic_box: skipped: no boxes); boxes come from --detections or --detector"));
  CHECK(contains(run_dynfilter(run + file + " --no-detections").out, "note: every feature of every frame"));
  CHECK(!contains(run_dynfilter(run + file + " --json").out, note));
  CHECK(!contains(run_dynfilter(run + "none --json").out, note));  // nothing was to be judged
}

TEST_CASE("frames from associated.txt are documented and said") {
  const TemporaryFolder folder;
  const fs::path copy = folder.path() / "copy";
  fs::copy(Walking::shared().folder(), copy, fs::copy_options::recursive);
  fs::rename(copy / "associations.txt", copy / "associated.txt");
  const CommandResult result = run_dynfilter("run '" + copy.string() + "' --pipeline none --frames 3 --json");
  CHECK(contains(result.out, "frames from associated.txt, not from rgb.txt and depth.txt"));
  CHECK(contains(run_dynfilter("help run").out, "associated.txt"));
}

TEST_CASE("presets come from DYNFILTER_PRESETS, too") {
  const TemporaryFolder folder;
  write_text(folder.path() / "mine.yaml", "%YAML:1.0\n---\npipeline:\n  name: mine\n  about: \"My own.\"\n");
  const std::string command = "DYNFILTER_PRESETS='" + folder.path().string() + "' '" DYNFILTER_COMMAND "' ";
  CHECK(contains(shell(command + "check mine").out, "mine: well formed"));
  CHECK(contains(shell(command + "presets").out, "\n  mine\n    My own.\n"));
  CHECK(contains(shell(command + "check min").out, "did you mean `mine`?"));
  check_refused("check mine", "neither a file nor a preset");
}

TEST_CASE("completion scripts are scripts, and complete") {
  const TemporaryFolder folder;
  const std::string bash = (folder.path() / "dynfilter.bash").string(),
                    zsh = (folder.path() / "_dynfilter").string();
  write_text(bash, run_dynfilter("completion bash").out);
  write_text(zsh, run_dynfilter("completion zsh").out);
  CHECK(shell("bash -n " + bash).out.empty());
  CHECK(read_text(zsh).rfind("#compdef dynfilter\n", 0) == 0);
  if (has_program("zsh")) CHECK(shell("zsh -n " + zsh).out.empty());
  const auto completed = [&](const std::string& words) {
    const std::string line =
        "source " + bash + "; COMP_WORDS=(" + words +
        "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _dynfilter; echo \" ${COMPREPLY[*]} \"";
    write_text(folder.path() / "try.bash", line);
    return shell("bash " + (folder.path() / "try.bash").string()).out;
  };
  const std::string program = "'" DYNFILTER_COMMAND "' ";
  for (const std::string& name : subcommands()) CHECK(contains(completed(program + "''"), " " + name + " "));
  CHECK(completed(program + "run --pipeline rts_slam_p") == " rts_slam_published \n");
  CHECK(completed(program + "compare --pipelines none,orac") == " none,oracle \n");
  CHECK(completed(program + "run --cam") == " --camera \n");
  CHECK(completed(program + "run --json --cam") == " --camera \n");  // a flag takes no value
  CHECK(contains(read_text(zsh), " '--json[print JSON]'"));
  CHECK(!contains(read_text(zsh), "$1:"));  // in zsh `$1:c` is the path of the command $1
  CHECK(completed(program + "motion --positive mism") == " mismatches \n");
  CHECK(completed(program + "synth walking_x") == " walking_xyz \n");
  CHECK(completed(program + "filters trajec") == " trajectory_consistency \n");
}

TEST_CASE("manual pages come from the options, a page for each subcommand, and roff accepts them") {
  const TemporaryFolder folder;
  const fs::path made = folder.path() / "share" / "man1";  // neither exists
  REQUIRE(run_dynfilter("man '" + made.string() + "'").exit_code == 0);
  write_text(folder.path() / "file", "");
  check_refused("man '" + (folder.path() / "file" / "man1").string() + "'", "no folder can be made there");
  int pages = 0;
  for (const auto& entry : fs::directory_iterator(made)) {
    CAPTURE(entry.path().string());
    ++pages;
    if (has_program("groff"))
      CHECK(shell("groff -man -Tutf8 -ww -z '" + entry.path().string() + "'").out.empty());
  }
  CHECK(pages == static_cast<int>(subcommands().size()) + 1);
  const std::string run = read_text(made / "dynfilter-run.1");
  for (const char* part : {".SH NAME\ndynfilter\\-run \\- ", "\\fB\\-\\-camera FILE\\fR", ".SH SYNOPSIS",
                           "\\fISEQUENCE\\fR", ".SH EXIT STATUS"}) {
    CAPTURE(part);
    CHECK(contains(run, part));
  }
  CHECK(contains(read_text(made / "dynfilter.1"), "DYNFILTER_PRESETS"));
}

TEST_CASE("run, map and motion take the default pipeline") {
  const TemporaryFolder folder;
  const std::string json = run_dynfilter("run " + walking() + " --frames 3 --json").out;
  CHECK(value_of(json, "pipeline") == "\"dynfilter\"");
  for (const char* name : {"run", "map", "motion"})
    CHECK(contains(shell(std::string("COLUMNS=300 '" DYNFILTER_COMMAND "' help ") + name).out,
                   "default dynfilter"));
  const CommandResult map =
      run_dynfilter("map " + walking() + " '" + (Walking::shared().folder() / "groundtruth.txt").string() +
                    "' --frames 3 --keyframes every:1 --map '" + (folder.path() / "m.ply").string() + "'");
  CHECK(map.out.rfind("dynfilter on walking", 0) == 0);
}

TEST_CASE("the help lists every subcommand, also those for packages") {
  const std::string help = run_dynfilter("--help").out;
  for (const std::string& name : subcommands()) CHECK_MESSAGE(contains(help, "\n  " + name + " "), name);
}

TEST_CASE("run: above the table and in it, times are medians and are called that") {
  const CommandResult text = run_dynfilter("run " + walking() + " --pipeline rts_slam_s --frames 8");
  CAPTURE(text.out);
  CHECK(contains(text.out, "  median time   "));
  CHECK(contains(text.out, "  median CPU    "));
  CHECK(contains(text.out, "  median ms\n"));
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  REQUIRE(run_dynfilter("run " + walking() + " --pipeline rts_slam_s --frames 9 --out '" + out.string() + "'")
              .exit_code == 0);
  // The median by hand, of an odd number of frames.
  std::istringstream lines(read_text(out / "frames.csv"));
  std::string line;
  std::getline(lines, line);
  const auto column = [&](const std::string& name) {
    std::istringstream heads(line);
    std::string head;
    for (int k = 0; std::getline(heads, head, ','); ++k)
      if (head == name) return k;
    return -1;
  };
  const int total = column("total_ms"), cpu = column("cpu_ms");
  REQUIRE(total > 0);
  REQUIRE(cpu > 0);
  std::vector<double> totals, cpus;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (int k = 0; std::getline(cells, cell, ','); ++k) {
      if (k == total) totals.push_back(std::stod(cell));
      if (k == cpu) cpus.push_back(std::stod(cell));
    }
  }
  REQUIRE(totals.size() == 9);
  std::sort(totals.begin(), totals.end());
  std::sort(cpus.begin(), cpus.end());
  const std::string summary = read_text(out / "summary.json");
  CHECK(number_in(summary, "\"ms\": {", "total") == doctest::Approx(totals[4]).epsilon(1e-3));
  CHECK(number_in(summary, "\"cpu_ms\": {", "total") == doctest::Approx(cpus[4]).epsilon(1e-3));
  CHECK(contains(summary, "\"ms_mean\""));
}

TEST_CASE("on a terminal the progress says which run it is and how long it takes") {
  if (!has_program("script")) {
    MESSAGE("skipped: no `script`");
    return;
  }
  const TemporaryFolder folder;
  const std::string log = (folder.path() / "log").string();
  shell("script -qec \"'" DYNFILTER_COMMAND "' compare " + walking() +
        " --variants --pipelines none,rts_slam\" '" + log + "' </dev/null");
  const std::string text = read_text(log);
  CHECK(contains(text, "none on walking ["));
  CHECK(contains(text, "run 1 of 12"));
  CHECK(contains(text, "run 12 of 12"));
  CHECK(contains(text, "s left"));
}
