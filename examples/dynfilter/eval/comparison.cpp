// SPDX-License-Identifier: MIT
#include "eval/comparison.hpp"

#include <algorithm>
#include <dynfilter/core/error.hpp>

#include "eval/statistics.hpp"

namespace dynfilter::eval {
namespace {

using Runs = std::vector<const ComparedRun*>;

/// In the order in which scenes and pipelines first appear.
std::vector<Runs> grouped(const std::vector<ComparedRun>& runs) {
  std::vector<Runs> groups;
  for (const ComparedRun& run : runs) {
    const auto same = [&run](const Runs& group) {
      return group[0]->scene == run.scene && group[0]->pipeline == run.pipeline;
    };
    auto group = std::find_if(groups.begin(), groups.end(), same);
    if (group == groups.end()) group = groups.insert(groups.end(), Runs());
    group->push_back(&run);
  }
  return groups;
}

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

std::vector<double> known(const Runs& runs, double ComparedRun::*figure) {
  std::vector<double> values;
  for (const ComparedRun* run : runs)
    if (std::isfinite(run->*figure)) values.push_back(run->*figure);
  return values;
}

void summarise_ate(const Runs& runs, ComparedRow& row) {
  const std::vector<double> errors_m = known(runs, &ComparedRun::ate_rmse_m);
  const ErrorStatistics all = statistics(errors_m);
  row.runs_with_ate = errors_m.size();
  row.ate_median_m = all.median, row.ate_worst_m = all.max, row.ate_mean_m = all.mean;
  const auto n = static_cast<double>(errors_m.size());
  if (errors_m.size() > 1) row.ate_std_m = all.std * std::sqrt(n / (n - 1));
}

ComparedRow row_of(const Runs& runs) {
  ComparedRow row;
  const ComparedRun& first = *runs[0];
  row.scene = first.scene, row.place = first.place, row.pipeline = first.pipeline;
  row.alignment = first.alignment;
  row.runs = runs.size();
  for (const ComparedRun* run : runs) {
    add_once(row.sequences, run->sequence);
    row.failed_runs += run->failed ? 1 : 0, row.has_poses = row.has_poses || run->has_poses;
    row.frames += run->frames, row.tracked_frames += run->tracked_frames;
    row.longest_run = std::max(row.longest_run, run->frames);
    row.first_s = std::fmin(row.first_s, std::fmin(run->first_s, run->last_s));
    row.last_s = std::fmax(row.last_s, std::fmax(run->first_s, run->last_s));
  }
  summarise_ate(runs, row);
  row.rpe_median_m = median(known(runs, &ComparedRun::rpe_trans_rmse_m));
  row.recall = median(known(runs, &ComparedRun::recall));
  row.static_kept = median(known(runs, &ComparedRun::static_kept));
  row.total_ms = median(known(runs, &ComparedRun::total_ms));
  row.filters_ms = median(known(runs, &ComparedRun::filters_ms));
  row.cpu_ms = median(known(runs, &ComparedRun::cpu_ms));
  return row;
}

/// Of runs of the same sequence and variant. NaN where one has no ATE.
std::vector<double> differences_m(const Runs& runs, const Runs& reference) {
  std::vector<double> all;
  for (const ComparedRun* run : runs)
    for (const ComparedRun* other : reference)
      if (run->sequence == other->sequence && run->variant == other->variant)
        all.push_back(run->ate_rmse_m - other->ate_rmse_m);
  return all;
}

std::string chosen_reference(const std::vector<ComparedRun>& runs, const std::string& wanted) {
  const auto takes_part = [&runs](const std::string& name) {
    return std::any_of(runs.begin(), runs.end(),
                       [&](const ComparedRun& run) { return run.pipeline == name; });
  };
  if (!wanted.empty() && !takes_part(wanted))
    throw Error("the reference `" + wanted + "` is none of the pipelines that are compared");
  if (runs.empty()) return "";
  const std::string reference = !wanted.empty() ? wanted : takes_part("none") ? "none" : runs[0].pipeline;
  const bool alone = std::all_of(runs.begin(), runs.end(),
                                 [&](const ComparedRun& run) { return run.pipeline == reference; });
  return alone ? "" : reference;
}

}  // namespace

Comparison compare_runs(const std::vector<ComparedRun>& runs, const std::string& reference) {
  Comparison comparison;
  comparison.reference = chosen_reference(runs, reference);
  const std::vector<Runs> groups = grouped(runs);
  for (const ComparedRun& run : runs)
    if (!run.variant.empty()) add_once(comparison.variants, run.variant);
  for (const Runs& group : groups) comparison.rows.push_back(row_of(group));
  for (std::size_t i = 0; i < groups.size(); ++i) {
    ComparedRow& row = comparison.rows[i];
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const ComparedRow& other = comparison.rows[k];
      if (other.scene != row.scene) continue;
      if (other.pipeline == "oracle") row.over_oracle = row.ate_median_m / other.ate_median_m;
      if (other.pipeline == comparison.reference && k != i)
        row.against_reference = signed_rank_test(differences_m(groups[i], groups[k]));
    }
  }
  return comparison;
}

}  // namespace dynfilter::eval
