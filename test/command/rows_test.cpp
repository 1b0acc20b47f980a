// SPDX-License-Identifier: MIT
// Each row of a comparison is that of its pipeline on its sequence, run alone; what has no figures of its own
// shows none.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "run_command.hpp"
#include "support/effort.hpp"
#include "walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr const char* kFigures[] = {"frames",        "tracked_frames", "ate_rmse_m",    "rpe_trans_rmse_m",
                                    "precision",     "recall",         "static_kept",   "features_mean",
                                    "rejected_mean", "pipeline",       "pipeline_file", "pipeline_digest",
                                    "folder",        "scene",          "failure",       "notes"};

std::string pipeline_text(const std::string& name, const std::string& before_pose) {
  return "%YAML:1.0\n---\npipeline:\n  name: " + name + "\n  before_pose:\n" + before_pose;
}

/// Two sequences in folders of one name, and pipelines in files of one name.
class Places {
 public:
  Places() {
    for (const char* folder : {"a", "b"}) fs::create_directories(root() / folder);
    fs::copy(Walking::shared().folder(), root() / "a/walking", fs::copy_options::recursive);
    fs::copy(moving_box(), root() / "b/walking", fs::copy_options::recursive);
    write_text(root() / "a/p.yaml", pipeline_text("boxes", "    - semantic_box: { role: reject }\n"));
    write_text(root() / "b/p.yaml", pipeline_text("flow", "    - epipolar: { max_distance_px: 1.0 }\n"));
  }
  fs::path root() const { return folder_.path(); }
  std::string path(const std::string& name) const { return "'" + (root() / name).string() + "'"; }

  /// The row that `run` gives for what a row of a comparison says that it is.
  static Json alone(const Json& row, const std::string& options) {
    const std::string arguments = "run '" + row["folder"].get<std::string>() + "' --json --pipeline '" +
                                  row["pipeline_file"].get<std::string>() + "' " + options;
    return Json::parse(run_dynfilter(arguments).out);
  }
  static void check_rows(const Json& rows, const std::string& options) {
    for (std::size_t k = 0; k < rows.size(); k += kLongTests ? 1 : 3) {
      const Json& row = rows[k];
      const Json own = alone(row, options);
      for (const char* key : kFigures) {
        CAPTURE(row["pipeline"].get<std::string>() + " on " + row["sequence"].get<std::string>() + ": " +
                key);
        CHECK(row[key] == own[key]);
      }
    }
  }

 private:
  /// Rendered once for all tests.
  static fs::path moving_box() {
    static const TemporaryFolder folder;
    static const CommandResult made = run_dynfilter("synth moving_box '" + (folder.path() / "box").string() +
                                                    "' --frames 14 --seed 5 --no-right");
    REQUIRE(made.exit_code == 0);
    return folder.path() / "box";
  }

  TemporaryFolder folder_;
};

std::vector<std::string> texts(const Json& rows, const char* key) {
  std::vector<std::string> all;
  for (const Json& row : rows) all.push_back(row[key].get<std::string>());
  return all;
}

