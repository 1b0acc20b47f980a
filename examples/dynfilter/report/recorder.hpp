// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>
#include "io/cloud_picture.hpp"

#include "eval/ate.hpp"
#include "io/association.hpp"
#include "map_sample.hpp"
#include "picture.hpp"
#include "run_record.hpp"
#include "running/pipeline_judge.hpp"

namespace dynfilter::command::report {

/// Collects the series of a report during a run. A run of more frames than a page can show is thinned: the
/// memory of the series is bounded.
class RunRecorder {
 public:
  /// `pictures`: at most so many of the played frames get one, `step` as in picture_step().
  /// `picture_bytes`: of all of them. `map_points`: of its map, at most. `most_rows`: frames with figures.
  RunRecorder(const StageTotals& stages, std::size_t frames, std::size_t pictures, std::size_t picture_bytes,
              std::size_t map_points, std::size_t step = 1, std::size_t most_rows = kMostRows)
      : step_(picture_step(frames, pictures, step)),
        bytes_each_(picture_bytes / std::max<std::size_t>(1, (frames + step_ - 1) / step_)),
        most_pictures_(pictures),
        encoder_(bytes_each_),
        map_points_(map_points),
        most_rows_(most_rows) {
    for (const StageTotal& stage : stages.stages())
      record_.stages.push_back({stage.call_point, stage.name, stage.path, stage.depth, {}});
    record_.rows.reserve(std::min(frames, most_rows_));
  }

  /// For the frame that add() gets next.
  bool wants_picture() const { return frames_ % step_ == 0 && record_.pictures.size() < most_pictures_; }
  /// Width to draw a picture in. Small ones have symbols large enough to be seen, and no text. 0: any width.
  int picture_width_px() const { return bytes_each_ < kSmallPictureBytes ? kSmallPictureWidth_px : 0; }
  void add_picture(const cv::Mat& drawn) { record_.pictures.push_back({place(), encoder_.encode(drawn)}); }

  /// `age_frames`: of the boxes or masks that the frame got; NaN without any.
  void add(const FrameRow& row, const PipelineJudge& judge, double age_frames) {
    if (frames_ % every_ == 0) {
      if (record_.rows.size() == most_rows_) thin();
      if (frames_ % every_ == 0) add_row(row, judge, age_frames);
    }
    mark(row, judge.record(), age_frames);
    ++frames_;
  }

  /// `cloud`: the run's map, if it built one.
  RunRecord finish(const std::optional<io::Trajectory>& truth, const io::Trajectory& estimate,
                   const Summary& summary, const mapping::MapCloud* cloud) {
    record_.summary = summary;
    if (every_ > 1) record_.summary.notes.push_back(fmt::format("this page shows every {}. frame", every_));
    locate(truth, estimate);
    if (cloud != nullptr && cloud->size() > 0 && !estimate.empty())
      sample_map(*cloud, estimate.front().T_world_camera);
    return std::move(record_);
  }

 private:
  static constexpr std::size_t kMostTruth = 1500;

  /// Of the frame that comes, in the series.
  std::size_t place() const { return frames_ / every_; }

  void add_row(const FrameRow& row, const PipelineJudge& judge, double age_frames) {
    record_.rows.push_back(row);
    record_.age_frames.push_back(age_frames);
    record_.restored.push_back(kept_by_floor(judge.record()));
    count_reasons(judge);
    take_times(judge.record().reports);
  }

  /// Every second row goes.
  void thin() {
    every_ *= 2;
    keep_even(record_.rows);
    keep_even(record_.age_frames);
    keep_even(record_.restored);
    for (ReasonSeries& series : record_.reasons) keep_even(series.features);
    for (StageSeries& series : record_.stages) keep_even(series.ms);
    for (FramePicture& picture : record_.pictures) picture.frame /= 2;
    for (FrameMark& mark : record_.marks) mark.frame /= 2;
    const auto same = [](const FrameMark& a, const FrameMark& b) {
      return a.frame == b.frame && a.kind == b.kind;
    };
    std::stable_sort(record_.marks.begin(), record_.marks.end(), [](const FrameMark& a, const FrameMark& b) {
      return std::tie(a.frame, a.kind) < std::tie(b.frame, b.kind);
    });
    record_.marks.erase(std::unique(record_.marks.begin(), record_.marks.end(), same), record_.marks.end());
  }
  template <class T>
  static void keep_even(std::vector<T>& series) {
    for (std::size_t k = 0; 2 * k < series.size(); ++k) std::swap(series[k], series[2 * k]);
    series.resize((series.size() + 1) / 2);
  }

  static std::size_t kept_by_floor(const FrameVerdict& verdict) {
    return static_cast<std::size_t>(
        std::count_if(verdict.features.begin(), verdict.features.end(),
                      [](const MarkedFeature& f) { return f.restored && f.decision == Vote::Unknown; }));
  }

  void count_reasons(const PipelineJudge& judge) {
    std::map<std::string, std::size_t> counts;
    for (const MarkedFeature& f : judge.record().features)
      if (f.decision == Vote::Dynamic) ++counts[judge.reason(f)];
    for (const auto& [name, features] : counts) series_of(name).features[place()] = features;
    for (ReasonSeries& series : record_.reasons) series.features.resize(place() + 1, 0);
  }
  ReasonSeries& series_of(const std::string& name) {
    auto found = std::find_if(record_.reasons.begin(), record_.reasons.end(),
                              [&](const ReasonSeries& series) { return series.name == name; });
    if (found == record_.reasons.end()) found = record_.reasons.insert(found, {name, {}});
    found->features.resize(place() + 1, 0);
    return *found;
  }

