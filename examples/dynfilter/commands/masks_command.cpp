// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <dynfilter/core/printable_text.hpp>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "masks/mask_form.hpp"
#include "run_and_print.hpp"
#include "run_options.hpp"
#include "running/mask_output.hpp"
#include "running/mask_run.hpp"
#include "text/json.hpp"
#include "text/progress.hpp"

namespace dynfilter::command {
namespace {

std::vector<std::string> tools() {
  std::vector<std::string> names;
  for (const masks::MaskForm& form : masks::mask_forms()) names.push_back(form.tool);
  return names;
}

/// What the tool is told.
std::string use_of(const MaskSummary& s) {
  const std::string masks = s.folder + "/masks";
  if (s.tool == "colmap")
    return "colmap feature_extractor --image_path " + s.images + " --ImageReader.mask_path " + masks;
  if (s.tool == "openmvg") return "copy " + masks + "/ into the folder of the images, " + s.images;
  if (s.tool == "nerfstudio") return "copy masks/ and transforms.json of " + s.folder + " to the data folder";
  if (s.tool == "droid") return "docs/how-to/masks.md has the lines for DROID-SLAM, which reads no masks";
  return masks + ": 255 on what moves";
}

void print_text(const MaskSummary& s) {
  fmt::print("masks of {} for {}, shape {}, pipeline {}\n", s.sequence, s.tool, s.shape, s.pipeline);
  fmt::print("  images        {}, {:.1f} % of the pixels masked\n", s.frames, 100 * s.masked_share);
  if (s.shape == "objects") fmt::print("  objects       {}, {} of them move\n", s.objects.size(), s.movers());
  if (s.truth)
    fmt::print("  truth         IoU {:.3f}, movers masked {:.3f}, static lost {:.4f}\n",
               s.truth->intersection_over_union(), s.truth->movers_masked(), s.truth->static_lost());
  print_notes(s.notes);
  fmt::print("  written to {}\n  {}\n", s.folder, use_of(s));
}

int run(const MaskOptions& options, bool json) {
  MaskSummary summary;
  {
    Progress bar("masks");
    summary = run_masks(options, [&](std::size_t done, std::size_t total) { bar.at(done, total); });
  }
  if (!summary.failure.empty()) {
    fmt::print(stderr, "dynfilter: masks of {}: {}\n", summary.sequence, without_controls(summary.failure));
    return kFailed;
  }
  if (json)
    fmt::print("{}", json_text(to_json(summary)));
  else
    print_text(summary);
  return kDone;
}

void add_mask_options(CLI::App& command, MaskOptions& options) {
  command.add_option("--for", options.tool, "the tool that reads the masks: file names and what black means")
      ->check(CLI::IsMember(tools()))
      ->capture_default_str()
      ->type_name("TOOL");
  command
      .add_option("--shape", options.shape,
                  "features: around rejected features and between them, without a detector; discs: around "
                  "them only; objects: the instances of a detector that move, through the whole clip")
      ->check(CLI::IsMember({"features", "discs", "objects"}))
      ->capture_default_str()
      ->type_name("SHAPE");
  command
      .add_option("--until-static", options.until_static_s,
                  "an object that has stood for this many seconds is not masked until it moves again")
      ->check(CLI::Range(0.0, 1e6))
      ->type_name("S");
  command.add_option("--grow", options.grow_px, "margin around objects, in pixels")
      ->check(CLI::Range(0, 100))
      ->capture_default_str()
      ->type_name("PX");
  command.add_flag("--truth", options.run.truth,
                   "a sequence that synth wrote: compare the masks with its labels");
}

}  // namespace

void add_masks(CLI::App& app, Action& action) {
  auto options = std::make_shared<MaskOptions>();
  auto json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand(
      "masks",
      "Writes a mask per image, so that a reconstruction leaves out what moves: for COLMAP, openMVG, "
      "nerfstudio, DROID-SLAM or plain.\n\n"
      "OUT gets masks/, overlay/ with pictures of them, and masks.json.");
  command->add_option("INPUT", options->run.sequence, "a sequence, as run takes it")
      ->required()
      ->type_name("INPUT");
  command->add_option("OUT", options->run.out, "folder for the masks; they appear when all is done")
      ->required()
      ->type_name("FOLDER");
  add_mask_options(*command, *options);
  command
      ->add_option("--pipeline", options->run.pipeline,
                   "what decides which features move: a preset's name or a YAML file")
      ->capture_default_str()
      ->type_name("PIPELINE");
  add_play_options(*command, options->run);
  command->add_flag("--force", options->run.force, "replace the masks in OUT");
  command->add_flag("--json", *json, "print JSON");
  command->callback([options, json, &action] { action = [options, json] { return run(*options, *json); }; });
}

}  // namespace dynfilter::command
