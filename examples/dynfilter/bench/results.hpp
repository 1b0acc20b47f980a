// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/version.hpp>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <string>
#include <vector>

#include "bench/manifest.hpp"
#include "io/atomic_file.hpp"
#include "text/json.hpp"
#include "text/table.hpp"

namespace dynfilter::command {

/// One line of the results: a run of ours, or figures of a paper.
struct BenchRow {
  std::string sequence, system;
  std::string alignment = "SE(3)";  ///< or "Sim(3)": one camera has no scale of its own
  std::string state;                ///< "", "missing" (no data), "failed", "published"
  std::string note;                 ///< why it failed; of a paper: what the system is
  std::string link;                 ///< page of the run, relative to the results
  std::size_t frames = 0, tracked_frames = 0;
  double ate_rmse_m = NAN, rpe_trans_rmse_m = NAN, recall = NAN, static_kept = NAN, total_ms = NAN;
};

inline Json to_json(const BenchRow& row) {
  return {{"sequence", row.sequence},
          {"system", row.system},
          {"state", row.state},
          {"note", row.note},
          {"alignment", row.alignment},
          {"frames", row.frames},
          {"tracked_frames", row.tracked_frames},
          {"ate_rmse_m", number_or_null(row.ate_rmse_m)},
          {"rpe_trans_rmse_m", number_or_null(row.rpe_trans_rmse_m)},
          {"recall", number_or_null(row.recall)},
          {"static_kept", number_or_null(row.static_kept)},
          {"ms_total", number_or_null(row.total_ms)}};
}

/// Ours to a tenth of a millimetre, those of papers with the digits that they print.
inline std::string ate_cm_text(const BenchRow& row) {
  constexpr int kOurDigits = 2;
  if (!std::isfinite(row.ate_rmse_m)) return "";
  return row.state == "published" ? number_text(100 * row.ate_rmse_m)
                                  : cell(100 * row.ate_rmse_m, kOurDigits);
}

/// Of a sequence that is not there, one row is enough.
inline std::vector<BenchRow> shown_rows(const std::vector<BenchRow>& rows) {
  std::vector<BenchRow> shown;
  for (const BenchRow& row : rows) {
    const bool missing = row.state == "missing";
    if (missing && !shown.empty() && shown.back().state == "missing" && shown.back().sequence == row.sequence)
      continue;
    shown.push_back(row);
    if (missing) shown.back().system = "ours", shown.back().alignment.clear();
  }
  return shown;
}

inline Table bench_table(const std::vector<BenchRow>& rows) {
  Table table({{"sequence", true},
               {"system", true},
               {"alignment", true, 1},
               {"tracked"},
               {"ATE cm"},
               {"RPE m", false, 4},
               {"recall", false, 3},
               {"kept", false, 3},
               {"ms", false, 2},
               {"", true}});
  for (const BenchRow& row : shown_rows(rows)) {
    const std::string tracked = row.frames > 0 ? fmt::format("{}/{}", row.tracked_frames, row.frames) : "";
    table.add({row.sequence, row.system, row.alignment, tracked, ate_cm_text(row),
               cell(row.rpe_trans_rmse_m, 4), cell(row.recall, 3), cell(row.static_kept, 3),
               cell(row.total_ms, 1), row.state});
  }
  return table;
}

inline double number_in(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_number() ? json[key].get<double>() : NAN;
}

/// What a result must be of, to be that of a row.
struct RunIdentity {
  std::string folder;           ///< of the sequence, canonical
  std::string pipeline_digest;  ///< of the pipeline's text
};

/// The run in a folder, from its summary.json. False if there is none that is complete and of this identity:
/// the pipeline was edited, or the data are in another folder.
inline bool read_run(const std::filesystem::path& folder, const RunIdentity& identity, BenchRow& row) {
  std::ifstream in(folder / "summary.json");
  const Json json = in ? Json::parse(in, nullptr, false) : Json();
  if (!json.is_object() || !json.contains("frames")) return false;
  if (json.value("folder", "") != identity.folder ||
      json.value("pipeline_digest", "") != identity.pipeline_digest)
    return false;
  row.frames = json["frames"].get<std::size_t>();
  row.tracked_frames = json["tracked_frames"].get<std::size_t>();
  row.ate_rmse_m = number_in(json, "ate_rmse_m");
  row.rpe_trans_rmse_m = number_in(json, "rpe_trans_rmse_m");
  row.recall = number_in(json, "recall");
  row.static_kept = number_in(json, "static_kept");
  if (json.value("sensor", "") == "mono") row.alignment = "Sim(3)";
  row.total_ms = json.contains("ms") ? number_in(json["ms"], "total") : NAN;
  if (json.contains("failure") && json["failure"].is_string())
    row.state = "failed", row.note = json["failure"].get<std::string>();
  return true;
}

/// What all runs of a results folder have in common.
struct BenchSettings {
  std::string manifest;
  std::size_t frames = 0;  ///< 0: all

  Json json() const { return {{"manifest", manifest}, {"frames", frames}, {"version", DYNFILTER_VERSION}}; }
};

/// Resuming must not mix runs of different settings. Throws IoError.
inline void check_settings(const std::filesystem::path& folder, const BenchSettings& settings, bool force) {
  std::ifstream in(folder / "bench.json");
  if (!in || force) return;
  const Json found = Json::parse(in, nullptr, false);
  if (found.is_object() && found.contains("settings") && found["settings"] == settings.json()) return;
  throw IoError("--out " + folder.string() +
                ": holds runs of another manifest, version or --frames: choose another folder, or run them "
                "again with --force");
}

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  io::write_file_atomically(path, [&](std::ostream& out) { out << text; });
}

/// bench.json: after every run, so that an interrupted benchmark is readable.
inline void write_results(const std::filesystem::path& folder, const BenchSettings& settings,
                          const std::vector<BenchRow>& rows) {
  Json json{{"settings", settings.json()}, {"rows", Json::array()}};
  for (const BenchRow& row : rows) json["rows"].push_back(to_json(row));
  write_text(folder / "bench.json", json_text(json));
}

}  // namespace dynfilter::command
