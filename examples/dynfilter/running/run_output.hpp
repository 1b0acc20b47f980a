// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <cstddef>
#include <dynfilter/detectors/image_encoder.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <ostream>
#include <string>
#include <utility>

#include "io/trajectory.hpp"
#include "pipeline_judge.hpp"
#include "results_folder.hpp"
#include "run_summary.hpp"

namespace dynfilter::command {

/// The files of a run. They appear together after finish(), or not at all.
class RunOutput {
 public:
  RunOutput(ResultsFolder& folder, std::size_t frames, std::size_t overlay_every, const Overlay& overlay)
      : folder_(folder),
        every_(overlay_every > 0 ? overlay_every : (frames + kPictures - 1) / kPictures),
        overlay_(overlay),
        frames_(folder_.path() / kFrames),
        verdicts_(folder_.path() / kVerdicts) {
    std::filesystem::create_directory(folder_.path() / "overlay");
    frames_ << "frame,timestamp_s,state,keyframe,relocalised,features,static,dynamic,unknown,restored,"
               "weight_mean,tracked_points,dynamic_rejected,dynamic_kept,static_rejected,static_kept,dont_"
               "care,total_ms,"
               "extraction_ms,correspondence_ms,filters_ms,tracking_ms,cpu_ms,cpu_judge_ms,note\n";
    verdicts_ << "frame,x_px,y_px,verdict,restored,weight,reasons\n";
  }

  /// Every how many-th frame gets a picture.
  std::size_t every() const { return every_; }

  /// Writes a frame's rows to frames.csv and verdicts.csv and, at intervals, a picture, which it returns.
  cv::Mat add(const FrameRow& row, const PipelineJudge& judge, OverlayFrame picture) {
    frames_ << csv_line(row);
    frame_verdicts_.clear();
    for (const MarkedFeature& f : judge.record().features) {
      fmt::format_to(std::back_inserter(frame_verdicts_), "{},{:.2f},{:.2f},{},{},{:.3g},{}\n", row.index,
                     f.pixel.x, f.pixel.y, to_string(f.decision), f.restored ? 1 : 0, f.weight,
                     judge.reason(f));
    }
    verdicts_ << frame_verdicts_;
    check_written();
    if (count_++ % every_ != 0) return {};
    picture.features = judge.record().features;
    picture.stages = judge.stages();
    const std::filesystem::path path = folder_.path() / "overlay" / fmt::format("{:06}.png", row.index);
    const cv::Mat drawn = overlay_.draw(picture);
    io::write_image(path, drawn);
    return drawn;
  }

  void finish(const io::Trajectory& trajectory, const Summary& summary) {
    io::write_tum_trajectory(folder_.path() / "trajectory.txt", trajectory);
    frames_.close();
    verdicts_.close();
    check_written();
    folder_.write("summary.json", json_text(named_json(summary)));
    folder_.commit();
  }

  void write(const char* name, const std::string& text) { folder_.write(name, text); }

 private:
  static constexpr std::size_t kPictures = 50;
  static constexpr const char *kFrames = "frames.csv", *kVerdicts = "verdicts.csv";

  void check_written() const {
    for (const auto& [file, name] : {std::pair(&frames_, kFrames), std::pair(&verdicts_, kVerdicts)})
      if (!*file) throw IoError((folder_.path() / name).string() + ": cannot be written");
  }

  static std::string csv_line(const FrameRow& r) {
    return fmt::format(
        "{},{:.6f},{},{:d},{:d},{},{},{},{},{},{:.4f},{},{},{},{},{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:"
        ".3f},"
        "{:.3f},\"{}\"\n",
        r.index, r.timestamp_s, r.state, r.keyframe, r.relocalised, r.features, r.of_static, r.dynamic,
        r.unknown, r.restored, r.weight_mean, r.tracked_points, r.truth.dynamic_rejected,
        r.truth.dynamic_kept, r.truth.static_rejected, r.truth.static_kept_count, r.truth.dont_care,
        r.total_ms(), r.extraction_ms, r.correspondence_ms, r.filters_ms, r.tracking_ms, r.cpu_ms,
        r.cpu_judge_ms, r.note);
  }

  ResultsFolder& folder_;
  std::size_t every_, count_ = 0;
  Overlay overlay_;
  std::ofstream frames_, verdicts_;  ///< written frame by frame: a long run does not fit in memory
  std::string frame_verdicts_;
};

}  // namespace dynfilter::command
