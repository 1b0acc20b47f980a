// SPDX-License-Identifier: MIT
#include <filesystem>
#include <fstream>
#include <string>

#include "run_command.hpp"
#include "walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

/// A data folder with a rendered sequence under the name of a recording.
class BenchData {
 public:
  BenchData() {
    fs::create_directories(data());
    fs::create_directory_symlink(Walking::shared().folder(),
                                 data() / "rgbd_dataset_freiburg3_walking_static");
  }
  fs::path data() const { return root_.path() / "data"; }
  fs::path out() const { return root_.path() / "out"; }
  std::string arguments(const std::string& manifest, const std::string& more) const {
    return "bench '" + manifest + "' --data '" + data().string() + "' --out '" + out().string() + "' " + more;
  }
  CommandResult run(const std::string& more) const { return run_dynfilter(arguments("tum_fr3", more)); }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(root_.path() / name) << text;
    return root_.path() / name;
  }

 private:
  TemporaryFolder root_;
};

/// Marks the result of a run, to see that it is not done again.
void mark(const fs::path& summary, const std::string& key, const std::string& value) {
  std::string text = read_text(summary);
  const std::size_t at = text.find("\"" + key + "\": ");
  REQUIRE(at != std::string::npos);
  const std::size_t begin = at + key.size() + 4;
  text.replace(begin, text.find_first_of(",\n", begin) - begin, value);
  std::ofstream(summary) << text;
}

/// The row of one system on one sequence.
std::string row_of(const std::string& json, const std::string& sequence, const std::string& system) {
  const std::string head = "\"sequence\": \"" + sequence + "\"";
  for (std::size_t at = json.find(head); at != std::string::npos; at = json.find(head, at + 1)) {
    const std::string row = json.substr(at, json.find('}', at) - at);
    if (contains(row, "\"system\": \"" + system + "\"")) return row;
  }
  return "";
}

}  // namespace

TEST_CASE("bench runs what is there, names what is missing and puts published figures beside") {
  const BenchData bench;
  const CommandResult result = bench.run("--pipelines none,oracle --frames 6 --json");
  CHECK(result.exit_code == 0);
  for (const char* system : {"none", "oracle"}) {
    const std::string row = row_of(result.out, "walking_static", system);
    CHECK(value_of(row, "frames") == "6");
    CHECK(value_of(row, "tracked_frames") == "6");
    CHECK(fs::is_regular_file(bench.out() / "walking_static" / system / "report.html"));
    const std::string summary = read_text(bench.out() / "walking_static" / system / "summary.json");
    CHECK(value_of(row, "ate_rmse_m") == value_of(summary, "ate_rmse_m"));
    CHECK(value_of(row_of(result.out, "walking_xyz", system), "state") == "\"missing\"");
  }
  const std::string paper = row_of(result.out, "walking_xyz", "DROID-W");
  CHECK(value_of(paper, "ate_rmse_m") == "0.012");
  CHECK(value_of(paper, "alignment") == "\"Sim(3)\"");
  const std::string page = read_text(bench.out() / "report.html");
  CHECK(contains(page, "<a href=\"walking_static/oracle/report.html\">oracle</a>"));
  CHECK(contains(page, "cvg.cit.tum.de"));
  // A system with both alignments: two rows, each with the digits of its source.
  CHECK(contains(page, "<td>SInDSLAM</td><td>SE(3)</td>"));
  CHECK(contains(page, "<td>SInDSLAM</td><td>Sim(3)</td>"));
  CHECK(contains(page, "<td>1.44</td>"));
  CHECK(contains(page, "class=\"best\">1.2</td>"));  // DROID-W, Sim(3)
  CHECK(contains(page, "<li>SInDSLAM, SE(3): TCSVT 2025, geometry alone, on a CPU"));
  CHECK(contains(page, "Content-Security-Policy"));
  CHECK(read_text(bench.out() / "bench.json").size() > 1000);
}

TEST_CASE("bench continues where it stopped, and --force runs everything again") {
  const BenchData bench;
  CHECK(bench.run("--pipelines none,oracle --frames 4").exit_code == 0);
  // Half of the work is lost. The other half is marked, to see that it is not done again.
  const fs::path none = bench.out() / "walking_static" / "none" / "summary.json";
  fs::remove_all(bench.out() / "walking_static" / "oracle");
  mark(none, "ate_rmse_m", "0.125");
  const CommandResult result = bench.run("--pipelines none,oracle --frames 4");
  CHECK(result.exit_code == 0);
  CHECK(contains(result.out, "12.5"));
  CHECK(contains(result.out, "missing: https://cvg.cit.tum.de"));
  CHECK(fs::is_regular_file(bench.out() / "walking_static" / "oracle" / "summary.json"));

  check_refused(bench.arguments("tum_fr3", "--frames 5"), "another manifest, version or --frames");
  CHECK_FALSE(contains(bench.run("--pipelines none --frames 4 --force").out, "12.5"));
}

