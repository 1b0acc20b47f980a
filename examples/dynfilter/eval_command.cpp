// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <dynfilter/eval/ate.hpp>
#include <dynfilter/eval/rpe.hpp>
#include <dynfilter/io/trajectory.hpp>
#include <memory>
#include <optional>
#include <string>

#include "command.hpp"
#include "json.hpp"

namespace dynfilter::command {
namespace {

struct EvalOptions {
  std::string truth, estimate;
  bool scale = false, json = false;
};

struct Evaluation {
  eval::AteResult ate;
  std::optional<eval::RpeResult> rpe;  // none: the trajectory is shorter than one second
};

// The TUM tools print the median of the rotation in radians under the name "deg".
// All other figures are in degrees.
constexpr double kRadPerDeg = 3.14159265358979323846 / 180;

Evaluation evaluate(const EvalOptions& options) {
  const io::Trajectory truth = io::read_tum_trajectory(options.truth);
  const io::Trajectory estimate = io::read_tum_trajectory(options.estimate);
  eval::AteOptions ate;
  ate.with_scale = options.scale;
  Evaluation result{eval::absolute_trajectory_error(truth, estimate, ate), std::nullopt};
  try {
    result.rpe = eval::relative_pose_error(truth, estimate);
  } catch (const Error&) {
  }
  return result;
}

Json statistics_json(const eval::ErrorStatistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
          {"std", s.std},   {"min", s.min},   {"max", s.max}};
}

void print_json(const Evaluation& e, bool scale) {
  Json json{{"pairs", e.ate.pairs}, {"ate", statistics_json(e.ate.error_m)}};
  if (scale) json["scale"] = e.ate.T_truth_estimate.scale;
  json["rpe_pairs"] = e.rpe ? e.rpe->pairs : 0;
  json["rpe_trans_m"] = e.rpe ? statistics_json(e.rpe->translation_m) : Json(nullptr);
  json["rpe_rot_deg"] = e.rpe ? statistics_json(e.rpe->rotation_deg) : Json(nullptr);
  if (e.rpe) {
    json["rpe_rot_deg"]["median"] = e.rpe->rotation_deg.median * kRadPerDeg;
    json["rpe_rot_deg"]["median_deg"] = e.rpe->rotation_deg.median;
  }
  fmt::print("{}", json_text(json));
}

void print_lines(const char* name, const char* unit, const eval::ErrorStatistics& s) {
  const std::pair<const char*, double> lines[] = {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
                                                  {"std", s.std},   {"min", s.min},   {"max", s.max}};
  for (const auto& [what, value] : lines) fmt::print("{}.{} {:.6f} {}\n", name, what, value, unit);
}

void print_text(const Evaluation& e, bool scale) {
  fmt::print("compared_pose_pairs {} pairs\n", e.ate.pairs);
  print_lines("absolute_translational_error", "m", e.ate.error_m);
  if (scale) fmt::print("scale {:.6f}\n", e.ate.T_truth_estimate.scale);
  if (!e.rpe) {
    fmt::print("# no relative error: fewer than two pairs of poses one second apart\n");
    return;
  }
  fmt::print("compared_pose_pairs {} pairs\n", e.rpe->pairs);
  print_lines("translational_error", "m", e.rpe->translation_m);
  eval::ErrorStatistics rotation = e.rpe->rotation_deg;
  rotation.median *= kRadPerDeg;
  print_lines("rotational_error", "deg", rotation);
  fmt::print("# rotational_error.median is in radians, as the TUM tools print it: {:.6f} deg\n",
             e.rpe->rotation_deg.median);
}

}  // namespace

void add_eval(CLI::App& app, Action& action) {
  auto options = std::make_shared<EvalOptions>();
  CLI::App* command = app.add_subcommand(
      "eval",
      "Absolute and relative trajectory error, line for line and digit for digit as the TUM RGB-D tools\n"
      "print them. Poses belong together within 0.02 s; relative errors are of pairs one second apart.\n"
      "As there, rotational_error.median is in radians; --json has median_deg beside it.");
  command->add_option("GROUNDTRUTH", options->truth, "trajectory in TUM format")->required();
  command->add_option("ESTIMATE", options->estimate, "trajectory in TUM format")->required();
  command->add_flag("--scale", options->scale, "align with Sim(3) instead of SE(3), for mono");
  command->add_flag("--json", options->json, "print JSON");
  command->callback([options, &action] {
    action = [options] {
      const Evaluation e = evaluate(*options);
      options->json ? print_json(e, options->scale) : print_text(e, options->scale);
      return static_cast<int>(kDone);
    };
  });
}

}  // namespace dynfilter::command