/// The lines of CSV text by column; no field of these tests has a comma or a quote.
std::vector<Json> csv_rows(const std::string& text) {
  std::istringstream lines(text);
  const auto cells = [](const std::string& line) {
    std::vector<std::string> all;
    bool quoted = false;
    all.emplace_back();
    for (const char c : line) {
      if (c == '"')
        quoted = !quoted;
      else if (c == ',' && !quoted)
        all.emplace_back();
      else
        all.back() += c;
    }
    return all;
  };
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> heads = cells(line);
  std::vector<Json> rows;
  while (std::getline(lines, line)) {
    const std::vector<std::string> values = cells(line);
    REQUIRE(values.size() == heads.size());
    Json row;
    for (std::size_t i = 0; i < heads.size(); ++i) row[heads[i]] = values[i];
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

TEST_CASE("rows of compare: two sequences of one folder's name, two pipelines of one file's name") {
  const Places places;
  const std::string arguments = "compare " + places.path("a/walking") + " " + places.path("b/walking") +
                                " --pipelines none,oracle," + places.path("a/p.yaml") + "," +
                                places.path("b/p.yaml");
  const std::string out = " --out " + places.path("out");
  const CommandResult result = run_dynfilter(arguments + " --json" + out);
  CAPTURE(result.err);
  REQUIRE(result.exit_code == 0);
  const Json all = Json::parse(result.out), rows = all["rows"];
  CHECK(texts(rows, "pipeline") ==
        std::vector<std::string>{"none", "oracle", "boxes", "flow", "none", "oracle", "boxes", "flow"});
  CHECK(texts(rows, "sequence") == std::vector<std::string>{"a/walking", "a/walking", "a/walking",
                                                            "a/walking", "b/walking", "b/walking",
                                                            "b/walking", "b/walking"});
  Places::check_rows(rows, "");
  CHECK(rows[0]["ate_rmse_m"] != rows[1]["ate_rmse_m"]);
  CHECK(rows[0]["ate_rmse_m"] != rows[4]["ate_rmse_m"]);
  CHECK(Json::parse(read_text(places.root() / "out/summary.json")) == all);
  const std::vector<Json> csv = csv_rows(read_text(places.root() / "out/summary.csv"));
  REQUIRE(csv.size() == rows.size());
  for (std::size_t i = 0; i < csv.size(); ++i) {
    CHECK(csv[i]["pipeline"] == rows[i]["pipeline"]);
    CHECK(csv[i]["sequence"] == rows[i]["sequence"]);
    CHECK(std::stod(csv[i]["ate_rmse_m"].get<std::string>()) == rows[i]["ate_rmse_m"].get<double>());
  }
  const std::string page = read_text(places.root() / "out/report.html");
  for (const Json& row : rows)  // the table for readers without scripts
    CHECK(contains(page, "<td>" + row["sequence"].get<std::string>() + "</td><td>" +
                             row["pipeline"].get<std::string>() + "</td>"));
}

TEST_CASE("medians of variants are in every form, and are those of their rows") {
  const Places places;
  const std::string arguments =
      "compare " + places.path("a/walking") + " --pipelines none,oracle --variants --frames 3 ";
  const Json all = Json::parse(run_dynfilter(arguments + "--json").out);
  REQUIRE(all["medians"].size() == 2);
  const std::vector<Json> csv = csv_rows(run_dynfilter(arguments + "--csv").out);
  const std::string markdown = run_dynfilter(arguments + "--markdown").out;
  REQUIRE(csv.size() == 14);
  for (int p = 0; p < 2; ++p) {
    const Json& m = all["medians"][p];
    std::vector<double> ates;
    for (const Json& row : all["rows"])
      if (row["pipeline"] == m["pipeline"]) ates.push_back(row["ate_rmse_m"].get<double>());
    REQUIRE(ates.size() == 6);
    std::sort(ates.begin(), ates.end());
    CHECK(m["ate_rmse_m"].get<double>() == doctest::Approx((ates[2] + ates[3]) / 2));
    CHECK(m["ate_rmse_max_m"].get<double>() == ates[5]);
    const double mean = std::accumulate(ates.begin(), ates.end(), 0.0) / 6;
    double squares = 0;
    for (const double ate : ates) squares += (ate - mean) * (ate - mean);
    CHECK(m["ate_rmse_mean_m"].get<double>() == doctest::Approx(mean));
    CHECK(m["ate_rmse_std_m"].get<double>() == doctest::Approx(std::sqrt(squares / 5)));
    CHECK(m["reference"] == "none");
    CHECK(m["pairs"] == (p == 0 ? 0 : 6));
    CHECK(m["p_value"].is_null() == (p == 0));
    const Json& line = csv[static_cast<std::size_t>(12 + p)];
    CHECK(line["run"] == "median of 6");
    CHECK(line["pipeline"] == m["pipeline"]);
    CHECK(std::stod(line["ate_rmse_m"].get<std::string>()) == m["ate_rmse_m"].get<double>());
    CHECK(std::stod(line["ate_rmse_max_m"].get<std::string>()) == ates[5]);
    CHECK(std::stod(line["ate_over_oracle"].get<std::string>()) == m["ate_over_oracle"].get<double>());
    CHECK(contains(markdown, "| walking\\_static | " + m["pipeline"].get<std::string>() + " | 6 | 18/18 |"));
  }
}

TEST_CASE("a comparison whose rows could not be told apart is refused, before anything is run") {
  const Places places;
  const std::string compare = "compare " + places.path("a/walking") + " --frames 3 --pipelines ";
  write_text(places.root() / "b/p.yaml", pipeline_text("boxes", "    - epipolar\n"));
  fs::create_directory_symlink(places.root() / "a/walking", places.root() / "alias");
  check_refused(compare + places.path("a/p.yaml") + "," + places.path("b/p.yaml"),
                "are both named `boxes`: their rows could not be told apart; rename one");
  check_refused(compare + "none,none", "`none` is given twice");
  check_refused(compare + "none,'" DYNFILTER_SOURCE_DIR "/examples/pipelines/none.yaml'",
                "are both named `none`");
  check_refused("compare " + places.path("a/walking") + " " + places.path("alias") + " --pipelines none",
                "are one folder");
  check_refused("compare " + places.path("a/walking") + " " + places.path("a/walking") + " --pipelines none",
                "is given twice");
}

TEST_CASE("without labels `oracle` is refused by every command, and inside of a pipeline, too") {
  const Places places;
  for (const char* folder : {"labels", "dynamic"}) fs::remove_all(places.root() / "b/walking" / folder);
  const std::string bare = places.path("b/walking"), reason = "has no label images, which `oracle` needs";
  write_text(places.root() / "with.yaml", pipeline_text("mine", "    - any:\n        - oracle\n"));
  for (const std::string& pipeline : {std::string("oracle"), places.path("with.yaml")}) {
    check_refused("run " + bare + " --pipeline " + pipeline, reason);
    check_refused("compare " + bare + " --pipelines none," + pipeline, reason);
    check_refused("compare " + places.path("a/walking") + " " + bare + " --frames 3 --pipelines " + pipeline,
                  reason);
    check_refused("map " + bare + " " + places.path("b/walking/groundtruth.txt") + " --map " +
                      places.path("m.ply") + " --pipeline " + pipeline,
                  reason);
    write_text(places.root() / "clip.txt",
               "# Any clip\n# points 2 frames 2 width 640 height 480\n1 1 2 3 4\n2 5 6 7 8\n");
    check_refused("motion " + places.path("clip.txt") + " --pipeline " + pipeline, reason);
  }
}

TEST_CASE("a stage that fails in every frame: exit code 1, a line, no figures under the pipeline's name") {
  const Places places;
  write_text(places.root() / "bad.yaml", pipeline_text("bad", "    - throws_in_apply\n"));
  const std::string with = " --plugin '" DYNFILTER_THROWING_PLUGIN "' ";
  const std::string line = "throws_in_apply failed on all of 14 frames: the sensor melted";
  const CommandResult run =
      run_dynfilter("run " + places.path("a/walking") + with + "--pipeline " + places.path("bad.yaml"));
  CHECK(run.exit_code == 1);
  CHECK(run.err == "dynfilter: bad on walking: " + line + "\n");
  const CommandResult compare = run_dynfilter("compare " + places.path("a/walking") + with +
                                              "--json --pipelines none," + places.path("bad.yaml"));
  CHECK(compare.exit_code == 1);
  CHECK(compare.err == run.err);
  const Json rows = Json::parse(compare.out)["rows"];
  Places::check_rows(rows, with);
  CHECK(rows[0]["failure"].is_null());
  CHECK(rows[0]["ate_rmse_m"].is_number());
  CHECK(rows[1]["failure"] == line);
  for (const char* key : {"ate_rmse_m", "precision", "recall", "static_kept"}) CHECK(rows[1][key].is_null());
  const std::string arguments =
      "compare " + places.path("a/walking") + with + "--pipelines none," + places.path("bad.yaml");
  const std::vector<Json> csv = csv_rows(run_dynfilter(arguments + " --csv").out);
  CHECK(csv[1]["ate_rmse_m"] == "");
  CHECK(contains(csv[1]["notes"].get<std::string>(), "failed: throws_in_apply"));
  CHECK(contains(run_dynfilter(arguments + " --markdown").out, " failed |"));
}

TEST_CASE("missing inputs: a row says so in every form, and is that of the run alone") {
  const Places places;
  const std::string arguments = "compare " + places.path("a/walking") +
                                " --no-detections --no-masks --frames 5 --pipelines none," +
                                places.path("a/p.yaml");
  const Json rows = Json::parse(run_dynfilter(arguments + " --json").out)["rows"];
  Places::check_rows(rows, "--no-detections --no-masks --frames 5");
  const std::string note = "every feature of every frame is unknown";
  CHECK(contains(rows[1]["notes"].dump(), note));
  CHECK(contains(csv_rows(run_dynfilter(arguments + " --csv").out)[1]["notes"].get<std::string>(), note));
  CHECK(contains(run_dynfilter(arguments).out, note));
}

TEST_CASE("rows of bench: of another pipeline or other data nothing is taken") {
  const Places places;
  fs::create_directories(places.root() / "one");
  fs::create_directories(places.root() / "two");
  fs::create_directory_symlink(places.root() / "a/walking", places.root() / "one/s");
  fs::create_directory_symlink(places.root() / "b/walking", places.root() / "two/s");
  const std::string head = "download: x\npipelines: [none]\nsequences: [{ name: s, folder: s }";
  write_text(places.root() / "m.yaml", head + "]\n");
  const auto bench = [&](const std::string& data, const std::string& more) {
    return "bench " + places.path("m.yaml") + " --data " + places.path(data) + " --out " +
           places.path("out") + " --frames 5 " + more;
  };
  const auto ran = [&](const std::string& data, const std::string& pipeline) {
    const CommandResult result = run_dynfilter(bench(data, "--json --pipelines " + pipeline));
    CAPTURE(result.err);
    REQUIRE(result.exit_code == 0);
    const Json row = Json::parse(result.out)["rows"][0];
    const Json own = Json::parse(
        run_dynfilter("run " + places.path(data + "/s") + " --frames 5 --json --pipeline " + pipeline).out);
    for (const char* key : {"frames", "tracked_frames", "ate_rmse_m", "recall", "static_kept"}) {
      CAPTURE(data + " " + pipeline + " " + key);
      CHECK(row[key] == own[key]);
    }
    return row["static_kept"];
  };
  ran("one", "none");
  ran("one", places.path("a/p.yaml"));
  ran("one", places.path("b/p.yaml"));  // writes to the folder of a/p.yaml
  ran("one", places.path("a/p.yaml"));
  ran("two", places.path("a/p.yaml"));  // other data under the same names
  write_text(places.root() / "a/p.yaml",
             pipeline_text("boxes", "    - epipolar: { max_distance_px: 0.5 }\n"));
  ran("two", places.path("a/p.yaml"));  // edited
  check_refused(bench("one", "--pipelines " + places.path("a/p.yaml") + "," + places.path("b/p.yaml")),
                "are both named `p`");
  check_refused(bench("one", "--pipelines none,none"), "`none` is given twice");
  write_text(places.root() / "m.yaml", head + ", { name: s, folder: t }]\n");
  check_refused(bench("one", ""), "`s` and `t` are both named `s`");
  write_text(places.root() / "m.yaml",
             head + "]\npublished: [{ system: none, alignment: \"SE(3)\", ate_cm: { s: 1 } }]\n");
  check_refused(bench("one", ""), "are both named `none`");
}

TEST_CASE("bench: a run that fails later leaves no row of the run before it") {
  const Places places;
  write_text(places.root() / "m.yaml",
             "download: x\npipelines: [none]\nsequences: [{ name: s, folder: walking }]\n");
  const std::string bench = "bench " + places.path("m.yaml") + " --data " + places.path("b") + " --out " +
                            places.path("out") + " --frames 3 --json --pipelines oracle";
  const CommandResult good = run_dynfilter(bench);
  CHECK(good.exit_code == 0);
  for (const char* folder : {"labels", "dynamic"}) fs::remove_all(places.root() / "b/walking" / folder);
  const CommandResult failed = run_dynfilter(bench + " --force");
  CHECK(failed.exit_code == 1);
  const Json row = Json::parse(failed.out)["rows"][0];
  CHECK(row["state"] == "failed");
  CHECK(contains(row["note"].get<std::string>(), "has no label images"));
  CHECK(row["ate_rmse_m"].is_null());
}