TEST_CASE("bench finds KITTI's and EuRoC's folders, and a mono run is aligned by Sim(3)") {
  const BenchData bench;
  fs::create_directories(bench.data() / "dataset/sequences");
  fs::create_directory_symlink(Walking::shared().folder(), bench.data() / "dataset/sequences/04");
  fs::create_directory_symlink(Walking::shared().folder(), bench.data() / "V1_01_easy");
  for (const auto& [manifest, sequence] : {std::pair{"kitti", "04"}, {"euroc", "V1_01_easy"}}) {
    const std::string more = "--pipelines none --frames 3 --force --json";
    const CommandResult first = run_dynfilter(bench.arguments(manifest, more));
    CHECK(first.exit_code == 0);
    CHECK(value_of(row_of(first.out, sequence, "none"), "frames") == "3");
    CHECK(value_of(row_of(first.out, sequence, "none"), "alignment") == "\"SE(3)\"");
    mark(bench.out() / sequence / "none" / "summary.json", "sensor", "\"mono\"");
    const CommandResult second =
        run_dynfilter(bench.arguments(manifest, "--pipelines none --frames 3 --json"));
    CHECK(value_of(row_of(second.out, sequence, "none"), "alignment") == "\"Sim(3)\"");
  }
}

TEST_CASE("a sequence that fails does not stop the others") {
  const BenchData bench;
  fs::create_directories(bench.data() / "rgbd_dataset_freiburg3_walking_xyz");
  const CommandResult result = bench.run("--pipelines none --frames 3");
  CHECK(result.exit_code == 1);
  CHECK(contains(result.out, "failed: none on walking_xyz"));
  CHECK(contains(result.out, "3/3"));
}

TEST_CASE("all manifests can be read, and nothing there is no error") {
  const BenchData bench;
  fs::remove_all(bench.data());
  fs::create_directories(bench.data());
  for (const auto& entry : fs::directory_iterator(fs::path(DYNFILTER_SOURCE_DIR) / "examples/benchmarks")) {
    const std::string name = entry.path().stem().string();
    CAPTURE(name);
    const CommandResult result = run_dynfilter(bench.arguments(name, "--force"));
    CAPTURE(result.err);
    CHECK(result.exit_code == 0);
    CHECK(contains(result.out, "missing: https://"));
    const bool has_figures = read_text(entry.path()).find("\npublished:") != std::string::npos;
    CHECK(contains(result.out, "published") == has_figures);
  }
}

TEST_CASE("wrong manifests name the path") {
  const BenchData bench;
  const std::string head = "download: x\npipelines: [none]\n";
  const std::string sequence = "sequences: [{ name: a, folder: b }]\n";
  const auto refused = [&](const std::string& text, const std::string& reason) {
    check_refused(bench.arguments(bench.write("m.yaml", text).string(), ""), reason);
  };
  refused("pipelines: [none]\n", "expected the key `download`");
  refused(head + sequence + "colour: red\n", "unknown key `colour`; known keys: ");
  refused(head + "sequences: [{ name: a }]\n", "expected the key `folder`");
  refused(head + sequence + "published: [{ system: X, alignment: SE3, ate_cm: { a: 1 } }]\n",
          "expected SE(3) or Sim(3)");
  refused(head + sequence + "published: [{ system: X, alignment: \"SE(3)\", ate_cm: { c: 1 } }]\n",
          "no sequence of the manifest has this name");
  const std::string system = "{ system: X, alignment: \"SE(3)\", ate_cm: { a: 1 } }";
  refused(head + sequence + "published: [" + system + ", " + system + "]\n",
          "`published: X, SE(3)` is given twice");
  refused(head + sequence + "published: [{ system: none, alignment: \"Sim(3)\", ate_cm: { a: 1 } }]\n",
          "`none` and `published: none` are both named `none`");
  check_refused("bench no_such --data . --out /tmp/never", "presets: bonn, euroc, kitti, tum_fr3");
}
