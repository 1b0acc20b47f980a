// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/pipeline.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "eval/classification.hpp"
#include "eval/statistics.hpp"
#include "io/point_tracks.hpp"
#include "running/command_registry.hpp"
#include "running/stage_totals.hpp"
#include "text/json.hpp"
#include "text/progress.hpp"
#include "text/table.hpp"

namespace dynfilter::command {
namespace {

namespace fs = std::filesystem;

enum class Positive { Auto, Movers, Mismatches, Others };

struct MotionOptions {
  std::vector<std::string> tracks, plugins;
  std::string pipeline = "dynfilter", positive = "auto";
  double focal_px = 0, rate_hz = 0;
  bool json = false, wide = false;
};

/// The labels to detect.
struct Task {
  Positive positive = Positive::Movers;
  int background = 1;

  bool is_positive(int label) const {
    return positive == Positive::Movers       ? label > 1
           : positive == Positive::Mismatches ? label == 0
                                              : label != background;
  }
  std::string text() const {
    return positive == Positive::Movers       ? "label > 1"
           : positive == Positive::Mismatches ? "label 0"
                                              : fmt::format("not label {} (the widest)", background);
  }
};

struct Clip {
  std::string name, task;
  std::size_t points = 0, positives = 0;
  double precision = NAN;  ///< NaN if nothing is rejected
  double recall = NAN;     ///< NaN if nothing is to be found
  double f1 = NAN, ms_per_frame = 0;
  std::size_t judged = 0;  ///< verdicts that are not unknown, in all frames
  StageTotals stages;
};

/// F1 of precision and recall: 1 if nothing is to be found and nothing is rejected.
/// 0 if only one of the two holds.
double f1_of(const eval::Classification& counts) {
  const double found = 2 * static_cast<double>(counts.dynamic_rejected);
  const double all = found + static_cast<double>(counts.dynamic_kept + counts.static_rejected);
  return all > 0 ? found / all : 1;
}

std::vector<fs::path> files_of(const std::vector<std::string>& arguments) {
  std::vector<fs::path> files;
  for (const std::string& argument : arguments) {
    std::error_code error;
    if (!fs::is_directory(argument, error)) {
      files.emplace_back(argument);
      continue;
    }
    std::vector<fs::path> inside;
    for (const auto& entry : fs::directory_iterator(argument, error))
      if (entry.path().extension() == ".txt") inside.push_back(entry.path());
    if (inside.empty()) throw IoError(argument + ": holds no track files (*.txt)");
    std::sort(inside.begin(), inside.end());
    files.insert(files.end(), inside.begin(), inside.end());
  }
  return files;
}

Positive positive_of(const std::string& word, const io::PointTracks& tracks) {
  if (word == "movers") return Positive::Movers;
  if (word == "mismatches") return Positive::Mismatches;
  if (word == "others") return Positive::Others;
  if (tracks.title == "AdelaideRMF") return Positive::Mismatches;
  if (tracks.title == "Hopkins155") return Positive::Others;
  return Positive::Movers;
}

/// KITTI has 10 Hz; the clips of Hopkins155 have 15 to 30 Hz.
double rate_of(double given_hz, const io::PointTracks& tracks) {
  return given_hz > 0 ? given_hz : tracks.title == "Hopkins155" ? 20.0 : 10.0;
}

/// The visible points of a frame, in the form that a host provides.
struct TrackFrame {
  std::vector<int> points;  ///< point in the file, per feature
  std::vector<cv::KeyPoint> keypoints;
  std::vector<std::int32_t> reference;

