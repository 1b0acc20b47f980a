// SPDX-License-Identifier: MIT
#include "eval/paper_table.hpp"

#include <cmath>
#include <dynfilter/core/error.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "../support/comma_locale.hpp"
#include "doctest/doctest.h"

using namespace dynfilter;

namespace paper_table_test {
namespace {

const eval::Provenance kProvenance{"1.2.3", "abc123+", "x86_64, 2 threads"};

eval::ComparedRun run(const std::string& pipeline, const std::string& variant, double ate_m) {
  eval::ComparedRun r;
  r.scene = r.place = r.sequence = "walking";
  r.pipeline = pipeline, r.variant = variant, r.alignment = "SE(3)";
  r.frames = 100, r.tracked_frames = 90;
  r.first_s = 5, r.last_s = 8.25;
  r.ate_rmse_m = ate_m, r.rpe_trans_rmse_m = 0.4 * ate_m, r.recall = 0.5, r.static_kept = 0.75, r.cpu_ms = 4;
  return r;
}

/// Three pipelines with six runs. Of `one` 0.01 to 0.06: median 0.035, worst 0.06, mean 0.035, and standard
/// deviation sqrt(17.5 / 5) cm. `half_one` has half of each, which all six pairs show: p = 2 / 2^6.
std::vector<eval::ComparedRun> six_runs() {
  std::vector<eval::ComparedRun> runs;
  for (const auto& [pipeline, factor] : {std::pair{"one", 1.0}, {"half_one", 0.5}, {"oracle", 0.1}})
    for (int k = 1; k <= 6; ++k)
      runs.push_back(run(pipeline, "from " + std::to_string(k), factor * 0.01 * k));
  return runs;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string line_with(const std::string& text, const std::string& begin) {
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (line.rfind(begin, 0) == 0) return line;
  return "";
}

TEST_CASE("comparison: statistics of the runs, and the test against the reference") {
  const eval::Comparison comparison = eval::compare_runs(six_runs());
  CHECK(comparison.reference == "one");  // there is no `none`
  CHECK(comparison.variants.size() == 6);
  REQUIRE(comparison.rows.size() == 3);
  const eval::ComparedRow& one = comparison.rows[0];
  CHECK(one.runs == 6);
  CHECK(one.ate_median_m == doctest::Approx(0.035));
  CHECK(one.ate_worst_m == doctest::Approx(0.06));
  CHECK(one.ate_mean_m == doctest::Approx(0.035));
  CHECK(one.ate_std_m == doctest::Approx(0.01 * std::sqrt(17.5 / 5)));
  CHECK(one.rpe_median_m == doctest::Approx(0.014));
  CHECK(one.over_oracle == doctest::Approx(10));
  CHECK(one.tracked_percent() == doctest::Approx(90));
  CHECK(one.first_s == 5);
  CHECK(one.last_s == 8.25);
  CHECK(one.against_reference.pairs == 0);
  CHECK(comparison.rows[1].against_reference.pairs == 6);
  CHECK(comparison.rows[1].against_reference.p == doctest::Approx(1.0 / 32));
  CHECK(eval::compare_runs(six_runs(), "oracle").reference == "oracle");
  CHECK_THROWS_AS(eval::compare_runs(six_runs(), "tow"), Error);
  CHECK(eval::compare_runs({}).rows.empty());
  CHECK(eval::compare_runs({run("one", "", 1)}).reference.empty());
}

TEST_CASE("comparison: runs are paired by sequence and variant, whatever their order") {
  std::vector<eval::ComparedRun> runs = six_runs();
  std::reverse(runs.begin(), runs.begin() + 6);
  const eval::Comparison comparison = eval::compare_runs(runs, "one");
  CHECK(comparison.rows[1].against_reference.greater_rank_sum == 0);
  CHECK(comparison.rows[1].against_reference.less_rank_sum == 21);
  // A run without an ATE has no pair, and scenes are not pooled.
  runs[0].ate_rmse_m = NAN, runs[1].scene = "other";
  const eval::Comparison fewer = eval::compare_runs(runs, "one");
  REQUIRE(fewer.rows.size() == 4);
  CHECK(fewer.rows[0].runs == 5);
  CHECK(fewer.rows[0].runs_with_ate == 4);
  CHECK(fewer.rows[2].against_reference.pairs == 4);
}

TEST_CASE("a table in LaTeX: figures, bold, the mark of the test, notes") {
  const std::string latex = eval::latex_table(eval::compare_runs(six_runs()), kProvenance);
  CAPTURE(latex);
  CHECK(line_with(latex, "one &") ==
        "one & 90.0 & 0.0350 & 0.0600 & 0.0350 & 0.0187 & 0.0140 & 0.500 & 0.750 & 4.0 & -- \\\\");
  // The least of those that are ranked: `oracle` is not. Equal figures are not bold.
  CHECK(line_with(latex, "half\\_one &") ==
        "half\\_one & 90.0 & \\textbf{0.0175} & \\textbf{0.0300} & \\textbf{0.0175} & \\textbf{0.0094} & "
        "\\textbf{0.0070} & 0.500 & 0.750 & 4.0 & 0.031\\rlap{$^{*}$} \\\\");
  CHECK(contains(latex, "ATE [m] $\\downarrow$"));
  CHECK(contains(latex, "[\\%] $\\uparrow$"));
  CHECK(contains(latex, "after SE(3) alignment"));
  CHECK(contains(latex,
                 "two-sided Wilcoxon signed-rank test, exact, of the ATE against one, paired by seed and "
                 "variant (n = 6)"));
  CHECK(contains(latex, "dynfilter 1.2.3, commit abc123 with changes, on x86\\_64, 2 threads."));
  CHECK(contains(latex, "Data: walking, 100 frames, stamps 5.000 to 8.250 s."));
  CHECK(contains(latex, "6 runs per row (frames from 1, from 2,"));
  CHECK(contains(latex, "Not ranked: oracle"));
  CHECK_FALSE(contains(latex, "Runs"));  // as many in each row: the note says it
}

TEST_CASE("a table: the same columns in all formats") {
  const eval::Comparison comparison = eval::compare_runs(six_runs());
  const std::string markdown = eval::markdown_table(comparison, kProvenance);
  CAPTURE(markdown);
  CHECK(contains(
      markdown,
      "| Sequence | Pipeline | Tracked (%) ↑ | ATE median (m) ↓ | ATE worst (m) ↓ | ATE mean (m) ↓ | "
      "ATE std (m) ↓ | RPE (m) ↓ | Recall ↑ | Kept ↑ | CPU (ms) ↓ | p |"));
  CHECK(contains(markdown, "| walking | half\\_one | 90.0 | **0.0175** |"));
  CHECK(contains(markdown, "| 0.031\\* |"));
  const std::string csv = eval::csv_table(comparison, kProvenance);
  CAPTURE(csv);
  CHECK(
      contains(csv,
               "runs,tracked_percent,ate_median_m,ate_worst_m,ate_mean_m,ate_std_m,rpe_m,recall,static_kept,"
               "cpu_ms,p_value,"));
  CHECK(contains(line_with(csv, "walking,half_one"),
                 ",0.03125,ate_median_m ate_worst_m ate_mean_m ate_std_m rpe_m,"));
  CHECK(contains(csv, "\"x86_64, 2 threads\""));
  CHECK(eval::paper_table("csv", comparison, kProvenance) == csv);
  CHECK_THROWS_AS(eval::paper_table("html", comparison, kProvenance), Error);
}

TEST_CASE("a table: what LaTeX would act on is shown as it is") {
  std::vector<eval::ComparedRun> runs = {
      run("a_b%c&d#e{f}$g~h^i\\j<k>|--\"\n\xc3\xa9\xe2\x82\xac\xff", "", 1), run("x", "", 2)};
  const std::string latex = eval::latex_table(eval::compare_runs(runs), kProvenance);
  CHECK(contains(latex,
                 "a\\_b\\%c\\&d\\#e\\{f\\}\\$g\\textasciitilde{}h\\textasciicircum{}i\\textbackslash{}j"
                 "\\textless{}k\\textgreater{}\\textbar{}-{}-'' \xc3\xa9?? & "));
  runs[0].pipeline = "a,\"b\"|<c>";
  CHECK(
      contains(eval::csv_table(eval::compare_runs(runs), kProvenance), "walking,\"a,\"\"b\"\"|<c>\",SE(3)"));
  CHECK(contains(eval::markdown_table(eval::compare_runs(runs), kProvenance), "a,\"b\"\\|&lt;c>"));
}

TEST_CASE("a table of single runs has one column of the ATE, and no test") {
  std::vector<eval::ComparedRun> runs = {run("none", "", 0.2), run("one", "", 0.02)};
  runs[0].static_kept = 1, runs[0].recall = 0, runs[0].cpu_ms = 1;
  const std::string latex = eval::latex_table(eval::compare_runs(runs), kProvenance);
  CAPTURE(latex);
  CHECK(contains(latex, " & Tracked & ATE & RPE & Recall & Kept & CPU \\\\"));
  // `none` keeps all and costs nothing: it is not ranked there, and one alone is not the best.
  CHECK(line_with(latex, "none &") == "none & 90.0 & 0.2000 & 0.0800 & 0.000 & 1.000 & 1.0 \\\\");
  CHECK(line_with(latex, "one &") ==
        "one & 90.0 & \\textbf{0.0200} & \\textbf{0.0080} & \\textbf{0.500} & 0.750 & 4.0 \\\\");
  CHECK_FALSE(contains(latex, "Wilcoxon"));
  CHECK_FALSE(contains(latex, "worst"));
  for (eval::ComparedRun& r : runs) r.rpe_trans_rmse_m = NAN;
  CHECK_FALSE(contains(eval::latex_table(eval::compare_runs(runs), kProvenance), "RPE"));
}

TEST_CASE("a table: alignments that differ stand at their sequences; failures and missing runs are named") {
  std::vector<eval::ComparedRun> runs = six_runs();
  for (eval::ComparedRun r : six_runs()) {
    r.scene = r.place = r.sequence = "mono_walk", r.alignment = "Sim(3)", r.recall = r.static_kept = NAN;
    if (r.pipeline == "half_one") r.failed = true, r.ate_rmse_m = r.rpe_trans_rmse_m = NAN;
    if (r.pipeline == "one" && r.variant == "from 1") r.ate_rmse_m = NAN;
    runs.push_back(r);
  }
  const std::string latex = eval::latex_table(eval::compare_runs(runs), kProvenance);
  CAPTURE(latex);
  CHECK(contains(latex, "\\emph{walking, aligned by SE(3)}"));
  CHECK(contains(latex, "\\emph{mono\\_walk, aligned by Sim(3)}"));
  CHECK(contains(latex, "after the alignment that stands at each sequence"));
  CHECK(contains(latex, "one & 5/6 & 90.0 & 0.0400 &"));
  CHECK(contains(latex, "half\\_one & 6 & 90.0 & -- & -- & -- & -- & -- & -- & -- & 4.0 & -- \\\\"));
  CHECK(contains(latex, "Failed, without figures: half\\_one on mono\\_walk."));
}

TEST_CASE("a table: fewer than six pairs cannot show a difference, and it says so") {
  std::vector<eval::ComparedRun> runs;
  for (const eval::ComparedRun& r : six_runs())
    if (r.variant <= "from 5") runs.push_back(r);
  const std::string latex = eval::latex_table(eval::compare_runs(runs), kProvenance);
  CHECK(contains(latex, "So few pairs cannot tell a difference from noise: p is at least 0.062."));
  CHECK_FALSE(contains(latex, "$^{*}$"));
}

TEST_CASE("a table: a p without digits is said to be small") {
  std::vector<eval::ComparedRun> runs;  // twelve pairs: p is 2 / 2^12
  for (const eval::ComparedRun& r : six_runs())
    for (const char* seed : {"_1", "_2"}) runs.push_back(r), runs.back().sequence += seed;
  const eval::Comparison comparison = eval::compare_runs(runs);
  CHECK(comparison.rows[1].against_reference.p == doctest::Approx(2.0 / 4096));
  CHECK(contains(eval::latex_table(comparison, kProvenance), "& $<$0.001\\rlap{$^{*}$} \\\\"));
  CHECK(contains(eval::markdown_table(comparison, kProvenance), "| &lt;0.001\\* |"));
  CHECK(contains(eval::markdown_table(comparison, kProvenance),
                 "Data: walking (walking\\_1, walking\\_2), 100 frames"));
}

TEST_CASE("a table: what a p is worth, and which folder a scene was in") {
  std::vector<eval::ComparedRun> runs = six_runs();
  for (eval::ComparedRun& r : runs) r.sequence = "walking_7";
  const std::string variants = eval::markdown_table(eval::compare_runs(runs), kProvenance);
  CHECK(contains(variants, "0.05. Variants of a sequence share frames, so p is too small."));
  CHECK(contains(variants, "Data: walking (walking\\_7), 100 frames"));
  for (eval::ComparedRun& r : runs) r.sequence = r.variant, r.variant.clear();
  const std::string seeds = eval::markdown_table(eval::compare_runs(runs), kProvenance);
  CHECK(contains(seeds, "0.05, more than noise."));
  CHECK_FALSE(contains(seeds, "share frames"));
}

TEST_CASE("a table has decimal points in any locale") {
  const eval::Comparison comparison = eval::compare_runs(six_runs());
  const std::string latex = eval::latex_table(comparison, kProvenance),
                    csv = eval::csv_table(comparison, kProvenance);
  const dynfilter_test::CommaLocale commas;
  CHECK(eval::latex_table(comparison, kProvenance) == latex);
  CHECK(eval::csv_table(comparison, kProvenance) == csv);
}

TEST_CASE("the class of the machine names its processor and no host") {
  const std::string machine = eval::machine_class();
  CHECK(contains(machine, "thread"));
  CHECK_FALSE(contains(machine, "(R)"));
}

}  // namespace
}  // namespace paper_table_test
