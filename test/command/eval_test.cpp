// SPDX-License-Identifier: MIT
#include <cmath>
#include <sstream>

#include "run_command.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

// Twenty poses, ten a second, on the arc of a circle.
std::string arc(double offset_s) {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    const double a = 0.1 * i;
    text += stamp(50 + 0.1 * i + offset_s) + " " + std::to_string(std::cos(a)) + " " +
            std::to_string(std::sin(a)) + " 0 0 0 0 1\n";
  }
  return text;
}

}  // namespace

TEST_CASE("help and version: exit code 0; no subcommand or an unknown one: one line and 2") {
  CHECK(dynfilter("--help").exit_code == 0);
  CHECK(contains(dynfilter("eval --help").out, "GROUNDTRUTH"));
  CHECK(contains(dynfilter("--version").out, "."));
  check_refused("", "subcommand");
  check_refused("evil", "unknown subcommand 'evil' (did you mean `eval`?); there are: filters, ");
  CHECK(dynfilter("help").out == dynfilter("--help").out);
  CHECK(dynfilter("help eval").out == dynfilter("eval --help").out);
  check_refused("help evil", "did you mean `eval`?");
  check_refused("eval", "GROUNDTRUTH is required");
  check_refused("eval a b --bogus", "--bogus");
}

TEST_CASE("eval of a trajectory against itself, and its bad input") {
  const TemporaryFolder folder;
  const std::string truth = (folder.path() / "truth.txt").string(),
                    later = (folder.path() / "later.txt").string();
  write_text(truth, arc(0));
  write_text(later, arc(30));
  const CommandResult result = dynfilter("eval " + truth + " " + truth);
  CHECK(result.exit_code == 0);
  CHECK(result.err.empty());
  CHECK(contains(result.out, "compared_pose_pairs 20 pairs\nabsolute_translational_error.rmse 0.000000 m\n"));
  CHECK(contains(dynfilter("eval --json " + truth + " " + truth).out, "\"pairs\": 20"));
  check_refused("eval " + truth + " " + later, "share 0 timestamps");
  check_refused("eval " + truth + " nowhere.txt", "nowhere.txt: no such file");
  write_text(later, "50 1 2\n");
  check_refused("eval " + truth + " " + later, "later.txt:1: expected");
  write_text(later, "");
  check_refused("eval " + truth + " " + later, "later.txt: contains no pose");
}

TEST_CASE("eval prints the lines that the TUM tools printed for DynaSLAM") {
  const fs::path data = fs::path(DYNFILTER_DATA_DIR) / "trajectories";
  if (!fs::exists(data)) {
    MESSAGE("skipped: no ../shared/data");
    return;
  }
  for (const char* name : {"fr3_sitting_static", "fr3_walk_static", "fr3_walk_xyz"}) {
    const fs::path folder = data / name;
    const CommandResult result = dynfilter("eval '" + (folder / "groundtruth.txt").string() + "' '" +
                                           (folder / "dynaslam.txt").string() + "'");
    std::istringstream published(read_text(folder / "dynaslam_ate.txt") +
                                 read_text(folder / "dynaslam_rpe.txt"));
    int lines = 0;
    for (std::string line; std::getline(published, line);) {
      if (line == "Showing" || line.empty()) continue;  // the tool's plot window
      CAPTURE(line);
      CHECK(contains(result.out, line + "\n"));
      ++lines;
    }
    CHECK(lines == 20);
  }
}
