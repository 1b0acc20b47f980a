// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "command.hpp"
#include "map/map_text.hpp"
#include "run_and_print.hpp"

namespace dynfilter::command {
namespace {

std::string figure(double value, const char* unit) {
  return std::isfinite(value) ? fmt::format("{:.4f}{}", value, unit) : "-";
}

// Prints nothing if all results arrived on time without errors.
void print_detector(const DetectorSummary& d) {
  if (d.mode == "sync" && d.failed == 0) return;
  fmt::print("  detector      {}: {} results", d.mode, d.results);
  if (d.frames_with_result > 0)
    fmt::print(", on {} frames; median age {:.0f}, at most {:.0f} frames", d.frames_with_result,
               d.age_median_frames, d.age_max_frames);
  fmt::print("; {} images skipped, {} failed{}{}\n", d.skipped, d.failed, d.last_error.empty() ? "" : ": ",
             d.last_error);
}

void print_trajectory(const Summary& s) {
  fmt::print("  tracked       {} of {} frames\n", s.tracked_frames, s.frames);
  fmt::print("  ATE rmse      {}\n", figure(s.ate_rmse_m, " m"));
  fmt::print("  RPE rmse      {}, {}   (one second apart)\n", figure(s.rpe_trans_rmse_m, " m"),
             figure(s.rpe_rot_rmse_deg, " deg"));
}

/// What was written, or where it would be.
void print_files(const Summary& s, const RunOptions& options) {
  if (!options.out.empty()) fmt::print("  written to {}\n", options.out);
  if (!options.video.empty()) fmt::print("  written to {}\n", options.video);
  if (!s.costs || !options.out.empty() || !options.video.empty()) return;
  const std::string name = "dynfilter_" + std::filesystem::path(s.sequence).stem().string();
  fmt::print("  --out {0} writes {0}/report.html, --video {0}.mp4 the annotated video\n", name);
}

void print_text(const Summary& s, const RunOptions& options, bool wide) {
  fmt::print("{} on {}, {}\n", s.pipeline, s.sequence, s.sensor);
  if (s.verdicts_only)
    fmt::print("  judged        {} frames: verdicts only, no trajectory\n", s.frames);
  else
    print_trajectory(s);
  if (std::isfinite(s.static_kept) || std::isfinite(s.recall))  // there is a truth
    fmt::print("  precision     {}\n  recall        {}\n  static kept   {}\n", figure(s.precision, ""),
               figure(s.recall, ""), figure(s.static_kept, ""));
  fmt::print("  features      {:.0f} a frame, {:.0f} of them rejected\n", s.features_mean, s.rejected_mean);
  fmt::print(
      "  median time   {:.1f} ms a frame: extraction {:.1f}, correspondence {:.1f},\n"
      "                filters {:.2f}, tracking {:.1f}\n"
      "  median CPU    {:.1f} ms a frame in all threads, {:.2f} of it in the pipeline\n",
      s.total_ms, s.extraction_ms, s.correspondence_ms, s.filters_ms, s.tracking_ms, s.cpu_ms,
      s.cpu_judge_ms);
  if (s.costs) fmt::print("{}", costs_text(*s.costs));
  if (s.map) fmt::print("{}", map_text(*s.map));
  if (s.detector) print_detector(*s.detector);
  fmt::print("{}", stages_text(s.stages, wide));
  print_notes(s.notes, wide);
  print_files(s, options);
}

int run(const RunOptions& options, bool json, bool wide) {
  const Summary summary =
      run_and_print(options, json, [&](const Summary& s) { print_text(s, options, wide); });
  return print_failures({summary});
}

}  // namespace

void add_run(CLI::App& app, Action& action) {
  auto options = std::make_shared<RunOptions>();
  auto json = std::make_shared<bool>(false), wide = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand(
      "run",
      "Runs the reference odometry with a pipeline on a sequence. Prints the trajectory's error, what "
      "each stage of the pipeline did, and notes.\n\n"
      "A sequence is a video file, a camera (camera:0), images ('frames/*.png'), a TUM RGB-D, Bonn, KITTI "
      "odometry or EuRoC folder as downloaded, one that synth wrote, or a folder of images. Without a camera "
      "file, videos and images give verdicts and no trajectory. Frames of TUM come from "
      "associations.txt, association.txt, associated.txt or associate.txt, if the folder has one of them, "
      "else from rgb.txt and depth.txt.\n\n"
      "The folder of --out gets trajectory.txt, frames.csv, verdicts.csv, summary.json, overlay/ and "
      "report.html, a page with all of it.");
  command
      ->add_option("SEQUENCE", options->sequence,
                   "a folder, a video, camera:N, or images by a pattern in quotes")
      ->required()
      ->type_name("INPUT");
  command
      ->add_option("--pipeline", options->pipeline,
                   "a preset's name (dynfilter, none, oracle, ...: `dynfilter presets`) or a YAML file")
      ->capture_default_str()
      ->type_name("PIPELINE");
  add_run_options(*command, *options);
  command->add_option("--out", options->out, "folder for the results; they appear when all is done")
      ->type_name("FOLDER");
  command->add_flag("--force", options->force,
                    "replace the results of another run in --out, and the file of --video");
  command
      ->add_option("--video", options->video,
                   "write the frames with their verdicts to this video: .mp4, .mov, .mkv or .avi")
      ->type_name("FILE");
  command->add_flag("--live", options->live,
                    "show the frames with their verdicts in a window, at the pace of the recording; space "
                    "pauses, arrows step, q ends");
  command
      ->add_option("--overlay-every", options->overlay_every,
                   "a picture of every N-th frame; without it about 50 pictures")
      ->type_name("N");
  CLI::Option* map =
      command
          ->add_option("--map", options->map,
                       "write the dense map of what does not move to this PLY file, and a picture of it "
                       "beside it")
          ->type_name("FILE");
  for (CLI::Option* option : add_map_options(*command, *options)) option->needs(map);
  add_full_map_option(*command, *options)->needs(map);
  command->add_flag("--json", *json, "print JSON");
  command->add_flag("--wide", *wide, "tables with all columns, whatever the terminal's width");
  command->callback([options, json, wide, &action] {
    action = [options, json, wide] { return run(*options, *json, *wide); };
  });
}

}  // namespace dynfilter::command
