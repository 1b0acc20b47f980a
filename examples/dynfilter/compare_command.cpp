// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <dynfilter/eval/statistics.hpp>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "command.hpp"
#include "progress.hpp"
#include "run_options.hpp"
#include "run_summary.hpp"
#include "sequence_run.hpp"

namespace dynfilter::command {
namespace {

struct CompareOptions {
  std::vector<std::string> sequences, pipelines;
  RunOptions run;
  bool variants = false, json = false;
};

struct Row {
  Summary summary;
  std::string variant;  ///< "" unless variants were requested
};

/// A pipeline over all its rows.
struct Medians {
  std::string pipeline;
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

std::vector<Row> run_all(const CompareOptions& options) {
  std::vector<Row> rows;
  for (const std::string& sequence : options.sequences) {
    for (const std::string& pipeline : options.pipelines) {
      for (const RunOptions& run : runs_of(options, sequence, pipeline)) {
        Progress bar(fmt::format("{} on {}", pipeline, sequence));
        Row row{run_sequence(run, [&](std::size_t done, std::size_t total) { bar.at(done, total); }), ""};
        if (options.variants)
          row.variant = fmt::format("{} from {}", run.reverse ? "reverse" : "forward", run.start);
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

Medians medians_of(const std::string& pipeline, const std::vector<Row>& rows) {
  Medians m;
  m.pipeline = pipeline;
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

// In order of first appearance.
std::vector<Medians> all_medians(const std::vector<Row>& rows) {
  std::vector<std::string> names;
  for (const Row& row : rows) {
    if (std::find(names.begin(), names.end(), row.summary.pipeline) == names.end())
      names.push_back(row.summary.pipeline);
  }
  std::vector<Medians> medians;
  for (const std::string& name : names) {
    std::vector<Row> of_name;
    std::copy_if(rows.begin(), rows.end(), std::back_inserter(of_name),
                 [&](const Row& row) { return row.summary.pipeline == name; });
    medians.push_back(medians_of(name, of_name));
  }
  const auto oracle =
      std::find_if(medians.begin(), medians.end(), [](const Medians& m) { return m.pipeline == "oracle"; });
  if (oracle != medians.end())
    for (Medians& m : medians) m.over_oracle = m.ate_median_m / oracle->ate_median_m;
  return medians;
}

void print_json(const std::vector<Row>& rows) {
  Json json{{"rows", Json::array()}, {"medians", Json::array()}};
  for (const Row& row : rows) {
    json["rows"].push_back(named_json(row.summary));
    if (!row.variant.empty()) json["rows"].back()["variant"] = row.variant;
  }
  for (const Medians& m : all_medians(rows)) {
    json["medians"].push_back({{"pipeline", m.pipeline},
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
  fmt::print("{}", json_text(json));
}

std::string cell(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

using Table = std::vector<std::vector<std::string>>;

// The first `left` columns are left-aligned, figures are right-aligned.
void print_table(const Table& table, std::size_t left) {
  std::vector<std::size_t> widths(table[0].size(), 0);
  for (const auto& line : table) {
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  for (const auto& line : table) {
    std::string text;
    for (std::size_t c = 0; c < line.size(); ++c) {
      text += c < left ? fmt::format("{:<{}}  ", line[c], widths[c])
                       : fmt::format("{:>{}}  ", line[c], widths[c]);
    }
    fmt::print("{}\n", text.substr(0, text.find_last_not_of(' ') + 1));
  }
}

// Prints each note once, with its pipelines unless it concerns all.
void print_notes(const std::vector<Row>& rows) {
  std::vector<std::pair<std::string, std::set<std::string>>> notes;
  std::set<std::string> pipelines;
  for (const Row& row : rows) {
    pipelines.insert(row.summary.pipeline);
    for (const std::string& note : row.summary.notes) {
      const std::string line = row.summary.sequence + ": " + note;
      auto known = std::find_if(notes.begin(), notes.end(), [&](const auto& n) { return n.first == line; });
      if (known == notes.end()) known = notes.insert(notes.end(), {line, {}});
      known->second.insert(row.summary.pipeline);
    }
  }
  if (!notes.empty()) fmt::print("\n");
  for (const auto& [line, of] : notes) {
    fmt::print("note: {}{}\n", line,
               of.size() < pipelines.size() ? fmt::format(" ({})", fmt::join(of, ", ")) : "");
  }
}

void print_text(const std::vector<Row>& rows) {
  Table table{{"sequence", "pipeline", "tracked", "ATE m", "RPE m", "RPE deg", "precision", "recall", "kept",
               "features", "rejected", "ms", "filters ms"}};
  for (const Row& row : rows) {
    const Summary& s = row.summary;
    table.push_back({row.variant.empty() ? s.sequence : s.sequence + ", " + row.variant, s.pipeline,
                     fmt::format("{}/{}", s.tracked_frames, s.frames), cell(s.ate_rmse_m, 4),
                     cell(s.rpe_trans_rmse_m, 4), cell(s.rpe_rot_rmse_deg, 3), cell(s.precision, 3),
                     cell(s.recall, 3), cell(s.static_kept, 3), cell(s.features_mean, 0),
                     cell(s.rejected_mean, 0), cell(s.total_ms, 1), cell(s.filters_ms, 2)});
  }
  print_table(table, 2);
  const std::vector<Medians> medians = all_medians(rows);
  if (medians.size() < rows.size()) {
    Table summary{{"median of all runs", "runs", "tracked", "ATE m", "worst", "/oracle", "recall", "kept",
                   "ms", "filters ms"}};
    for (const Medians& m : medians) {
      summary.push_back({m.pipeline, std::to_string(m.runs), fmt::format("{}/{}", m.tracked_frames, m.frames),
                         cell(m.ate_median_m, 4), cell(m.ate_max_m, 4), cell(m.over_oracle, 2),
                         cell(m.recall, 3), cell(m.static_kept, 3), cell(m.total_ms, 1),
                         cell(m.filters_ms, 2)});
    }
    fmt::print("\n");
    print_table(summary, 1);
  }
  print_notes(rows);
}

}  // namespace

void add_compare(CLI::App& app, Action& action) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand("compare",
                                         "Runs several pipelines on one or more sequences and prints one "
                                         "table; with more runs than pipelines also\n"
                                         "each pipeline's median (several seeds of a scene, or --variants).");
  command->add_option("SEQUENCE", options->sequences, "folders")->required();
  command->add_option("--pipelines", options->pipelines, "presets or YAML files, with commas between")
      ->required()
      ->delimiter(',');
  add_run_options(*command, options->run);
  command->add_flag("--variants", options->variants,
                    "six runs each: forward and in reverse, from frames 0, 5 and 10");
  command->add_flag("--json", options->json, "print JSON");
  command->callback([options, &action] {
    action = [options] {
      options->pipelines = without_blanks(options->pipelines);
      const std::vector<Row> rows = run_all(*options);
      options->json ? print_json(rows) : print_text(rows);
      const bool all_lost = std::any_of(rows.begin(), rows.end(),
                                        [](const Row& row) { return row.summary.tracked_frames == 0; });
      return static_cast<int>(all_lost ? kFailed : kDone);
    };
  });
}

}  // namespace dynfilter::command
