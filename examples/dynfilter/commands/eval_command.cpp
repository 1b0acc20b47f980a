// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <dynfilter/core/error.hpp>
#include <utility>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "eval/ate.hpp"
#include "eval/rpe.hpp"
#include "eval/statistics.hpp"
#include "io/trajectory.hpp"
#include "io/trajectory_formats.hpp"
#include "text/json.hpp"
#include "text/option_hint.hpp"

namespace dynfilter::command {
namespace {

struct EvalOptions {
  std::string truth, estimate, format = "auto", times;
  bool scale = false, json = false;
};

struct Evaluation {
  eval::AteResult ate;
  std::optional<eval::RpeResult> rpe;  // none: shorter than a second
  std::vector<std::string> notes;
};

// The TUM tools print the median of the rotation in radians under the name "deg".
// All other figures are in degrees.
constexpr double kRadPerDeg = 3.14159265358979323846 / 180;

std::optional<io::TrajectoryFormat> format_of(const std::string& word) {
  if (word == "tum") return io::TrajectoryFormat::Tum;
  if (word == "kitti") return io::TrajectoryFormat::Kitti;
  if (word == "euroc") return io::TrajectoryFormat::Euroc;
  return std::nullopt;
}

io::TrajectoryFile read(const std::string& path, const EvalOptions& options,
                        std::vector<std::string>& notes) {
  std::vector<double> times_s;
  if (!options.times.empty()) times_s = read_for("--times", [&] { return io::read_times_s(options.times); });
  io::TrajectoryFile file = io::read_trajectory(path, format_of(options.format), times_s);
  if (file.nanoseconds) notes.push_back(path + ": the stamps look like nanoseconds and are read as such");
  const bool said = std::any_of(notes.begin(), notes.end(), [&](const std::string& note) {
    return note.rfind(path + ": KITTI", 0) == 0;
  });
  if (file.format == io::TrajectoryFormat::Kitti && options.times.empty() && !said)
    notes.push_back(path + ": KITTI poses have no stamps: ten a second are assumed (--times gives them)");
  return file;
}

std::string span_of(const io::Trajectory& trajectory) {
  return fmt::format("{:.3f} to {:.3f} s", trajectory.front().timestamp_s, trajectory.back().timestamp_s);
}

eval::AteResult compare(const io::TrajectoryFile& truth, const io::TrajectoryFile& estimate,
                        const EvalOptions& options) {
  eval::AteOptions ate;
  ate.with_scale = options.scale;
  const bool without_stamps =
      options.times.empty() && truth.format != estimate.format &&
      (truth.format == io::TrajectoryFormat::Kitti || estimate.format == io::TrajectoryFormat::Kitti);
  try {
    return eval::absolute_trajectory_error(truth.trajectory, estimate.trajectory, ate);
  } catch (const Error& error) {
    throw Error(fmt::format("{} (stamps of the ground truth: {}; of the estimate: {}{})", error.what(),
                            span_of(truth.trajectory), span_of(estimate.trajectory),
                            without_stamps ? "; --times gives the stamps of KITTI's poses" : ""));
  }
}

Evaluation evaluate(const EvalOptions& options) {
  std::vector<std::string> notes;
  const io::TrajectoryFile truth_file = read(options.truth, options, notes),
                           estimate_file = read(options.estimate, options, notes);
  const io::Trajectory &truth = truth_file.trajectory, &estimate = estimate_file.trajectory;
  Evaluation result{compare(truth_file, estimate_file, options), std::nullopt, notes};
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
  if (!e.notes.empty()) json["notes"] = e.notes;
  fmt::print("{}", json_text(json));
}

void print_lines(const char* name, const char* unit, const eval::ErrorStatistics& s) {
  const std::pair<const char*, double> lines[] = {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
                                                  {"std", s.std},   {"min", s.min},   {"max", s.max}};
  for (const auto& [what, value] : lines) fmt::print("{}.{} {:.6f} {}\n", name, what, value, unit);
}

void print_text(const Evaluation& e, bool scale) {
  for (const std::string& note : e.notes) fmt::print("# {}\n", note);
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
      "Prints the absolute and the relative trajectory error, as the TUM RGB-D tools print them. Poses are "
      "paired if their stamps differ by less than 0.02 s. Relative errors are of poses one second apart. "
      "As in the TUM tools, rotational_error.median is in radians. --json adds median_deg.\n\n"
      "Files are in one of three formats. TUM: timestamp tx ty tz qx qy qz qw. KITTI: 12 numbers per line. "
      "EuRoC's ground truth: nanoseconds, commas, qw first. All errors are defined as in the TUM tools, "
      "not as in KITTI's.");
  command->add_option("GROUNDTRUTH", options->truth, "a trajectory")->required()->type_name("FILE");
  command->add_option("ESTIMATE", options->estimate, "a trajectory")->required()->type_name("FILE");
  command->add_option("--format", options->format, "format of both files; auto: chosen by the first line")
      ->check(CLI::IsMember({"auto", "tum", "kitti", "euroc"}))
      ->type_name("FORMAT")
      ->capture_default_str();
  command->add_option("--times", options->times, "stamps of KITTI's poses, one per line [s], like times.txt")
      ->type_name("FILE");
  command->add_flag("--scale", options->scale, "align with Sim(3) instead of SE(3), for monocular estimates");
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
