// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "command.hpp"
#include "run_and_print.hpp"
#include "running/replay_run.hpp"
#include "text/progress.hpp"

namespace dynfilter::command {
namespace {

std::string place(const DifferentCall& call) {
  return fmt::format("frame {} (id {}, {})", call.frame, call.id, call.point);
}

void print_comparison(const ReplaySummary& replay) {
  const ReplayComparison& c = replay.comparison;
  if (c.compared == 0) return fmt::print("  verdicts      none was recorded\n");
  if (c.differ == 0)
    return fmt::print("  verdicts      all {} {}\n", c.compared,
                      replay.recorded_pipeline ? "as recorded, bit for bit" : "decide as recorded");
  fmt::print("  verdicts      {} of {} differ from the recorded ones, in {} decisions\n", c.differ,
             c.compared, c.decisions);
  fmt::print("                first in {}\n                last in {}\n", place(*c.first), place(*c.last));
}

void print_cut(const ReplaySummary& replay, const ReplayOptions& options) {
  if (!replay.cut) return;
  fmt::print("  cut           frames {} to {}, with the verdicts of this replay: {}\n", replay.cut->first,
             replay.cut->second, options.cut_file);
  if (replay.cut->first > 0)
    fmt::print("                the history before them is lost, so its first frames are cold\n");
}

void print_text(const ReplaySummary& replay, const ReplayOptions& options, bool wide) {
  const Summary& s = replay.run;
  fmt::print("{} on {}, {}{}\n", s.pipeline, s.sequence, s.sensor,
             replay.recorded_pipeline ? ", the recorded pipeline" : "");
  fmt::print("  judged        {} frames, {} of them with a pose of the host\n", s.frames, s.tracked_frames);
  print_comparison(replay);
  fmt::print("  features      {:.0f} a frame, {:.0f} of them rejected\n", s.features_mean, s.rejected_mean);
  fmt::print("  median time   {:.1f} ms a frame in the pipeline\n", s.total_ms);
  fmt::print("{}", stages_text(s.stages, wide));
  print_notes(s.notes, wide);
  print_cut(replay, options);
  if (!options.out.empty()) fmt::print("  written to {}\n", options.out);
}

/// Another verdict of the recorded pipeline is a failure, unless it lacks images or a cut lost its history.
int run(const ReplayOptions& options, bool json, bool wide) {
  ReplaySummary replay;
  {
    Progress bar(options.recording);
    replay = replay_recording(options, [&](std::size_t done, std::size_t total) { bar.at(done, total); });
  }
  if (json)
    fmt::print("{}", json_text(to_json(replay)));
  else
    print_text(replay, options, wide);
  const int code = print_failures({replay.run});
  const bool whole = !replay.cut && replay.images_left_out == 0;
  const bool differs = replay.recorded_pipeline && whole && replay.comparison.differ > 0;
  return differs ? kFailed : code;
}

}  // namespace

void add_replay(CLI::App& app, Action& action) {
  auto options = std::make_shared<ReplayOptions>();
  auto json = std::make_shared<bool>(false), wide = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand(
      "replay",
      "Runs a pipeline on what a host handed to the library, from the file of a flight recorder "
      "(DynFilter.record). Compares the verdicts with the recorded ones and tells where they differ.\n\n"
      "The folder of --out gets what `run` writes, and differences.csv. --cut writes some of the frames to a "
      "file of their own, for a bug report or a test.\n\n"
      "Exit code 1: the recorded pipeline gives other verdicts than it did in the host.");
  command->add_option("RECORDING", options->recording, "the file of a flight recorder")
      ->required()
      ->type_name("FILE");
  CLI::Option* cut_file = command->add_option("CASE", options->cut_file, "the file that --cut writes");
  cut_file->type_name("FILE");
  command
      ->add_option("--pipeline", options->pipeline,
                   "a preset's name or a YAML file; without it the recorded pipeline")
      ->type_name("PIPELINE");
  CLI::Option* cut =
      command->add_option("--cut", options->cut,
                          "write frames A to B, as 40:60, counted from 0, to CASE; they are judged "
                          "without the history before A");
  cut->type_name("RANGE")->needs(cut_file);
  cut_file->needs(cut);
  command->add_option("--out", options->out, "folder for the results; they appear when all is done")
      ->type_name("FOLDER");
  command->add_flag("--force", options->force, "replace the results of another run in --out, and CASE");
  command
      ->add_option("--overlay-every", options->overlay_every,
                   "a picture of every N-th frame; without it about 50 pictures")
      ->type_name("N");
  command->add_option("--plugin", options->plugins, "load rejectors from this module as well (runs its code)")
      ->type_name("FILE");
  command->add_option("--threads", options->threads, "OpenCV's threads; verdicts do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_flag("--json", *json, "print JSON");
  command->add_flag("--wide", *wide, "tables with all columns, whatever the terminal's width");
  command->callback([options, json, wide, &action] {
    action = [options, json, wide] { return run(*options, *json, *wide); };
  });
}

}  // namespace dynfilter::command
