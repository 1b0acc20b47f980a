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
  CHECK(run_dynfilter("--help").exit_code == 0);
  CHECK(contains(run_dynfilter("eval --help").out, "GROUNDTRUTH"));
  CHECK(contains(run_dynfilter("--version").out, "."));
  check_refused("", "subcommand");
  check_refused("evil", "unknown subcommand `evil` (did you mean `eval`?); known subcommands: filters, ");
  CHECK(run_dynfilter("help").out == run_dynfilter("--help").out);
  CHECK(run_dynfilter("help eval").out == run_dynfilter("eval --help").out);
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
  const CommandResult result = run_dynfilter("eval " + truth + " " + truth);
  CHECK(result.exit_code == 0);
  CHECK(result.err.empty());
  CHECK(contains(result.out, "compared_pose_pairs 20 pairs\nabsolute_translational_error.rmse 0.000000 m\n"));
  CHECK(contains(run_dynfilter("eval --json " + truth + " " + truth).out, "\"pairs\": 20"));
  check_refused("eval " + truth + " " + later, "share 0 timestamps");
  check_refused("eval " + truth + " nowhere.txt", "nowhere.txt: no such file");
  write_text(later, "50 1 2\n");
  check_refused("eval " + truth + " " + later, "later.txt:1: expected");
  write_text(later, "");
  check_refused("eval " + truth + " " + later, "later.txt: contains no pose");
}

namespace {

// The arc as KITTI and EuRoC write it: 12 numbers without stamps, and nanoseconds with qw first.
std::string kitti_arc() {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    const double a = 0.1 * i;
    text += "1 0 0 " + std::to_string(std::cos(a)) + " 0 1 0 " + std::to_string(std::sin(a)) + " 0 0 1 0\n";
  }
  return text;
}
std::string euroc_arc() {
  std::string text = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], ...\n";
  for (int i = 0; i < 20; ++i) {
    const double a = 0.1 * i;
    text += std::to_string(50000000000LL + 100000000LL * i) + "," + std::to_string(std::cos(a)) + "," +
            std::to_string(std::sin(a)) + ",0,1,0,0,0,0.1,0.2,0.3\n";
  }
  return text;
}

}  // namespace

TEST_CASE("eval reads KITTI and EuRoC files, and says when stamps look like nanoseconds") {
  const TemporaryFolder folder;
  const auto file = [&](const char* name, const std::string& text) {
    write_text(folder.path() / name, text);
    return (folder.path() / name).string();
  };
  const std::string tum = file("tum.txt", arc(0)), kitti = file("kitti.txt", kitti_arc()),
                    euroc = file("euroc.csv", euroc_arc());
  const std::string none = "absolute_translational_error.rmse 0.000000 m\n";
  const CommandResult self = run_dynfilter("eval " + kitti + " " + kitti);
  CHECK(self.exit_code == 0);
  CHECK(contains(self.out, none));
  CHECK(contains(self.out, "compared_pose_pairs 20 pairs"));
  CHECK(contains(self.out, "# " + kitti + ": KITTI poses have no stamps: ten a second are assumed"));
  CHECK(contains(run_dynfilter("eval " + tum + " " + euroc).out, none));
  CHECK(contains(run_dynfilter("eval " + euroc + " " + tum + " --json").out, "\"pairs\": 20"));
  // KITTI's poses against stamped ones need their times.
  check_refused("eval " + tum + " " + kitti, "--times gives the stamps of KITTI's poses");
  std::string times;
  for (int i = 0; i < 20; ++i) times += std::to_string(50 + 0.1 * i) + "\n";
  const std::string stamps = file("times.txt", times);
  CHECK(contains(run_dynfilter("eval " + tum + " " + kitti + " --times " + stamps).out, none));
  check_refused("eval " + tum + " " + kitti + " --times nowhere.txt", "--times nowhere.txt: no such file");
  check_refused("eval " + tum + " " + kitti + " --times " + file("short.txt", "1\n2\n"),
                "20 poses, but only 2 times");
  // TUM's fields with nanoseconds, as ORB-SLAM3 writes for EuRoC.
  std::string nanoseconds;
  std::istringstream lines(arc(0));
  for (std::string stamp_s, rest; lines >> stamp_s && std::getline(lines, rest);)
    nanoseconds += std::to_string(std::llround(1e9 * std::stod(stamp_s))) + rest + "\n";
  const CommandResult ns = run_dynfilter("eval " + tum + " " + file("ns.txt", nanoseconds));
  CHECK(ns.exit_code == 0);
  CHECK(contains(ns.out, none));
  CHECK(contains(ns.out, "ns.txt: the stamps look like nanoseconds and are read as such\n"));
  check_refused("eval " + tum + " " + file("bad.txt", "1 2 3 4 5 6 7 8 9 10 11 12\n"),
                "bad.txt:1: is not a rotation and a translation");
  check_refused("eval " + tum + " " + tum + " --format kitti", "tum.txt:1: expected the 12 numbers");
}

TEST_CASE("eval prints the lines that the TUM tools printed for DynaSLAM" *
          doctest::test_suite("shared_data")) {
  const fs::path data = fs::path(DYNFILTER_DATA_DIR) / "trajectories";
  if (!fs::exists(data)) {
    MESSAGE("skipped: no ../shared/data");
    return;
  }
  for (const char* name : {"fr3_sitting_static", "fr3_walk_static", "fr3_walk_xyz"}) {
    const fs::path folder = data / name;
    const CommandResult result = run_dynfilter("eval '" + (folder / "groundtruth.txt").string() + "' '" +
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