  void take_times(const std::vector<std::pair<CallPoint, StageReport>>& reports) {
    for (StageSeries& series : record_.stages) series.ms.push_back(NAN);
    for (const auto& [call_point, report] : reports)
      for (StageSeries& series : record_.stages) {
        if (series.call_point != to_string(call_point) || series.path != report.path ||
            series.name != report.name)
          continue;
        double& ms = series.ms.back();
        ms = std::isnan(ms) ? report.time_ms : ms + report.time_ms;
      }
  }

  void mark(const FrameRow& row, const FrameVerdict& verdict, double age_frames) {
    const auto add = [this](const char* kind, std::string text) {
      if (every_ == 1 || is_new_mark(kind)) record_.marks.push_back({place(), kind, std::move(text)});
    };
    if (row.state == "lost") add("lost", "tracking lost");
    if (row.state == "no_map") add("lost", "no map yet");
    if (row.restored > 0)
      add("floor",
          fmt::format("the floor restored {} {}", row.restored, row.restored == 1 ? "feature" : "features"));
    if (age_frames >= 1)
      add("late",
          fmt::format("boxes or masks are {:.0f} {} old", age_frames, age_frames == 1 ? "frame" : "frames"));
    for (const auto& [call_point, report] : verdict.reports) {
      if (report.failed) add("failed", report.name + ": " + report.note);
      if (report.note.find("uncertain") != std::string::npos)
        add("uncertain", report.name + ": " + report.note);
    }
  }

  /// Of several marks of one kind in one place the first is enough.
  bool is_new_mark(const std::string& kind) const {
    for (auto mark = record_.marks.rbegin(); mark != record_.marks.rend() && mark->frame == place(); ++mark)
      if (mark->kind == kind) return false;
    return true;
  }

  void locate(const std::optional<io::Trajectory>& truth, const io::Trajectory& estimate) {
    const Eigen::Vector3d nowhere = Eigen::Vector3d::Constant(NAN);
    record_.positions_m.assign(record_.rows.size(), nowhere);
    record_.errors_m.assign(record_.rows.size(), NAN);
    std::map<double, std::size_t> row_at;
    for (std::size_t k = 0; k < record_.rows.size(); ++k) row_at[record_.rows[k].timestamp_s] = k;
    const std::vector<double> errors_m = align_to(truth, estimate);
    for (std::size_t j = 0; j < estimate.size(); ++j) {
      const auto row = row_at.find(estimate[j].timestamp_s);
      if (row == row_at.end()) continue;
      record_.positions_m[row->second] = shown(estimate[j].T_world_camera.t());
      record_.errors_m[row->second] = errors_m[j];
      record_.up -= T_.R * estimate[j].T_world_camera.R().col(1);  // a camera's y axis points down
    }
    if (aligned_) keep_truth(*truth);
  }

  Eigen::Vector3d shown(const Eigen::Vector3d& estimated_m) const { return T_.R * estimated_m + T_.t; }

  /// The error of each pose of the estimate; NaN without a partner.
  std::vector<double> align_to(const std::optional<io::Trajectory>& truth, const io::Trajectory& estimate) {
    std::vector<double> errors_m(estimate.size(), NAN);
    if (!truth || !std::isfinite(record_.summary.ate_rmse_m)) return errors_m;
    const eval::AteResult ate = eval::absolute_trajectory_error(*truth, estimate);
    T_ = ate.T_truth_estimate;
    aligned_ = true;
    const auto pairs = io::associate(stamps_s(*truth), stamps_s(estimate), eval::AteOptions().max_gap_s);
    for (std::size_t k = 0; k < pairs.size(); ++k) errors_m[pairs[k].second] = ate.errors_m[k];
    return errors_m;
  }
  static std::vector<double> stamps_s(const io::Trajectory& trajectory) {
    std::vector<double> stamps;
    for (const io::StampedPose& pose : trajectory) stamps.push_back(pose.timestamp_s);
    return stamps;
  }

  void keep_truth(const io::Trajectory& truth) {
    double first_s = INFINITY, last_s = -INFINITY;
    for (const FrameRow& row : record_.rows)
      first_s = std::min(first_s, row.timestamp_s), last_s = std::max(last_s, row.timestamp_s);
    std::vector<const io::StampedPose*> played;
    for (const io::StampedPose& pose : truth)
      if (pose.timestamp_s >= first_s && pose.timestamp_s <= last_s) played.push_back(&pose);
    const std::size_t step = played.size() / kMostTruth + 1;
    for (std::size_t i = 0; i < played.size(); i += step) {
      record_.truth_m.push_back(played[i]->T_world_camera.t());
      record_.truth_s.push_back(played[i]->timestamp_s);
    }
  }

  void sample_map(const mapping::MapCloud& cloud, const Pose& T_world_first) {
    record_.map_points = cloud.size();
    record_.map_up = -(T_.R * mapping::level_pose(cloud, T_world_first).R().col(1));
    for (const std::size_t i : map_sample(cloud.points_m, map_points_)) {
      const cv::Point3f& p = cloud.points_m[i];
      record_.map_m.push_back(shown({p.x, p.y, p.z}).cast<float>());
      record_.map_bgr.push_back(cloud.colours.empty() ? cv::Vec3b(128, 128, 128) : cloud.colours[i]);
    }
  }

  RunRecord record_;
  std::size_t step_, bytes_each_, most_pictures_;
  PictureEncoder encoder_;
  std::size_t map_points_, most_rows_, frames_ = 0;
  std::size_t every_ = 1;  ///< how many frames a row is for
  eval::Similarity T_;     ///< estimate to truth
  bool aligned_ = false;
};

}  // namespace dynfilter::command::report
