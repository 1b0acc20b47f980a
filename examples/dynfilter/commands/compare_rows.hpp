// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "eval/comparison.hpp"
#include "eval/table_text.hpp"
#include "running/compared_run.hpp"
#include "running/run_summary.hpp"
#include "text/json.hpp"
#include "text/table.hpp"

// What `compare` prints of its runs.
namespace dynfilter::command {

struct Row {
  Summary summary;
  std::string variant;  ///< "" unless variants were requested
};

// Prints each note once, with its pipelines unless it applies to all.
inline void print_row_notes(const std::vector<Row>& rows, bool wide) {
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

inline std::vector<Column> row_columns() {
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
inline MapTruthSummary map_truth(const Summary& s) {
  return s.map && s.map->truth ? *s.map->truth : MapTruthSummary();
}

inline std::vector<std::string> cells_of(const Row& row) {
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
inline void print_rows(const std::vector<Row>& rows, bool wide) {
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

inline Table medians_table(const std::vector<eval::ComparedRow>& medians) {
  Table table({{"median of runs", true},
               {"pipeline", true},
               {"runs"},
               {"tracked", false, 1},
               {"ATE m"},
               {"worst"},
               {"mean", false, 5},
               {"std", false, 4},
               {"p", false, 6},
               {"/oracle"},
               {"recall"},
               {"kept"},
               {"ms", false, 2},
               {"filters ms", false, 3}});
  for (const eval::ComparedRow& m : medians)
    table.add({m.place, m.pipeline, std::to_string(m.runs), fmt::format("{}/{}", m.tracked_frames, m.frames),
               cell(m.ate_median_m, 4), cell(m.ate_worst_m, 4), cell(m.ate_mean_m, 4), cell(m.ate_std_m, 4),
               cell(m.against_reference.p, 3), cell(m.over_oracle, 2), cell(m.recall, 3),
               cell(m.static_kept, 3), cell(m.total_ms, 1), cell(m.filters_ms, 2)});
  return table;
}

inline eval::Comparison comparison_of(const std::vector<Row>& rows, const std::string& reference) {
  std::vector<eval::ComparedRun> runs;
  for (const Row& row : rows) runs.push_back(compared_run(row.summary, row.variant));
  return eval::compare_runs(runs, reference);
}

/// Empty unless a pipeline has several runs of one scene.
inline std::vector<eval::ComparedRow> shown_medians(const std::vector<Row>& rows,
                                                    const std::string& reference) {
  std::vector<eval::ComparedRow> medians = comparison_of(rows, reference).rows;
  if (medians.size() == rows.size()) medians.clear();
  return medians;
}

/// What the column p is, which wide tables have.
inline std::string test_text(const std::vector<Row>& rows, const std::string& reference) {
  const eval::Comparison comparison = comparison_of(rows, reference);
  std::size_t pairs = 0;
  for (const eval::ComparedRow& row : comparison.rows) pairs = std::max(pairs, row.against_reference.pairs);
  return pairs == 0 ? ""
                    : fmt::format(
                          "p: Wilcoxon signed-rank test of the ATE against {}; of {} pairs at least "
                          "{:.2g}.\n",
                          comparison.reference, pairs, eval::least_signed_rank_p(pairs));
}

inline Json to_json(const std::vector<Row>& rows, const std::string& reference) {
  Json json{{"rows", Json::array()}};
  for (const Row& row : rows) {
    json["rows"].push_back(named_json(row.summary));
    if (!row.variant.empty()) json["rows"].back()["variant"] = row.variant;
  }
  json["medians"] = medians_json(comparison_of(rows, reference));
  return json;
}

inline std::string markdown_of(const std::vector<Row>& rows, const std::string& reference) {
  Table table(row_columns());
  for (const Row& row : rows) table.add(cells_of(row));
  const std::vector<eval::ComparedRow> medians = shown_medians(rows, reference);
  return table.markdown() + (medians.empty() ? "" : "\n" + medians_table(medians).markdown());
}

inline std::string csv_figures(const std::vector<double>& figures) {
  std::string csv;
  for (const double figure : figures) csv += std::isfinite(figure) ? fmt::format(",{}", figure) : ",";
  return csv;
}

inline std::string csv_line(const Row& row) {
  const Summary& s = row.summary;
  const MapTruthSummary map = map_truth(s);
  const double map_points = s.map ? static_cast<double>(s.map->points) : NAN;
  std::vector<std::string> notes = s.notes;
  notes.insert(notes.end(), s.stage_notes.begin(), s.stage_notes.end());
  if (!s.failure.empty()) notes.insert(notes.begin(), "failed: " + s.failure);
  return fmt::format("{},{},{},{},{}", eval::csv_field(s.sequence), row.variant, eval::csv_field(s.pipeline),
                     s.frames, s.tracked_frames) +
         csv_figures(
             {s.ate_rmse_m,        s.rpe_trans_rmse_m, s.rpe_rot_rmse_deg, s.precision, s.recall,
              s.static_kept,       s.features_mean,    s.rejected_mean,    s.total_ms,  s.extraction_ms,
              s.correspondence_ms, s.filters_ms,       s.tracking_ms,      map_points,  map.ghosts,
              map.coverage,        map.error_median_m, s.cpu_ms,           NAN,         NAN}) +
         "," + eval::csv_field(fmt::format("{}", fmt::join(notes, "; "))) + "\n";
}

inline std::string csv_line(const eval::ComparedRow& m) {
  const std::vector<double> before_recall{m.ate_median_m, m.rpe_median_m, NAN, NAN};
  const std::vector<double> times{m.recall, m.static_kept, NAN, NAN, m.total_ms, NAN, NAN, m.filters_ms, NAN};
  const std::vector<double> after_maps{m.cpu_ms, m.ate_worst_m, m.over_oracle};
  return fmt::format("{},median of {},{},{},{}", eval::csv_field(m.place), m.runs,
                     eval::csv_field(m.pipeline), m.frames, m.tracked_frames) +
         csv_figures(before_recall) + csv_figures(times) + csv_figures(std::vector<double>(4, NAN)) +
         csv_figures(after_maps) + ",\n";
}

/// The figures of all rows as they are, then the medians. Empty: there is none.
inline std::string csv_of(const std::vector<Row>& rows, const std::string& reference) {
  std::string csv =
      "sequence,run,pipeline,frames,tracked_frames,ate_rmse_m,rpe_trans_rmse_m,rpe_rot_rmse_deg,precision,"
      "recall,static_kept,features_mean,rejected_mean,ms_total,ms_extraction,ms_correspondence,ms_filters,"
      "ms_tracking,map_points,map_ghosts,map_coverage,map_error_median_m,cpu_ms,ate_rmse_max_m,"
      "ate_over_oracle,notes\n";
  for (const Row& row : rows) csv += csv_line(row);
  for (const eval::ComparedRow& m : shown_medians(rows, reference)) csv += csv_line(m);
  return csv;
}

}  // namespace dynfilter::command
