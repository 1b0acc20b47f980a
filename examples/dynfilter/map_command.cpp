// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "command.hpp"
#include "map_text.hpp"
#include "run_and_print.hpp"

namespace dynfilter::command {
namespace {

void print_map_text(const Summary& s) {
  fmt::print("{} on {}\n", s.pipeline, s.sequence);
  fmt::print("  frames        {} with a pose and a depth image, {:.0f} features, {:.0f} of them rejected\n",
             s.map->frames_offered, s.features_mean, s.rejected_mean);
  fmt::print("{}", map_text(*s.map));
  for (const std::string& note : s.notes) fmt::print("  note: {}\n", note);
}

int run_map(const RunOptions& options, bool json) {
  const Summary summary = run_and_print(options, json, print_map_text);
  if (summary.map->points > 0) return kDone;
  fmt::print(stderr, "dynfilter: the map is empty\n");
  return kFailed;
}

}  // namespace

void add_map(CLI::App& app, Action& action) {
  auto options = std::make_shared<RunOptions>();
  auto json = std::make_shared<bool>(false);
  options->map = "map.ply";
  options->keyframes = "pose_change";
  CLI::App* command =
      app.add_subcommand("map",
                         "The dense map of what stands still in a TUM RGB-D or Bonn folder, from the "
                         "camera's poses as any SLAM\n"
                         "wrote them, or the folder's own groundtruth.txt. The pipeline says what moves.");
  command->add_option("SEQUENCE", options->sequence, "folder")->required();
  command->add_option("TRAJECTORY", options->trajectory, "poses in TUM format")->required();
  command
      ->add_option("--pipeline", options->pipeline,
                   "a preset's name (none, oracle, rts_slam, ...) or a YAML file")
      ->required();
  command->add_option("--map", options->map, "the PLY file to write; a picture of the map comes beside it")
      ->capture_default_str();
  add_map_options(*command, *options);
  command
      ->add_option("--max-gap-s", options->max_gap_s,
                   "between poses that are further apart than this there is none")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  add_play_options(*command, *options);
  command->add_flag("--json", *json, "print JSON");
  command->callback(
      [options, json, &action] { action = [options, json] { return run_map(*options, *json); }; });
}

}  // namespace dynfilter::command
