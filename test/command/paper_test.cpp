// SPDX-License-Identifier: MIT
// A table for a paper from two folders, as a user makes it.
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "run_command.hpp"
#include "walking.hpp"

using namespace dynfilter_test;
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

/// Two scenes, two seeds of the first one. Names are such as LaTeX would act on.
class Scenes {
 public:
  Scenes() {
    const auto synth = [this](const std::string& scene, const std::string& name, int seed) {
      REQUIRE(run_dynfilter("synth " + scene + " " + path(name) + " --frames 5 --no-right --seed " +
                            std::to_string(seed))
                  .exit_code == 0);
    };
    synth("walking_static", "walk_1", 1);
    synth("walking_static", "walk_2", 2);
    synth("moving_box", "a_box%", 3);
    write_text(root() / "half_&_half.yaml",
               "%YAML:1.0\n---\npipeline:\n  name: half_&_half\n  before_pose:\n    - epipolar\n");
  }
  fs::path root() const { return folder_.path(); }
  std::string path(const std::string& name) const { return "'" + (root() / name).string() + "'"; }
  std::string compare() const {
    return "compare " + path("walk_1") + " " + path("walk_2") + " " + path("a_box%") + " --pipelines none," +
           path("half_&_half.yaml") + ",oracle ";
  }

 private:
  TemporaryFolder folder_;
};

std::vector<std::string> lines_with(const std::string& text, const std::string& part) {
  std::vector<std::string> found;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (contains(line, part)) found.push_back(line);
  return found;
}

}  // namespace

TEST_CASE("a table for a paper: two scenes in one table, as text and as files, which LaTeX prints") {
  const Scenes scenes;
  const std::string out = scenes.path("out");
  const CommandResult latex = run_dynfilter(scenes.compare() + "--table latex --out " + out);
  CAPTURE(latex.err);
  REQUIRE(latex.exit_code == 0);
  CHECK(latex.out == read_text(scenes.root() / "out/table.tex"));
  CHECK(lines_with(latex.out, "\\midrule").size() == 2);
  CHECK(contains(latex.out, "\\emph{walking\\_static}"));
  CHECK(contains(latex.out, "\\emph{moving\\_box}"));
  CHECK(contains(latex.out, "half\\_\\&\\_half & "));
  CHECK(contains(latex.out, "after SE(3) alignment"));
  // The figures of the JSON text, seeds pooled.
  const Json medians = Json::parse(read_text(scenes.root() / "out/summary.json"))["medians"];
  REQUIRE(medians.size() == 6);
  const std::vector<std::string> none = lines_with(latex.out, "none & ");
  REQUIRE(none.size() == 2);
  for (int scene = 0; scene < 2; ++scene) {
    const Json& m = medians[static_cast<std::size_t>(3 * scene)];
    CHECK(m["runs"] == 2 - scene);
    CHECK(m["pipeline"] == "none");
    std::ostringstream figure;
    figure.precision(4);
    figure << std::fixed << m["ate_rmse_m"].get<double>();
    CHECK(contains(none[static_cast<std::size_t>(scene)], figure.str()));
  }
  const std::string markdown = read_text(scenes.root() / "out/table.md");
  CHECK(lines_with(markdown, "| walking\\_static | ").size() == 3);
  CHECK(lines_with(markdown, "| moving\\_box | ").size() == 3);
  CHECK(lines_with(read_text(scenes.root() / "out/table.csv"), "walking_static,").size() == 3);

  if (std::system("pdflatex --version >/dev/null 2>&1 && kpsewhich booktabs.sty >/dev/null") != 0) {
    MESSAGE("skipped: no pdflatex with booktabs");
    return;
  }
  const std::string document =
      "\\documentclass{article}\\usepackage{booktabs}\\begin{document}\\input{out/table}\\end{document}";
  const std::string call = "cd " + scenes.path("") +
                           " && pdflatex -interaction=nonstopmode -jobname printed '" + document +
                           "' >/dev/null 2>&1";
  CHECK(std::system(call.c_str()) == 0);
  const std::string log = read_text(scenes.root() / "printed.log");
  CHECK(contains(log, "Output written on printed.pdf (1 page"));
  CHECK_FALSE(contains(log, "Overfull"));
  CHECK_FALSE(contains(log, "undefined"));
}

TEST_CASE("the reference of the test, and what is refused") {
  const TemporaryFolder folder;
  const std::string variants =
      "compare '" + Walking::shared().folder().string() + "' --pipelines none,oracle --variants --frames 3 ";
  const std::string wide = run_dynfilter(variants + "--wide --reference oracle").out;
  CHECK(contains(wide, "p: Wilcoxon signed-rank test of the ATE against oracle"));
  check_refused(variants + "--reference rts_slam", "--reference rts_slam: is not among the --pipelines");
  check_refused(variants + "--table html", "--table: html not in {latex,markdown,csv}");
  check_refused(variants + "--table csv --json", "excludes");
  check_refused(variants + "--table csv --csv", "excludes");
  const fs::path out = folder.path() / "taken";
  fs::create_directories(out);
  write_text(out / "table.tex", "mine");
  check_refused(variants + "--out " + "'" + out.string() + "'", "(table.tex)");
  CHECK(read_text(out / "table.tex") == "mine");
}
