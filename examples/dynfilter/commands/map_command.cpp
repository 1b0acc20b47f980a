// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "command.hpp"
#include "map/map_text.hpp"
#include "run_and_print.hpp"

namespace dynfilter::command {
namespace {

void print_map_text(const Summary& s) {
  fmt::print("{} on {}\n", s.pipeline, s.sequence);
  fmt::print(
      "  frames        {} with a pose and a depth image\n"
      "  features      {:.0f} a frame, {:.0f} of them rejected\n",
      s.map->frames_offered, s.features_mean, s.rejected_mean);
  fmt::print("{}", map_text(*s.map));
  print_notes(s.notes);
  print_notes(s.stage_notes);
}

int run_map(const RunOptions& options, bool json) {
  const Summary summary = run_and_print(options, json, print_map_text);
  if (!summary.failure.empty()) return print_failures({summary});
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
  CLI::App* command = app.add_subcommand(
      "map",
      "Builds the dense map of the static part of a sequence. The camera's poses are read from a "
      "file that any SLAM wrote, or from the folder's own groundtruth.txt. What the pipeline rejects "
      "is left out.");
  command->add_option("SEQUENCE", options->sequence, "a folder with depth images, as `run` takes it")
      ->required()
      ->type_name("FOLDER");
  command->add_option("TRAJECTORY", options->trajectory, "poses in TUM's format")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--pipeline", options->pipeline,
                   "a preset's name (dynfilter, none, oracle, ...: `dynfilter presets`) or a YAML file")
      ->capture_default_str()
      ->type_name("PIPELINE");
  command->add_option("--map", options->map, "the PLY file to write, with a picture of the map beside it")
      ->type_name("FILE")
      ->capture_default_str();
  add_map_options(*command, *options);
  add_full_map_option(*command, *options);
  command
      ->add_option("--max-gap-s", options->max_gap_s,
                   "poses are not interpolated across gaps longer than this")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  add_play_options(*command, *options);
  command->add_flag("--json", *json, "print JSON");
  command->callback(
      [options, json, &action] { action = [options, json] { return run_map(*options, *json); }; });
}

}  // namespace dynfilter::command
