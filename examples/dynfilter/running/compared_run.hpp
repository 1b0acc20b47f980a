// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "eval/comparison.hpp"
#include "run_summary.hpp"
#include "text/json.hpp"

// A run as a comparison takes it. For the command and for Python alike.
namespace dynfilter::command {

inline eval::ComparedRun compared_run(const Summary& s, const std::string& variant) {
  eval::ComparedRun run;
  run.scene = s.scene, run.sequence = s.sequence, run.variant = variant, run.pipeline = s.pipeline;
  // That of a recording is its folder's path.
  run.place = s.scene == s.folder ? s.sequence : s.scene;
  run.alignment = s.sensor == "mono" ? "Sim(3)" : "SE(3)";  // one camera has no scale of its own
  run.failed = !s.failure.empty(), run.has_poses = !s.verdicts_only;
  run.frames = s.frames, run.tracked_frames = s.tracked_frames;
  run.first_s = s.first_s, run.last_s = s.last_s;
  run.ate_rmse_m = s.ate_rmse_m, run.rpe_trans_rmse_m = s.rpe_trans_rmse_m;
  run.recall = s.recall, run.static_kept = s.static_kept;
  run.total_ms = s.total_ms, run.filters_ms = s.filters_ms, run.cpu_ms = s.cpu_ms;
  return run;
}

/// "medians" of `compare --json`.
inline Json medians_json(const eval::Comparison& comparison) {
  Json medians = Json::array();
  for (const eval::ComparedRow& m : comparison.rows)
    medians.push_back({{"scene", m.scene},
                       {"pipeline", m.pipeline},
                       {"alignment", m.alignment},
                       {"runs", m.runs},
                       {"frames", m.frames},
                       {"tracked_frames", m.tracked_frames},
                       {"ate_rmse_m", number_or_null(m.ate_median_m)},
                       {"ate_rmse_max_m", number_or_null(m.ate_worst_m)},
                       {"ate_rmse_mean_m", number_or_null(m.ate_mean_m)},
                       {"ate_rmse_std_m", number_or_null(m.ate_std_m)},
                       {"ate_over_oracle", number_or_null(m.over_oracle)},
                       {"rpe_trans_rmse_m", number_or_null(m.rpe_median_m)},
                       {"recall", number_or_null(m.recall)},
                       {"static_kept", number_or_null(m.static_kept)},
                       {"ms_total", number_or_null(m.total_ms)},
                       {"ms_filters", number_or_null(m.filters_ms)},
                       {"cpu_ms", number_or_null(m.cpu_ms)},
                       {"reference", comparison.reference},
                       {"pairs", m.against_reference.pairs},
                       {"p_value", number_or_null(m.against_reference.p)}});
  return medians;
}

}  // namespace dynfilter::command
