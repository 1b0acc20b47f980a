// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <dynfilter/core/error.hpp>
#include <dynfilter/version.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "command.hpp"
#include "compare_rows.hpp"
#include "eval/paper_table.hpp"
#include "io/sequence_source.hpp"
#include "report/map_sample.hpp"
#include "report/page.hpp"
#include "report/picture.hpp"
#include "run_and_print.hpp"
#include "run_options.hpp"
#include "running/command_registry.hpp"
#include "running/commit.hpp"
#include "running/distinct_names.hpp"
#include "running/results_folder.hpp"
#include "running/run_summary.hpp"
#include "running/sequence_run.hpp"
#include "text/progress.hpp"

namespace dynfilter::command {
namespace {

struct CompareOptions {
  std::vector<std::string> sequences, pipelines;
  std::vector<std::string> sequence_names;  ///< in the rows: no two are the same
  RunOptions run;
  bool variants = false, json = false, csv = false, markdown = false, wide = false, verbose = false;
  std::string table, reference;
  std::string out, maps;
  bool force = false;
};

/// `a, b` as the shell passes it: `a,` and `b`, or ` b` after the comma.
std::vector<std::string> without_blanks(const std::vector<std::string>& words) {
  std::vector<std::string> names;
  for (const std::string& word : words) {
    const std::size_t from = word.find_first_not_of(" \t"), to = word.find_last_not_of(" \t");
    if (from != std::string::npos) names.push_back(word.substr(from, to - from + 1));
  }
  if (names.empty()) throw Error("--pipelines: expected at least one name");
  return names;
}

void check_reference(const CompareOptions& options, const std::vector<NamedSource>& pipelines) {
  const auto is = [&](const NamedSource& pipeline) { return pipeline.name == options.reference; };
  if (options.reference.empty() || std::any_of(pipelines.begin(), pipelines.end(), is)) return;
  throw Error("--reference " + options.reference + ": is not among the --pipelines");
}

/// Rows are told apart by names. Also finds what is wrong with a pipeline before the first run.
void check_names(CompareOptions& options) {
  const Registry registry = command_registry(options.run.plugins);
  std::vector<NamedSource> pipelines;
  for (const std::string& pipeline : options.pipelines)
    pipelines.push_back({named_pipeline(pipeline, registry).name, pipeline});
  check_distinct(pipelines);
  check_reference(options, pipelines);
  const bool twice = options.pipelines.size() > 1 || options.variants;
  for (const std::string& sequence : options.sequences)
    if (twice && io::kind_of_source(sequence) == io::SourceKind::Camera)
      throw Error(sequence +
                  ": a camera plays once; record it with `dynfilter run` and --video, then compare");
  options.sequence_names = distinct_names(options.sequences);
}

/// `walking_dynfilter.ply`, `walking_mine_reverse_5.ply`: names tell sequence, pipeline and variant.
std::string map_file(const CompareOptions& options, const RunOptions& run) {
  const std::string pipeline = std::filesystem::path(run.pipeline).stem().string();
  std::string sequence = run.sequence_name;
  std::replace(sequence.begin(), sequence.end(), '/', '_');
  const std::string variant =
      options.variants ? fmt::format("_{}_{}", run.reverse ? "reverse" : "forward", run.start) : "";
  return (std::filesystem::path(options.maps) / (sequence + "_" + pipeline + variant + ".ply")).string();
}

/// All runs in the order of their rows.
std::vector<RunOptions> all_runs(const CompareOptions& options) {
  std::vector<RunOptions> runs;
  RunOptions run = options.run;
  for (std::size_t s = 0; s < options.sequences.size(); ++s) {
    run.sequence = options.sequences[s];
    run.sequence_name = options.sequence_names[s];
    for (const std::string& pipeline : options.pipelines) {
      run.pipeline = pipeline;
      if (!options.variants) {
        runs.push_back(run);
        continue;
      }
      for (const bool reverse : {false, true}) {
        for (const std::size_t start : {0, 5, 10}) {
          run.reverse = reverse;
          run.start = start;
          runs.push_back(run);
        }
      }
    }
  }
  return runs;
}

/// `records`: filled for a report; null: there is none.
std::vector<Row> run_all(const CompareOptions& options, std::vector<report::RunRecord>* records) {
  std::vector<Row> rows;
  std::vector<RunOptions> runs = all_runs(options);
  RecordOptions record;
  const report::RunShare share(runs.size());
  record.pictures = share.pictures, record.picture_bytes = share.picture_bytes, record.rows = share.rows;
  record.map_points = std::min(report::kMostMapPoints, report::kMapPointsOfAllRuns / runs.size());
  Batch batch(runs.size());
  for (std::size_t k = 0; k < runs.size(); ++k) {
    RunOptions& run = runs[k];
    batch.at(k);
    if (!options.maps.empty()) run.map = map_file(options, run);
    Progress bar(fmt::format("{} on {}", run.pipeline, run.sequence_name), &batch);
    if (records != nullptr) record.record = &records->emplace_back();
    Row row{run_sequence(
                run, [&](std::size_t done, std::size_t total) { bar.at(done, total); }, record),
            ""};
    if (options.variants)
      row.variant = fmt::format("{} from {}", run.reverse ? "reverse" : "forward", run.start);
    if (records != nullptr) records->back().variant = row.variant;
    rows.push_back(std::move(row));
  }
  return rows;
}

eval::Provenance provenance() {
  return {DYNFILTER_VERSION, source_commit(), eval::machine_class()};
}

void print_text(const CompareOptions& options, const std::vector<Row>& rows) {
  const bool wide = options.wide, verbose = options.verbose;
  print_rows(rows, wide);
  const std::vector<eval::ComparedRow> medians = shown_medians(rows, options.reference);
  if (!medians.empty()) {
    fmt::print("\n");
    print_table(medians_table(medians), wide);
    if (wide) fmt::print("{}", test_text(rows, options.reference));
  }
  for (const Row& row : rows) {
    if (!verbose || row.summary.stages.empty()) continue;
    const std::string variant = row.variant.empty() ? "" : ", " + row.variant;
    fmt::print("\n{} on {}{}\n{}", row.summary.pipeline, row.summary.sequence, variant,
               stages_text(row.summary.stages, wide));
  }
  print_row_notes(rows, wide);
}

void print_rows_as(const CompareOptions& options, const std::vector<Row>& rows) {
  if (!options.table.empty())
    fmt::print("{}", eval::paper_table(options.table, comparison_of(rows, options.reference), provenance()));
  else if (options.json)
    fmt::print("{}", json_text(to_json(rows, options.reference)));
  else if (options.csv)
    fmt::print("{}", csv_of(rows, options.reference));
  else if (options.markdown)
    fmt::print("{}", markdown_of(rows, options.reference));
  else
    print_text(options, rows);
}

void write_results(ResultsFolder& folder, const std::string& reference, const std::vector<Row>& rows,
                   const std::vector<report::RunRecord>& records) {
  const Json json = to_json(rows, reference);
  folder.write("summary.json", json_text(json));
  folder.write("summary.csv", csv_of(rows, reference));
  const eval::Comparison comparison = comparison_of(rows, reference);
  for (const auto& [name, format] :
       {std::pair{"table.tex", "latex"}, {"table.md", "markdown"}, {"table.csv", "csv"}})
    folder.write(name, eval::paper_table(format, comparison, provenance()));
  folder.write("report.html", report::compare_page(records, json["medians"]));
  folder.commit();
}

void make_folder(const std::string& maps) {
  std::error_code error;
  std::filesystem::create_directories(maps, error);
  if (error) throw IoError("--map " + maps + ": no folder can be made there: " + error.message());
}

/// Rather now than after the first runs.
void check_maps(const CompareOptions& options) {
  if (options.maps.empty()) return;
  std::set<std::string> files;
  for (const RunOptions& run : all_runs(options))
    if (!files.insert(map_file(options, run)).second)
      throw IoError("--map: two runs would write " + map_file(options, run));
  make_folder(options.maps);
}

int compare(CompareOptions& options) {
  check_names(options);
  check_maps(options);
  std::optional<ResultsFolder> folder;
  if (!options.out.empty())
    folder.emplace(options.out, options.force,
                   std::initializer_list<const char*>{"summary.json", "summary.csv", "report.html",
                                                      "table.tex", "table.md", "table.csv"});
  std::vector<report::RunRecord> records;
  const std::vector<Row> rows = run_all(options, folder ? &records : nullptr);
  if (folder) write_results(*folder, options.reference, rows, records);
  print_rows_as(options, rows);
  std::vector<Summary> summaries;
  for (const Row& row : rows) summaries.push_back(row.summary);
  return print_failures(summaries);
}

}  // namespace

void add_compare(CLI::App& app, Action& action) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command =
      app.add_subcommand("compare",
                         "Runs several pipelines on one or more sequences and prints a table. "
                         "If a scene has several runs (seeds of a rendered scene, or "
                         "--variants), also the median of its runs. Different scenes are never "
                         "pooled.");
  command->add_option("SEQUENCE", options->sequences, "folders, videos or images, as `run` takes them")
      ->required()
      ->type_name("INPUT");
  command
      ->add_option("--pipelines", options->pipelines,
                   "presets (`dynfilter presets`) or YAML files, with commas between")
      ->required()
      ->delimiter(',')
      ->type_name("PIPELINE,...");
  add_run_options(*command, options->run);
  command->add_flag("--variants", options->variants,
                    "six runs each: forward and in reverse, from frames 0, 5 and 10");
  command->add_flag("--verbose", options->verbose, "also what each stage did, as `run` prints it");
  command->add_flag("--wide", options->wide, "tables with all columns, whatever the terminal's width");
  CLI::Option* json = command->add_flag("--json", options->json, "print JSON");
  CLI::Option* csv = command->add_flag("--csv", options->csv, "print a line per run, with all digits");
  CLI::Option* markdown =
      command->add_flag("--markdown", options->markdown, "print the table as Markdown, with all columns");
  csv->excludes(json)->excludes(markdown);
  markdown->excludes(json);
  command
      ->add_option("--table", options->table,
                   "print the table for a paper: latex (with booktabs), markdown or csv")
      ->check(CLI::IsMember({"latex", "markdown", "csv"}))
      ->type_name("FORMAT")
      ->excludes(json)
      ->excludes(csv)
      ->excludes(markdown);
  command
      ->add_option(
          "--reference", options->reference,
          "pipeline that the Wilcoxon test compares the others with; by default none, else the first")
      ->type_name("PIPELINE");
  command
      ->add_option(
          "--out", options->out,
          "folder for report.html, a page with all runs, table.tex, table.md, table.csv for a paper, "
          "summary.json and summary.csv")
      ->type_name("FOLDER");
  command->add_flag("--force", options->force, "replace the results of another comparison in --out");
  CLI::Option* map =
      command
          ->add_option("--map", options->maps,
                       "write the dense map of each run to this folder, as SEQUENCE_PIPELINE.ply and .png")
          ->type_name("FOLDER");
  for (CLI::Option* option : add_map_options(*command, options->run)) option->needs(map);
  command->callback([options, &action] {
    action = [options] {
      options->pipelines = without_blanks(options->pipelines);
      return compare(*options);
    };
  });
}

}  // namespace dynfilter::command