  /// `feature_of`: feature of each point in the last frame, -1: none. Updated for this frame.
  void fill(const io::PointTracks& tracks, int frame, std::vector<std::int32_t>& feature_of) {
    points.clear(), keypoints.clear(), reference.clear();
    std::vector<std::int32_t> now(feature_of.size(), -1);
    for (int p = 0; p < tracks.points; ++p) {
      if (!tracks.visible(p, frame)) continue;
      const auto at = static_cast<std::size_t>(p);
      now[at] = static_cast<std::int32_t>(points.size());
      points.push_back(p);
      keypoints.emplace_back(tracks.at(p, frame), 7.0F);
      reference.push_back(feature_of[at]);
    }
    feature_of = std::move(now);
  }
};

Camera camera_of(const io::PointTracks& tracks, double focal_px) {
  Camera camera;
  camera.width_px = tracks.width_px;
  camera.height_px = tracks.height_px;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * tracks.width_px;
  camera.cy_px = 0.5 * tracks.height_px;
  return camera;
}

/// For each point: true if it is dynamic in the last frame that shows it.
std::vector<bool> judge_tracks(Pipeline& pipeline, const io::PointTracks& tracks,
                               const MotionOptions& options, Clip& clip) {
  const double rate_hz = rate_of(options.rate_hz, tracks);
  std::vector<bool> dynamic(static_cast<std::size_t>(tracks.points), false);
  std::vector<std::int32_t> feature_of(dynamic.size(), -1);
  TrackFrame now;
  for (int f = 0; f < tracks.frames; ++f) {
    now.fill(tracks, f, feature_of);
    FrameView view;
    view.id = f;
    view.timestamp_s = f / rate_hz;
    view.keypoints = now.keypoints;
    view.camera = camera_of(tracks, options.focal_px);
    view.matches = HostMatches{f - 1, now.reference};
    const Verdict& verdict = pipeline.before_pose(view);
    clip.stages.add(verdict.report);
    clip.judged += static_cast<std::size_t>(std::count_if(verdict.decision.begin(), verdict.decision.end(),
                                                          [](Vote vote) { return vote != Vote::Unknown; }));
    for (std::size_t i = 0; i < now.points.size(); ++i)
      dynamic[static_cast<std::size_t>(now.points[i])] = !verdict.keep(i);
  }
  return dynamic;
}

Clip judge_file(const fs::path& file, const MotionOptions& options, const Registry& registry) {
  const io::PointTracks tracks = io::read_point_tracks(file);
  Pipeline pipeline(named_pipeline(options.pipeline, registry));
  require_labels(pipeline, false, file.string());
  Task task{positive_of(options.positive, tracks), 1};
  if (task.positive == Positive::Others) task.background = io::widest_label(tracks);
  Clip clip;
  clip.name = file.stem().string(), clip.task = task.text();
  clip.stages = StageTotals(pipeline);
  const auto start = std::chrono::steady_clock::now();
  const std::vector<bool> dynamic = judge_tracks(pipeline, tracks, options, clip);
  const double ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  eval::Classification counts;
  for (std::size_t p = 0; p < dynamic.size(); ++p)
    counts.add(task.is_positive(tracks.label[p]) ? eval::TruthPixel::Dynamic : eval::TruthPixel::Static,
               dynamic[p]);
  clip.points = dynamic.size();
  clip.positives = counts.dynamic_rejected + counts.dynamic_kept;
  clip.precision = counts.precision();
  clip.recall = counts.recall();
  clip.f1 = f1_of(counts);
  clip.ms_per_frame = ms / tracks.frames;
  return clip;
}

/// Over the files in which the figure is defined.
struct Totals {
  double mean = NAN, median = NAN, min = NAN;
  std::size_t files = 0;
};

Totals totals_of(const std::vector<Clip>& clips, double Clip::*member) {
  std::vector<double> known;
  for (const Clip& clip : clips)
    if (std::isfinite(clip.*member)) known.push_back(clip.*member);
  const eval::ErrorStatistics s = eval::statistics(known);
  return {s.mean, s.median, s.min, known.size()};
}

Json totals_json(const Totals& t) {
  return {{"mean", number_or_null(t.mean)},
          {"median", number_or_null(t.median)},
          {"min", number_or_null(t.min)},
          {"files", t.files}};
}

StageTotals stages_of(const std::vector<Clip>& clips) {
  StageTotals all;
  for (const Clip& clip : clips) all.add(clip.stages);
  return all;
}

void print_json(const std::vector<Clip>& clips, const std::string& pipeline) {
  Json files = Json::array();
  for (const Clip& c : clips)
    files.push_back({{"name", c.name},
                     {"positive", c.task},
                     {"points", c.points},
                     {"positives", c.positives},
                     {"precision", number_or_null(c.precision)},
                     {"recall", number_or_null(c.recall)},
                     {"f1", c.f1},
                     {"ms_per_frame", c.ms_per_frame}});
  const Json json{{"pipeline", pipeline},
                  {"files", files},
                  {"precision", totals_json(totals_of(clips, &Clip::precision))},
                  {"recall", totals_json(totals_of(clips, &Clip::recall))},
                  {"f1", totals_json(totals_of(clips, &Clip::f1))},
                  {"stages", to_json(stages_of(clips))}};
  fmt::print("{}", json_text(json));
}

// The totals' rows give their number of files if it is not all.
std::string total_cell(double value, const Totals& totals, std::size_t files) {
  return cell(value, 3) + (totals.files < files && totals.files > 0 ? "*" : "");
}

void print_text(const std::vector<Clip>& clips, bool wide) {
  Table table({{"tracks", true},
               {"points", false, 2},
               {"positives", false, 1},
               {"precision"},
               {"recall"},
               {"F1"},
               {"ms/frame", false, 3},
               {"positive", true, 4}});
  for (const Clip& c : clips)
    table.add({c.name, std::to_string(c.points), std::to_string(c.positives), cell(c.precision, 3),
               cell(c.recall, 3), cell(c.f1, 3), cell(c.ms_per_frame, 2), c.task});
  const Totals precision = totals_of(clips, &Clip::precision), recall = totals_of(clips, &Clip::recall),
               f1 = totals_of(clips, &Clip::f1);
  const auto row = [&](const char* name, double Totals::*member) {
    table.add({name, "", "", total_cell(precision.*member, precision, clips.size()),
               total_cell(recall.*member, recall, clips.size()), cell(f1.*member, 3), "", ""});
  };
  row("mean", &Totals::mean);
  row("median", &Totals::median);
  print_table(table, wide);
  const auto explain = [&](const char* name, const Totals& totals, const char* why, const char* never) {
    if (totals.files == clips.size()) return;
    if (totals.files == 0) return fmt::print("{} is not defined: {}\n", name, never);
    fmt::print("{}", wrapped(fmt::format("{}{} over {} of {} files: {}", totals.files > 0 ? "* " : "", name,
                                         totals.files, clips.size(), why),
                             text_columns()));
  };
  explain("precision", precision, "in the others nothing is rejected", "nothing is rejected in any file");
  explain("recall", recall, "in the others nothing is to be found", "nothing is to be found in any file");
}

// The figures of a pipeline whose stages were all skipped mean nothing.
int print_if_idle(const std::vector<Clip>& clips, const std::string& pipeline) {
  const StageTotals stages = stages_of(clips);
  const std::vector<std::string> reasons = stages.reasons();
  const bool lacks_camera = std::any_of(reasons.begin(), reasons.end(), [](const std::string& reason) {
    return reason.find("camera") != std::string::npos;
  });
  if (stages.all_skipped()) {
    fmt::print(
        stderr, "dynfilter: {}: all stages were skipped in all frames, so nothing was judged ({}){}\n",
        pipeline, fmt::join(reasons, "; "),
        lacks_camera ? "; --focal-px gives the camera" : "; tracks have neither images, depth nor boxes");
    return kFailed;
  }
  if (!stages.empty() && !stages.any_reached()) {
    fmt::print(stderr,
               "dynfilter: {}: no stage at before_pose, and this command has no other call point: nothing "
               "was judged\n",
               pipeline);
    return kFailed;
  }
  const bool judged =
      std::any_of(clips.begin(), clips.end(), [](const Clip& clip) { return clip.judged > 0; });
  if (!stages.empty() && !judged)
    fmt::print(stderr, "dynfilter: note: {}: every point of every frame is unknown\n", pipeline);
  return kDone;
}

int run_motion(const MotionOptions& options) {
  const Registry registry = command_registry(options.plugins);
  const std::vector<fs::path> files = files_of(options.tracks);
  std::vector<Clip> clips;
  {
    Progress bar(options.pipeline);
    for (const fs::path& file : files) {
      clips.push_back(judge_file(file, options, registry));
      bar.at(clips.size(), files.size());
    }
  }
  options.json ? print_json(clips, options.pipeline) : print_text(clips, options.wide);
  return print_if_idle(clips, options.pipeline);
}

}  // namespace

void add_motion(CLI::App& app, Action& action) {
  auto options = std::make_shared<MotionOptions>();
  CLI::App* command = app.add_subcommand(
      "motion",
      "Prints precision and recall of a mono pipeline on labelled point tracks. Frames are judged in order. "
      "A track is a match from frame to frame. The verdict of a point is that of its last visible frame. "
      "Unknown counts as kept.\n\n"
      "Precision is not defined if nothing is rejected, and recall not if nothing is to be found. They are "
      "then printed as - and left out of the mean, and a line gives the number of files in the mean. F1 is "
      "1 if nothing is to be found and nothing is rejected, and 0 if only one of the two holds.");
  command->add_option("TRACKS", options->tracks, "track files, or folders of them (*.txt)")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--pipeline,-p", options->pipeline,
                   "a preset's name (`dynfilter presets`), or a YAML file")
      ->capture_default_str()
      ->type_name("PIPELINE");
  command
      ->add_option(
          "--positive", options->positive,
          "which points are to be found. movers: label > 1. mismatches: label 0. others: every label but the "
          "one that spreads most over the image. auto: by the data set that the file names")
      ->check(CLI::IsMember({"auto", "movers", "mismatches", "others"}))
      ->type_name("WHAT");
  command->add_option("--focal-px", options->focal_px, "the camera's focal length, if it is known")
      ->type_name("PX")
      ->check(CLI::Range(1.0, 1e6));
  command
      ->add_option("--rate-hz", options->rate_hz,
                   "frames per second; without it 20 for Hopkins155 and 10 for other data sets")
      ->type_name("HZ")
      ->check(CLI::Range(0.01, 1e4));
  command
      ->add_option("--plugin", options->plugins,
                   "a module with more filters (runs its code); may be repeated")
      ->type_name("FILE");
  command->add_flag("--json", options->json, "print JSON");
  command->add_flag("--wide", options->wide, "the table with all columns, whatever the terminal's width");
  command->callback([options, &action] { action = [options] { return run_motion(*options); }; });
}

}  // namespace dynfilter::command
