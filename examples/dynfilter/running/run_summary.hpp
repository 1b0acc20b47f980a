// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/ate.hpp"
#include "eval/classification.hpp"
#include "eval/rpe.hpp"
#include "eval/statistics.hpp"
#include "frame_costs.hpp"
#include "io/trajectory.hpp"
#include "map/map_summary.hpp"
#include "stage_totals.hpp"
#include "text/json.hpp"

namespace dynfilter::command {

/// One line of frames.csv.
struct FrameRow {
  std::size_t index = 0;  ///< in the sequence
  double timestamp_s = 0;
  std::string state;
  bool keyframe = false, relocalised = false;
  std::size_t features = 0, of_static = 0, dynamic = 0, unknown = 0, restored = 0, tracked_points = 0;
  double weight_mean = 1;  ///< of the kept features, for an optimiser
  eval::Classification truth;
  double extraction_ms = 0, correspondence_ms = 0, filters_ms = 0, tracking_ms = 0;
  double cpu_ms = 0, cpu_judge_ms = 0;  ///< of all threads; of correspondence and filters
  std::string note;

  double total_ms() const { return extraction_ms + correspondence_ms + filters_ms + tracking_ms; }
};

/// Counters of boxes and masks.
struct DetectorSummary {
  std::string mode;
  std::int64_t looked_at = 0, skipped = 0, results = 0, silent = 0, failed = 0;
  bool abandoned = false;
  std::string last_error;
  std::size_t frames_with_result = 0;
  double age_median_frames = NAN, age_max_frames = NAN;
};

/// Content of summary.json. NaN is written as null.
struct Summary {
  std::string sequence, pipeline, sensor;
  /// What produced the figures: canonical paths, and a digest of the pipeline's text.
  std::string folder, pipeline_file, pipeline_digest;
  /// Scene of a rendered sequence, else the sequence's name. Runs of one scene can be pooled.
  std::string scene;
  std::size_t frames = 0, tracked_frames = 0;
  /// There are no poses, because the camera is not known or did not move enough. That is no failure.
  bool verdicts_only = false;
  std::optional<FrameCosts> costs;     ///< of a video
  double first_s = NAN, last_s = NAN;  ///< stamps of the first and the last frame played
  double ate_rmse_m = NAN, rpe_trans_rmse_m = NAN, rpe_rot_rmse_deg = NAN;
  double precision = NAN, recall = NAN, static_kept = NAN;
  double features_mean = 0, rejected_mean = 0;
  double total_ms = 0, extraction_ms = 0, correspondence_ms = 0, filters_ms = 0, tracking_ms = 0;
  double cpu_ms = 0, cpu_judge_ms = 0;
  /// Why the run is not one of this pipeline: its detector or a stage failed in every frame. "": it is.
  std::string failure;
  std::optional<DetectorSummary> detector;
  std::optional<MapSummary> map;
  StageTotals stages;
  std::vector<std::string> notes, stage_notes;  ///< of the run; of skipped or failed stages

