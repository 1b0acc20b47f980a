// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "eval/signed_rank.hpp"

namespace dynfilter::eval {

/// One run of a comparison. NaN where there is nothing to measure.
struct ComparedRun {
  std::string scene;              ///< runs of one scene and pipeline are pooled
  std::string place;              ///< the scene for readers: no path
  std::string sequence, variant;  ///< together: what pairs the runs of two pipelines
  std::string pipeline;
  std::string alignment;  ///< "SE(3)", "Sim(3)"
  bool failed = false, has_poses = true;
  std::size_t frames = 0, tracked_frames = 0;
  double first_s = NAN, last_s = NAN;  ///< stamps of the frames
  double ate_rmse_m = NAN, rpe_trans_rmse_m = NAN, recall = NAN, static_kept = NAN;
  double total_ms = NAN, filters_ms = NAN, cpu_ms = NAN;
};

/// All runs of one pipeline on one scene. Medians are of the runs that have the figure.
struct ComparedRow {
  std::string scene, place, pipeline, alignment;
  std::vector<std::string> sequences;  ///< of the runs, each once
  std::size_t runs = 0, runs_with_ate = 0, failed_runs = 0, frames = 0, tracked_frames = 0;
  std::size_t longest_run = 0;  ///< frames
  bool has_poses = false;
  double first_s = NAN, last_s = NAN;
  double ate_median_m = NAN, ate_worst_m = NAN, ate_mean_m = NAN;
  double ate_std_m = NAN;    ///< of a sample (n - 1); NaN for fewer than two runs
  double over_oracle = NAN;  ///< median ATE over that of the pipeline `oracle`, if it is included
  double rpe_median_m = NAN, recall = NAN, static_kept = NAN;
  double total_ms = NAN, filters_ms = NAN, cpu_ms = NAN;
  SignedRank against_reference;  ///< of the ATE; no pairs for the reference itself

  double tracked_percent() const {
    return 100 * static_cast<double>(tracked_frames) / static_cast<double>(frames);
  }
};

struct Comparison {
  std::vector<ComparedRow> rows;      ///< scenes and pipelines in the order of the runs
  std::vector<std::string> variants;  ///< of all runs, each once; empty: they have none
  std::string reference;              ///< what the test compares with; "": a single pipeline
};

/// `reference`: a pipeline; "": `none` if it takes part, else the first one.
/// Different scenes are never pooled, because their errors differ in scale.
/// Throws Error if no run is of the reference.
Comparison compare_runs(const std::vector<ComparedRun>& runs, const std::string& reference = "");

}  // namespace dynfilter::eval
