// SPDX-License-Identifier: MIT
#include <cstring>
#include <vector>

#include "run_command.hpp"
#include "walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

const fs::path& folder() {
  return Walking::shared().folder();
}
std::string truth() {
  return (folder() / "groundtruth.txt").string();
}
std::string map_command(const std::string& trajectory, const fs::path& file, const std::string& more) {
  return "map '" + folder().string() + "' '" + trajectory + "' --map '" + file.string() + "' " + more;
}

std::vector<std::string> poses() {
  std::vector<std::string> lines;
  std::stringstream text(read_text(truth()));
  for (std::string line; std::getline(text, line);)
    if (!line.empty() && line[0] != '#') lines.push_back(line);
  return lines;
}

std::size_t entries(const fs::path& in) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(in), fs::directory_iterator()));
}

}  // namespace

TEST_CASE("map: from given poses, judged by the scene, as PLY with classes") {
  const TemporaryFolder out;
  const fs::path file = out.path() / "map.ply";
  const std::string how = " --keyframes every:4 --frames 9 --truth --json ";  // frames 0, 4, 8
  const CommandResult all = run_dynfilter(map_command(
      truth(), file, "--pipeline none" + how + "--map-full '" + (out.path() / "full.ply").string() + "'"));
  CAPTURE(all.err);
  REQUIRE(all.exit_code == 0);
  CHECK(value_of(all.out, "frames_offered") == "9");
  CHECK(value_of(all.out, "keyframes") == "3");
  CHECK(entries(out.path()) == 3);
  const std::string full = read_text(out.path() / "full.ply"), full_points = value_of(all.out, "full_points");
  CHECK(full.rfind("ply\nformat binary_little_endian 1.0\nelement vertex " + full_points + "\n", 0) == 0);
  const std::string ply = read_text(file), points = value_of(all.out, "points");
  CHECK(ply.rfind("ply\nformat binary_little_endian 1.0\nelement vertex " + points + "\n", 0) == 0);
  CHECK(ply.size() == ply.find("end_header\n") + 11 + std::stoul(points) * 19);
  std::int32_t least = 255, most = 0;
  for (std::size_t at = ply.find("end_header\n") + 11 + 15; at < ply.size(); at += 19) {
    std::int32_t label = 0;
    std::memcpy(&label, ply.data() + at, 4);
    least = std::min(least, label), most = std::max(most, label);
  }
  CHECK(least == 0);
  CHECK(most > 0);
  CHECK(most <= 7);

  const CommandResult still =
      run_dynfilter(map_command(truth(), file, "--pipeline oracle" + how + "--map-leaf-m 0.04"));
  REQUIRE(still.exit_code == 0);
  const auto share = [](const CommandResult& r, const char* key) { return std::stod(value_of(r.out, key)); };
  CHECK(share(all, "ghosts") > 0.02);
  CHECK(share(still, "ghosts") < 0.002);
  CHECK(share(still, "coverage_of_oracle") > 0.99);
  CHECK(share(still, "error_median_m") < 0.02);
  CHECK(std::stoul(value_of(still.out, "points")) < std::stoul(points) / 2);
}

TEST_CASE("map: gaps, repeated and decreasing stamps are survived and said") {
  const TemporaryFolder out;
  const std::vector<std::string> given = poses();
  REQUIRE(given.size() == 14);
  std::string text;
  for (std::size_t i = 0; i < 14; ++i)
    if (i < 6 || i > 9) text += given[i] + "\n";  // the gap from 5 to 10 is too long to interpolate
  write_text(out.path() / "odd.txt", text + given[2] + "\n");
  const CommandResult r = run_dynfilter(map_command((out.path() / "odd.txt").string(), out.path() / "map.ply",
                                                    "--pipeline none --keyframes own --map-leaf-m 0.1"));
  CAPTURE(r.err);
  CAPTURE(r.out);
  REQUIRE(r.exit_code == 0);
  CHECK(contains(r.out, "10 with a pose"));
  CHECK(contains(r.out, "4 of 14 frames have no pose and are left out"));
  CHECK(contains(r.out, "odd.txt: 1 repeated stamp"));
  CHECK(contains(r.out, "odd.txt: 1 stamp goes back"));
}

TEST_CASE("map: what cannot be done is said in one line, and nothing is left behind") {
  const TemporaryFolder out;
  const fs::path file = out.path() / "map.ply";
  const auto refused = [&](const std::string& trajectory, const std::string& more, const std::string& why) {
    check_refused(map_command(trajectory, file, "--pipeline none " + more), why);
  };
  refused("/no/such/file.txt", "", "/no/such/file.txt: no such file");
  refused(truth(), "--map-leaf-m 0", "--map-leaf-m 0: expected 0.001 to 5 m");
  refused(truth(), "--map-leaf-m 7", "--map-leaf-m 7: expected 0.001 to 5 m");
  refused(truth(), "--keyframes every:0", "every:0: expected every:N");
  const fs::path config = out.path() / "map.yaml";
  write_text(config, "mapping: { carve: 3 }\n");
  refused(truth(), "--map-config '" + config.string() + "'", "map.yaml: mapping.carve: expected");
  fs::remove(config);
  const TemporaryFolder tum;
  write_tum_folder(tum.path(), 2);
  check_refused("run '" + tum.path().string() + "' --pipeline none --map '" + file.string() + "' --truth",
                "--truth needs a sequence that synth wrote");
  refused(truth(), "--keyframes best",
          "unknown rule `best`; known rules: own, every:N, pose_change, vertex_cover");
  check_refused(map_command(truth(), "/no/such/map.ply", "--pipeline none"), "/no/such: no such folder");
  CHECK(entries(out.path()) == 0);
  const fs::path other = out.path() / "other.txt";
  write_text(other, "5.0 0 0 0 0 0 0 1\n6.0 0 0 0 0 0 0 1\n");
  refused(other.string(), "", "no pose for any of the 14 frames (poses from 5.000 to 6.000 s, frames from ");
  CHECK(entries(out.path()) == 1);
}

TEST_CASE("map: a voxel as large as the scene is said; a full disk leaves the old map intact") {
  const TemporaryFolder out;
  const fs::path file = out.path() / "map.ply", picture = out.path() / "map.png";
  const std::string how = "--pipeline none --frames 2 --keyframes every:2 --map-leaf-m ";
  const CommandResult coarse = run_dynfilter(map_command(truth(), file, how + "5"));
  CHECK((contains(coarse.out, "a voxel of 5 m is about as large as all that was seen") ||
         contains(coarse.err, "the map is empty")));
  REQUIRE(run_dynfilter(map_command(truth(), file, how + "0.1")).exit_code == 0);
  const std::string old = read_text(file), old_picture = read_text(picture);
  // Simulates a full disk by a file size limit: the picture fits, the cloud does not.
  const std::string limited = "bash -c \"trap '' XFSZ; ulimit -f 800; exec '" DYNFILTER_COMMAND "' " +
                              map_command(truth(), file, how + "0.01") + "\" >/dev/null 2>" +
                              (out.path() / "err").string();
  const int status = std::system(limited.c_str());
  CHECK(WEXITSTATUS(status) == 2);
  CHECK(contains(read_text(out.path() / "err"), "map.ply: writing failed (disk full?)"));
  CHECK(read_text(file) == old);
  CHECK(read_text(picture) == old_picture);
  CHECK(entries(out.path()) == 3);
}