  /// A failed run has no figures that a table could show under the pipeline's name.
  void fail(const std::string& why) {
    failure = why;
    ate_rmse_m = rpe_trans_rmse_m = rpe_rot_rmse_deg = precision = recall = static_kept = NAN;
  }
};

inline Json to_json(const DetectorSummary& d) {
  return {{"mode", d.mode},
          {"looked_at", d.looked_at},
          {"skipped", d.skipped},
          {"results", d.results},
          {"silent", d.silent},
          {"failed", d.failed},
          {"abandoned", d.abandoned},
          {"last_error", d.last_error},
          {"frames_with_result", d.frames_with_result},
          {"age_median_frames", number_or_null(d.age_median_frames)},
          {"age_max_frames", number_or_null(d.age_max_frames)}};
}

inline Json to_json(const Summary& s) {
  Json json{{"frames", s.frames},
            {"tracked_frames", s.tracked_frames},
            {"verdicts_only", s.verdicts_only},
            {"first_s", number_or_null(s.first_s)},
            {"last_s", number_or_null(s.last_s)}};
  const std::pair<const char*, double> figures[] = {{"ate_rmse_m", s.ate_rmse_m},
                                                    {"rpe_trans_rmse_m", s.rpe_trans_rmse_m},
                                                    {"rpe_rot_rmse_deg", s.rpe_rot_rmse_deg},
                                                    {"precision", s.precision},
                                                    {"recall", s.recall},
                                                    {"static_kept", s.static_kept},
                                                    {"features_mean", s.features_mean},
                                                    {"rejected_mean", s.rejected_mean}};
  for (const auto& [key, value] : figures) json[key] = number_or_null(value);
  json["ms"] = {{"total", s.total_ms},
                {"extraction", s.extraction_ms},
                {"correspondence", s.correspondence_ms},
                {"filters", s.filters_ms},
                {"tracking", s.tracking_ms}};
  json["cpu_ms"] = {{"total", s.cpu_ms}, {"judge", s.cpu_judge_ms}};
  json["failure"] = s.failure.empty() ? Json() : Json(s.failure);
  json["detector"] = s.detector ? to_json(*s.detector) : Json();
  if (s.map) json["map"] = to_json(*s.map);
  if (s.costs) json["costs"] = to_json(*s.costs);
  json["stages"] = to_json(s.stages);
  json["notes"] = s.notes;
  for (const std::string& note : s.stage_notes) json["notes"].push_back(note);
  return json;
}

/// Puts `sequence` and `pipeline` first.
inline Json named_json(const Summary& s) {
  Json json{{"sequence", s.sequence},
            {"scene", s.scene},
            {"pipeline", s.pipeline},
            {"sensor", s.sensor},
            {"folder", s.folder},
            {"pipeline_file", s.pipeline_file},
            {"pipeline_digest", s.pipeline_digest}};
  json.update(to_json(s));
  return json;
}

/// What a summary says of all frames. Keeps 28 bytes a frame, for the medians of the times.
class FrameStatistics {
 public:
  void add(const FrameRow& row) {
    if (frames_ == 0) first_s_ = row.timestamp_s;
    last_s_ = row.timestamp_s;
    tracked_ += row.state == "tracked" ? 1 : 0;
    features_ += static_cast<double>(row.features);
    rejected_ += static_cast<double>(row.dynamic);
    any_judged_ = any_judged_ || row.of_static + row.dynamic + row.restored > 0;
    if (frames_ >= eval::Classification::kFirstFrame) pooled_.add(row.truth);
    const double times_ms[] = {row.total_ms(),  row.extraction_ms, row.correspondence_ms, row.filters_ms,
                               row.tracking_ms, row.cpu_ms,        row.cpu_judge_ms};
    for (std::size_t k = 0; k < std::size(times_ms); ++k)
      times_ms_[k].push_back(static_cast<float>(times_ms[k]));
    ++frames_;
  }

  std::size_t frames() const { return frames_; }
  /// A stage voted on a feature of some frame.
  bool any_judged() const { return any_judged_; }

  void summarise(Summary& s) const {
    const auto n = static_cast<double>(frames_);
    s.frames = frames_;
    s.tracked_frames = tracked_;
    s.first_s = first_s_, s.last_s = last_s_;
    s.features_mean = features_ / n;
    s.rejected_mean = rejected_ / n;
    s.precision = pooled_.precision();
    s.recall = pooled_.recall();
    s.static_kept = pooled_.static_kept();
    double* medians_ms[] = {&s.total_ms,    &s.extraction_ms, &s.correspondence_ms, &s.filters_ms,
                            &s.tracking_ms, &s.cpu_ms,        &s.cpu_judge_ms};
    for (std::size_t k = 0; k < std::size(medians_ms); ++k)
      *medians_ms[k] = eval::median({times_ms_[k].begin(), times_ms_[k].end()});
  }

 private:
  std::size_t frames_ = 0, tracked_ = 0;
  double first_s_ = NAN, last_s_ = NAN, features_ = 0, rejected_ = 0;
  bool any_judged_ = false;
  eval::Classification pooled_;
  std::array<std::vector<float>, 7> times_ms_;
};

/// How many frames had a note. Notes beyond a number of different ones are counted together.
class NoteCounts {
 public:
  void add(const std::string& note) {
    const auto known = counts_.find(note);
    if (known != counts_.end())
      ++known->second;
    else
      ++counts_[counts_.size() < kMostNotes ? note : "other notes"];
  }
  const std::map<std::string, std::size_t>& counts() const { return counts_; }

 private:
  static constexpr std::size_t kMostNotes = 1000;
  std::map<std::string, std::size_t> counts_;
};

inline void summarise_trajectory(const std::optional<io::Trajectory>& truth, const io::Trajectory& estimate,
                                 Summary& s) {
  if (!truth) {
    if (!s.verdicts_only) s.notes.emplace_back("no ground truth: no trajectory error");
    return;
  }
  try {
    s.ate_rmse_m = eval::absolute_trajectory_error(*truth, estimate).error_m.rmse;
  } catch (const Error& error) {
    s.notes.emplace_back(std::string("no trajectory error: ") + error.what());
    return;
  }
  try {
    const eval::RpeResult rpe = eval::relative_pose_error(*truth, estimate);
    s.rpe_trans_rmse_m = rpe.translation_m.rmse;
    s.rpe_rot_rmse_deg = rpe.rotation_deg.rmse;
  } catch (const Error&) {
    s.notes.emplace_back("no relative error: fewer than two pairs of poses one second apart");
  }
}

}  // namespace dynfilter::command
