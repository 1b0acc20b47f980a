// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <dynfilter/core/error.hpp>

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
#include "eval/statistics.hpp"
#include "io/sequence_source.hpp"
#include "report/map_sample.hpp"
#include "report/page.hpp"
#include "report/picture.hpp"
#include "run_and_print.hpp"
#include "run_options.hpp"
#include "running/command_registry.hpp"
#include "running/distinct_names.hpp"
#include "running/results_folder.hpp"
#include "running/run_summary.hpp"
#include "running/sequence_run.hpp"
#include "text/progress.hpp"
#include "text/table.hpp"

namespace dynfilter::command {
namespace {

struct CompareOptions {
  std::vector<std::string> sequences, pipelines;
  std::vector<std::string> sequence_names;  ///< in the rows: no two are the same
  RunOptions run;
  bool variants = false, json = false, csv = false, markdown = false, wide = false, verbose = false;
  std::string out, maps;
  bool force = false;
};

struct Row {
  Summary summary;
  std::string variant;  ///< "" unless variants were requested
};

/// Results of one pipeline over all its runs of one scene.
struct Medians {
  std::string scene, pipeline;
  std::string place;  ///< the scene for readers: no path
  std::size_t runs = 0, frames = 0, tracked_frames = 0;
  double ate_median_m = NAN, ate_max_m = NAN, recall = NAN, static_kept = NAN;
  double over_oracle = NAN;  ///< median ATE over that of the pipeline `oracle`, if it is included
  double total_ms = NAN, filters_ms = NAN;
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

/// Rows are told apart by names. Also finds what is wrong with a pipeline before the first run.
void check_names(CompareOptions& options) {
  const Registry registry = command_registry(options.run.plugins);
  std::vector<NamedSource> pipelines;
  for (const std::string& pipeline : options.pipelines)
    pipelines.push_back({named_pipeline(pipeline, registry).name, pipeline});
  check_distinct(pipelines);
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
  record.pictures = std::max<std::size_t>(1, report::kMostPictures / runs.size());
  record.picture_bytes = report::kPictureBytes / runs.size();
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

double median_of_known(const std::vector<Row>& rows, double Summary::*member) {
  std::vector<double> known;
  for (const Row& row : rows) {
    if (std::isfinite(row.summary.*member)) known.push_back(row.summary.*member);
  }
  return eval::median(known);
}

Medians medians_of(const std::vector<Row>& rows) {
  Medians m;
  m.scene = rows[0].summary.scene;
  // That of a recording is its folder's path.
  m.place = m.scene == rows[0].summary.folder ? rows[0].summary.sequence : m.scene;
  m.pipeline = rows[0].summary.pipeline;
  m.runs = rows.size();
  for (const Row& row : rows) {
    m.frames += row.summary.frames;
    m.tracked_frames += row.summary.tracked_frames;
    if (!(m.ate_max_m >= row.summary.ate_rmse_m)) m.ate_max_m = row.summary.ate_rmse_m;
  }
  m.ate_median_m = median_of_known(rows, &Summary::ate_rmse_m);
  m.recall = median_of_known(rows, &Summary::recall);
  m.static_kept = median_of_known(rows, &Summary::static_kept);
  m.total_ms = median_of_known(rows, &Summary::total_ms);
  m.filters_ms = median_of_known(rows, &Summary::filters_ms);
  return m;
}

/// In the order in which scenes and pipelines first appear.
/// Different scenes are never pooled, because their errors differ in scale.
std::vector<Medians> all_medians(const std::vector<Row>& rows) {
  std::vector<std::vector<Row>> groups;
  for (const Row& row : rows) {
    const auto same = [&row](const std::vector<Row>& group) {
      return group[0].summary.scene == row.summary.scene && group[0].summary.pipeline == row.summary.pipeline;
    };
    auto group = std::find_if(groups.begin(), groups.end(), same);
    if (group == groups.end()) group = groups.insert(groups.end(), {{}});
    group->push_back(row);
  }
  std::vector<Medians> medians;
  for (const std::vector<Row>& group : groups) medians.push_back(medians_of(group));
  for (Medians& m : medians)
    for (const Medians& other : medians)
      if (other.scene == m.scene && other.pipeline == "oracle")
        m.over_oracle = m.ate_median_m / other.ate_median_m;
  return medians;
}

Json to_json(const std::vector<Row>& rows) {
  Json json{{"rows", Json::array()}, {"medians", Json::array()}};
  for (const Row& row : rows) {
    json["rows"].push_back(named_json(row.summary));
    if (!row.variant.empty()) json["rows"].back()["variant"] = row.variant;
  }
  for (const Medians& m : all_medians(rows)) {
    json["medians"].push_back({{"scene", m.scene},
                               {"pipeline", m.pipeline},
                               {"runs", m.runs},
                               {"frames", m.frames},
                               {"tracked_frames", m.tracked_frames},
                               {"ate_rmse_m", number_or_null(m.ate_median_m)},
                               {"ate_rmse_max_m", number_or_null(m.ate_max_m)},
                               {"ate_over_oracle", number_or_null(m.over_oracle)},
                               {"recall", number_or_null(m.recall)},
                               {"static_kept", number_or_null(m.static_kept)},
                               {"ms_total", number_or_null(m.total_ms)},
                               {"ms_filters", number_or_null(m.filters_ms)}});
  }
  return json;
}

// Prints each note once, with its pipelines unless it applies to all.
void print_row_notes(const std::vector<Row>& rows, bool wide) {
  std::vector<std::pair<std::string, std::set<std::string>>> notes;
  std::set<std::string> pipelines;
  for (const Row& row : rows) {
    pipelines.insert(row.summary.pipeline);
    std::vector<std::string> own = row.summary.notes;
    own.insert(own.end(), row.summary.stage_notes.begin(), row.summary.stage_notes.end());
    for (const std::string& note : own) {
      const std::string line = row.summary.sequence + ": " + note;
      auto known = std::find_if(notes.begin(), notes.end(), [&](const auto& n) { return n.first == line; });
      if (known == notes.end()) known = notes.insert(notes.end(), {line, {}});
      known->second.insert(row.summary.pipeline);
    }
  }
  if (!notes.empty()) fmt::print("\n");
  for (const auto& [line, of] : notes) {
    const std::string who = of.size() < pipelines.size() ? fmt::format(" ({})", fmt::join(of, ", ")) : "";
    fmt::print("{}", wrapped("note: " + line + who, wide ? 1000 : text_columns()));
  }
}

std::vector<Column> row_columns() {
  return {{"sequence", true},
          {"run", true},
          {"pipeline", true},
          {"tracked"},
          {"ATE m"},
          {"RPE m", false, 5},
          {"RPE deg", false, 7},
          {"precision", false, 6},
          {"recall"},
          {"kept"},
          {"features", false, 8},
          {"rejected", false, 4},
          {"ms", false, 2},
          {"filters ms", false, 3},
          {"map points", false, 9},
          {"ghosts"},
          {"coverage"},
          {"", true}};
}

/// Figures of a map against the truth; NaN without.
MapTruthSummary map_truth(const Summary& s) {
  return s.map && s.map->truth ? *s.map->truth : MapTruthSummary();
}

std::vector<std::string> cells_of(const Row& row) {
  const Summary& s = row.summary;
  const MapTruthSummary map = map_truth(s);
  return {s.sequence,
          row.variant,
          s.pipeline,
          s.verdicts_only ? "-" : fmt::format("{}/{}", s.tracked_frames, s.frames),
          cell(s.ate_rmse_m, 4),
          cell(s.rpe_trans_rmse_m, 4),
          cell(s.rpe_rot_rmse_deg, 3),
          cell(s.precision, 3),
          cell(s.recall, 3),
          cell(s.static_kept, 3),
          cell(s.features_mean, 0),
          cell(s.rejected_mean, 0),
          cell(s.total_ms, 1),
          cell(s.filters_ms, 2),
          s.map ? std::to_string(s.map->points) : "",
          cell(map.ghosts, 4),
          cell(map.coverage, 3),
          s.failure.empty() ? "" : "failed"};
}

/// One table for all sequences, or one per sequence, because names of sequences may be long.
void print_rows(const std::vector<Row>& rows, bool wide) {
  if (wide) {
    Table table(row_columns());
    for (const Row& row : rows) table.add(cells_of(row));
    return print_table(table, true);
  }
  for (std::size_t begin = 0; begin < rows.size();) {
    Table table(row_columns());
    const std::string sequence = rows[begin].summary.sequence, scene = rows[begin].summary.scene;
    for (; begin < rows.size() && rows[begin].summary.sequence == sequence &&
           rows[begin].summary.scene == scene;
         ++begin) {
      std::vector<std::string> cells = cells_of(rows[begin]);
      cells[0].clear();
      table.add(std::move(cells));
    }
    fmt::print("{}\n", sequence);
    print_table(table, false);
    if (begin < rows.size()) fmt::print("\n");
  }
}

Table medians_table(const std::vector<Medians>& medians) {
  Table table({{"median of runs", true},
               {"pipeline", true},
               {"runs"},
               {"tracked", false, 1},
               {"ATE m"},
               {"worst"},
               {"/oracle"},
               {"recall"},
               {"kept"},
               {"ms", false, 2},
               {"filters ms", false, 3}});
  for (const Medians& m : medians)
    table.add({m.place, m.pipeline, std::to_string(m.runs), fmt::format("{}/{}", m.tracked_frames, m.frames),
               cell(m.ate_median_m, 4), cell(m.ate_max_m, 4), cell(m.over_oracle, 2), cell(m.recall, 3),
               cell(m.static_kept, 3), cell(m.total_ms, 1), cell(m.filters_ms, 2)});
  return table;
}

/// Empty unless a pipeline has several runs of one scene.
std::vector<Medians> shown_medians(const std::vector<Row>& rows) {
  std::vector<Medians> medians = all_medians(rows);
  if (medians.size() == rows.size()) medians.clear();
  return medians;
}

std::string markdown_of(const std::vector<Row>& rows) {
  Table table(row_columns());
  for (const Row& row : rows) table.add(cells_of(row));
  const std::vector<Medians> medians = shown_medians(rows);
  return table.markdown() + (medians.empty() ? "" : "\n" + medians_table(medians).markdown());
}

std::string csv_figures(const std::vector<double>& figures) {
  std::string csv;
  for (const double figure : figures) csv += std::isfinite(figure) ? fmt::format(",{}", figure) : ",";
  return csv;
}

std::string csv_line(const Row& row) {
  const Summary& s = row.summary;
  const MapTruthSummary map = map_truth(s);
  const double map_points = s.map ? static_cast<double>(s.map->points) : NAN;
  std::vector<std::string> notes = s.notes;
  notes.insert(notes.end(), s.stage_notes.begin(), s.stage_notes.end());
  if (!s.failure.empty()) notes.insert(notes.begin(), "failed: " + s.failure);
  return fmt::format("{},{},{},{},{}", detail_table::csv_field(s.sequence), row.variant,
                     detail_table::csv_field(s.pipeline), s.frames, s.tracked_frames) +
         csv_figures(
             {s.ate_rmse_m,        s.rpe_trans_rmse_m, s.rpe_rot_rmse_deg, s.precision, s.recall,
              s.static_kept,       s.features_mean,    s.rejected_mean,    s.total_ms,  s.extraction_ms,
              s.correspondence_ms, s.filters_ms,       s.tracking_ms,      map_points,  map.ghosts,
              map.coverage,        map.error_median_m, s.cpu_ms,           NAN,         NAN}) +
         "," + detail_table::csv_field(fmt::format("{}", fmt::join(notes, "; "))) + "\n";
}

std::string csv_line(const Medians& m) {
  return fmt::format("{},median of {},{},{},{}", detail_table::csv_field(m.place), m.runs,
                     detail_table::csv_field(m.pipeline), m.frames, m.tracked_frames) +
         csv_figures({m.ate_median_m,
                      NAN,
                      NAN,
                      NAN,
                      m.recall,
                      m.static_kept,
                      NAN,
                      NAN,
                      m.total_ms,
                      NAN,
                      NAN,
                      m.filters_ms,
                      NAN,
                      NAN,
                      NAN,
                      NAN,
                      NAN,
                      NAN,
                      m.ate_max_m,
                      m.over_oracle}) +
         ",\n";
}

/// The figures of all rows as they are, then the medians. Empty: there is none.
std::string csv_of(const std::vector<Row>& rows) {
  std::string csv =
      "sequence,run,pipeline,frames,tracked_frames,ate_rmse_m,rpe_trans_rmse_m,rpe_rot_rmse_deg,precision,"
      "recall,static_kept,features_mean,rejected_mean,ms_total,ms_extraction,ms_correspondence,ms_filters,"
      "ms_tracking,map_points,map_ghosts,map_coverage,map_error_median_m,cpu_ms,ate_rmse_max_m,"
      "ate_over_oracle,notes\n";
  for (const Row& row : rows) csv += csv_line(row);
  for (const Medians& m : shown_medians(rows)) csv += csv_line(m);
  return csv;
}

void print_text(const std::vector<Row>& rows, bool wide, bool verbose) {
  print_rows(rows, wide);
  if (const std::vector<Medians> medians = shown_medians(rows); !medians.empty()) {
    fmt::print("\n");
    print_table(medians_table(medians), wide);
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
  if (options.json)
    fmt::print("{}", json_text(to_json(rows)));
  else if (options.csv)
    fmt::print("{}", csv_of(rows));
  else if (options.markdown)
    fmt::print("{}", markdown_of(rows));
  else
    print_text(rows, options.wide, options.verbose);
}

void write_results(ResultsFolder& folder, const std::vector<Row>& rows,
                   const std::vector<report::RunRecord>& records) {
  const Json json = to_json(rows);
  folder.write("summary.json", json_text(json));
  folder.write("summary.csv", csv_of(rows));
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
                   std::initializer_list<const char*>{"summary.json", "summary.csv", "report.html"});
  std::vector<report::RunRecord> records;
  const std::vector<Row> rows = run_all(options, folder ? &records : nullptr);
  if (folder) write_results(*folder, rows, records);
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
      ->add_option("--out", options->out,
                   "folder for report.html, a page with all runs, summary.json and summary.csv")
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
