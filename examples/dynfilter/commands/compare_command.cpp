// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <dynfilter/core/error.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <dynfilter/eval/statistics.hpp>
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
#include "report/map_sample.hpp"
#include "report/page.hpp"
#include "report/picture.hpp"
#include "run_options.hpp"
#include "running/results_folder.hpp"
#include "running/run_summary.hpp"
#include "running/sequence_run.hpp"
#include "text/progress.hpp"
#include "text/table.hpp"

namespace dynfilter::command {
namespace {

struct CompareOptions {
  std::vector<std::string> sequences, pipelines;
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

/// `walking_dynfilter.ply`, `walking_mine_reverse_5.ply`: names tell sequence, pipeline and variant.
std::string map_file(const CompareOptions& options, const RunOptions& run) {
  const auto name_of = [](const std::string& path) {
    std::filesystem::path name = std::filesystem::path(path).lexically_normal();
    if (!name.has_filename()) name = name.parent_path();
    return name.filename().string();
  };
  const std::string pipeline = std::filesystem::path(name_of(run.pipeline)).stem().string();
  const std::string variant =
      options.variants ? fmt::format("_{}_{}", run.reverse ? "reverse" : "forward", run.start) : "";
  return (std::filesystem::path(options.maps) / (name_of(run.sequence) + "_" + pipeline + variant + ".ply"))
      .string();
}

std::vector<RunOptions> runs_of(const CompareOptions& options, const std::string& sequence,
                                const std::string& pipeline) {
  RunOptions run = options.run;
  run.sequence = sequence;
  run.pipeline = pipeline;
  if (!options.variants) return {run};
  std::vector<RunOptions> runs;
  for (const bool reverse : {false, true}) {
    for (const std::size_t start : {0, 5, 10}) {
      run.reverse = reverse;
      run.start = start;
      runs.push_back(run);
    }
  }
  return runs;
}

/// `records`: filled for a report; null: there is none.
std::vector<Row> run_all(const CompareOptions& options, std::vector<report::RunRecord>* records) {
  std::vector<Row> rows;
  const std::size_t runs = options.sequences.size() * options.pipelines.size() * (options.variants ? 6 : 1);
  RecordOptions record;
  record.pictures = std::max<std::size_t>(1, report::kMostPictures / runs);
  record.picture_bytes = report::kPictureBytes / runs;
  record.map_points = std::min(report::kMostMapPoints, report::kMapPointsOfAllRuns / runs);
  for (const std::string& sequence : options.sequences) {
    for (const std::string& pipeline : options.pipelines) {
      for (RunOptions run : runs_of(options, sequence, pipeline)) {
        if (!options.maps.empty()) run.map = map_file(options, run);
        Progress bar(fmt::format("{} on {}", pipeline, sequence));
        if (records != nullptr) record.record = &records->emplace_back();
        Row row{run_sequence(
                    run, [&](std::size_t done, std::size_t total) { bar.at(done, total); }, record),
                ""};
        if (options.variants)
          row.variant = fmt::format("{} from {}", run.reverse ? "reverse" : "forward", run.start);
        if (records != nullptr) records->back().variant = row.variant;
        rows.push_back(std::move(row));
      }
    }
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
          {"coverage"}};
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
          fmt::format("{}/{}", s.tracked_frames, s.frames),
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
          cell(map.coverage, 3)};
}

std::string markdown_of(const std::vector<Row>& rows) {
  Table table(row_columns());
  for (const Row& row : rows) table.add(cells_of(row));
  return table.markdown();
}

/// The figures of all rows as they are. Empty: there is none.
std::string csv_of(const std::vector<Row>& rows) {
  std::string csv =
      "sequence,run,pipeline,frames,tracked_frames,ate_rmse_m,rpe_trans_rmse_m,rpe_rot_rmse_deg,precision,"
      "recall,static_kept,features_mean,rejected_mean,ms_total,ms_extraction,ms_correspondence,ms_filters,"
      "ms_tracking,map_points,map_ghosts,map_coverage,map_error_median_m\n";
  for (const Row& row : rows) {
    const Summary& s = row.summary;
    csv += fmt::format("{},{},{},{},{}", detail_table::csv_field(s.sequence), row.variant,
                       detail_table::csv_field(s.pipeline), s.frames, s.tracked_frames);
    const MapTruthSummary map = map_truth(s);
    const double map_points = s.map ? static_cast<double>(s.map->points) : NAN;
    for (const double figure :
         {s.ate_rmse_m, s.rpe_trans_rmse_m, s.rpe_rot_rmse_deg, s.precision, s.recall, s.static_kept,
          s.features_mean, s.rejected_mean, s.total_ms, s.extraction_ms, s.correspondence_ms, s.filters_ms,
          s.tracking_ms, map_points, map.ghosts, map.coverage, map.error_median_m})
      csv += std::isfinite(figure) ? fmt::format(",{}", figure) : ",";
    csv += "\n";
  }
  return csv;
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

void print_medians(const std::vector<Medians>& medians, bool wide) {
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
    table.add({std::filesystem::path(m.scene).filename().string(), m.pipeline, std::to_string(m.runs),
               fmt::format("{}/{}", m.tracked_frames, m.frames), cell(m.ate_median_m, 4),
               cell(m.ate_max_m, 4), cell(m.over_oracle, 2), cell(m.recall, 3), cell(m.static_kept, 3),
               cell(m.total_ms, 1), cell(m.filters_ms, 2)});
  fmt::print("\n");
  print_table(table, wide);
}

void print_text(const std::vector<Row>& rows, bool wide, bool verbose) {
  print_rows(rows, wide);
  const std::vector<Medians> medians = all_medians(rows);
  if (medians.size() < rows.size()) print_medians(medians, wide);
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
  for (const std::string& sequence : options.sequences)
    for (const std::string& pipeline : options.pipelines)
      for (const RunOptions& run : runs_of(options, sequence, pipeline))
        if (!files.insert(map_file(options, run)).second)
          throw IoError("--map: two runs would write " + map_file(options, run));
  make_folder(options.maps);
}

int compare(const CompareOptions& options) {
  check_maps(options);
  std::optional<ResultsFolder> folder;
  if (!options.out.empty())
    folder.emplace(options.out, options.force,
                   std::initializer_list<const char*>{"summary.json", "summary.csv", "report.html"});
  std::vector<report::RunRecord> records;
  const std::vector<Row> rows = run_all(options, folder ? &records : nullptr);
  if (folder) write_results(*folder, rows, records);
  print_rows_as(options, rows);
  const bool any_lost =
      std::any_of(rows.begin(), rows.end(), [](const Row& row) { return row.summary.tracked_frames == 0; });
  return any_lost ? kFailed : kDone;
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
  command->add_option("SEQUENCE", options->sequences, "folders, as `run` takes them")
      ->required()
      ->type_name("FOLDER");
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
