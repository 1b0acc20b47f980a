// SPDX-License-Identifier: MIT
#include "report_data.hpp"

#include <cmath>
#include <sstream>

#include "command/run_command.hpp"
#include "command/walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;

TEST_CASE("run writes the page with its results, compare with all runs") {
  const Walking& walking = Walking::shared();
  const std::string folder = "'" + walking.folder().string() + "'";
  const fs::path out = walking.root() / "report";
  fs::create_directories(out);
  for (const char* pipeline : {"none", "rts_slam"})
    REQUIRE(run_dynfilter("run " + folder + " --pipeline " + pipeline + " --detector-mode late:2 --out '" +
                          (out / pipeline).string() + "'")
                .exit_code == 0);
  const std::string page = read_text(out / "rts_slam/report.html");
  const Json data = data_of(page), run = data["runs"][0], frames = run["frames"];
  CHECK(run["summary"] == Json::parse(read_text(out / "rts_slam/summary.json")));
  REQUIRE(data["beside"].size() == 1);
  CHECK(data["beside"][0] == Json::parse(read_text(out / "none/summary.json")));
  CHECK(times(page, "default-src 'none'") == 1);
  for (const char* outside : {"src=\"http", "href=", "url(", "fetch(", "XMLHttpRequest", "import("}) {
    CAPTURE(outside);
    CHECK(times(page, outside) == 0);
  }

  // The series agree with the summary and with each other.
  double squares = 0, rejected = 0;
  for (std::size_t k = 0; k < 14; ++k) {
    squares += std::pow(frames["error_m"][k].get<double>(), 2);
    rejected += frames["rejected"][k].get<double>();
    double reasons = 0, verdicts = 0;
    for (const Json& reason : run["reasons"]) reasons += reason["features"][k].get<double>();
    CHECK(reasons == frames["rejected"][k].get<double>());
    for (const char* verdict : {"static", "unknown", "restored", "rejected"})
      verdicts += frames[verdict][k].get<double>();
    CHECK(verdicts == frames["features"][k].get<double>());
  }
  // Mean weights are those of the kept features in verdicts.csv.
  std::vector<double> weights(14), kept(14);
  std::istringstream verdicts_csv(read_text(out / "rts_slam/verdicts.csv"));
  std::string row, cell;
  for (std::getline(verdicts_csv, row); std::getline(verdicts_csv, row);) {
    std::vector<std::string> cells;
    for (std::istringstream line(row); std::getline(line, cell, ',');) cells.push_back(cell);
    const double weight = std::stod(cells.at(5));
    CHECK((weight >= 0 && weight <= 1));
    if (cells[3] != "dynamic") weights[std::stoul(cells[0])] += weight, ++kept[std::stoul(cells[0])];
  }
  for (std::size_t k = 0; k < 14; ++k)
    CHECK(frames["weight"][k].get<double>() == doctest::Approx(weights[k] / kept[k]).epsilon(0.002));
  CHECK(std::sqrt(squares / 14) == doctest::Approx(run["summary"]["ate_rmse_m"].get<double>()).epsilon(1e-4));
  CHECK(rejected / 14 == doctest::Approx(run["summary"]["rejected_mean"].get<double>()));
  CHECK(run["pictures"].size() == 14);
  std::size_t late = 0;
  for (const Json& mark : run["marks"]) late += mark["kind"] == "late";
  CHECK(late == 12);  // all but the first two, which have nothing yet
  CHECK(frames["age_frames"][0].is_null());
  CHECK(frames["age_frames"][13] == 2);

  // Another run's page is not replaced.
  fs::create_directories(out / "taken");
  write_text(out / "taken/report.html", "mine");
  check_refused("run " + folder + " --pipeline none --out '" + (out / "taken").string() + "'",
                "(report.html)");
  check_refused("compare " + folder + " --pipelines none --out '" + (out / "taken").string() + "'",
                "--force");

  const fs::path both = walking.root() / "both";
  const CommandResult compare =
      run_dynfilter("compare " + folder + " --pipelines none,oracle --json --out '" + both.string() + "'");
  REQUIRE(compare.exit_code == 0);
  CHECK(read_text(both / "summary.json") == compare.out);
  const Json compared = data_of(read_text(both / "report.html")), rows = Json::parse(compare.out)["rows"];
  REQUIRE(compared["runs"].size() == 2);
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK(compared["runs"][k]["summary"] == rows[k]);
    CHECK(compared["runs"][k]["pictures"].size() == 14);
  }
}

TEST_CASE("compare --csv has all digits, --markdown the table, and text fits 100 columns") {
  const std::string compare =
      "compare '" + Walking::shared().folder().string() + "' --pipelines none,oracle --frames 12";
  const CommandResult csv = run_dynfilter(compare + " --csv");
  CHECK(csv.exit_code == 0);
  CHECK(times(csv.out, "\n") == 3);
  CHECK(csv.out.rfind("sequence,run,pipeline,frames,tracked_frames,ate_rmse_m,", 0) == 0);
  CHECK(contains(csv.out, "\nwalking,,none,12,12,0."));
  CHECK(contains(csv.out, "\nwalking,,oracle,12,12,0."));
  const CommandResult markdown = run_dynfilter(compare + " --markdown");
  CHECK(markdown.exit_code == 0);
  CHECK(markdown.out.rfind("| sequence | pipeline | tracked | ATE m |", 0) == 0);
  CHECK(contains(markdown.out, "\n|---|---|---:|---:|"));
  CHECK(contains(markdown.out, "\n| walking | none | 12/12 | "));
  check_refused(compare + " --csv --markdown", "excludes");

  std::stringstream text(run_dynfilter(compare).out);
  for (std::string line; std::getline(text, line);) CHECK(line.size() <= 100);
}

TEST_CASE("compare --map writes a map per run, and the page has them") {
  const TemporaryFolder root;
  const fs::path out = root.path() / "out", maps = root.path() / "maps";
  const std::string folder = "'" + Walking::shared().folder().string() + "'";
  const std::string map = " --map '" + maps.string() + "' --keyframes every:4 --map-leaf-m 0.05";
  const CommandResult result = run_dynfilter("compare " + folder + " --pipelines none,oracle --csv" + map +
                                             " --truth --out '" + out.string() + "'");
  CAPTURE(result.err);
  REQUIRE(result.exit_code == 0);
  for (const char* name : {"walking_none", "walking_oracle"})
    for (const char* kind : {".ply", ".png"}) CHECK(fs::is_regular_file(maps / (std::string(name) + kind)));
  const Json runs = data_of(read_text(out / "report.html"))["runs"];
  REQUIRE(runs.size() == 2);
  for (const Json& run : runs) {
    CHECK(run["map"]["points"] == run["summary"]["map"]["points"]);
    CHECK(run["map"]["shown"] <= 60'000);
    CHECK(contains(result.out, "," + run["summary"]["map"]["points"].dump() + ","));
  }
  const auto ghosts = [&](std::size_t k) {
    return runs[k]["summary"]["map"]["truth"]["ghosts"].get<double>();
  };
  CHECK(ghosts(1) < ghosts(0));  // without rejection people are in the map
  check_refused("compare " + folder + " --pipelines none --truth", "--truth requires --map");
  check_refused("compare " + folder + " " + folder + " --pipelines none" + map, "is given twice");
  CHECK(contains(run_dynfilter("compare " + folder + " --pipelines none,oracle --frames 9 --wide" + map).out,
                 "map points"));
}
