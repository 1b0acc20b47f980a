// SPDX-License-Identifier: MIT
#include "replay_run.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/recorder/recording.hpp>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>

#include "command_registry.hpp"
#include "frame_row.hpp"
#include "identity.hpp"
#include "interruption.hpp"
#include "io/trajectory.hpp"
#include "pipeline_judge.hpp"
#include "recording_cut.hpp"
#include "report/page.hpp"
#include "report/recorder.hpp"
#include "results_folder.hpp"
#include "run_notes.hpp"
#include "run_output.hpp"

namespace dynfilter::command {
namespace {

using recorder::RecordedEvent;
using recorder::RecordingReader;
namespace fs = std::filesystem;

class ReplayRun {
 public:
  explicit ReplayRun(const ReplayOptions& options)
      : options_(options), folder_(results_folder(options)), reader_(options.recording), judge_(config()) {
    if (!options.cut.empty()) {
      replay_.cut = cut_range(options.cut);
      cut_file_.emplace(options.cut_file, options.force);
      judge_.pipeline().set_observer(cut_file_->recorder());
    }
    identify();
    if (!folder_) return;
    output_.emplace(*folder_, reader_.calls(), options.overlay_every, Overlay());
    recorder_.emplace(judge_.totals(), reader_.calls(), report::kMostPictures, report::kPictureBytes,
                      report::kMostMapPoints, output_->every());
    differences_ = "frame,id,call_point,features,decisions,any,report\n";
  }

  ReplaySummary run(const std::function<void(std::size_t, std::size_t)>& progress) {
    while (const std::optional<RecordedEvent> event = reader_.next()) {
      Interruption::check();
      progress(replay_.comparison.calls, reader_.calls());
      if (!play(*event)) break;
    }
    end_frame();
    progress(reader_.calls(), reader_.calls());
    if (statistics_.frames() == 0) throw IoError(options_.recording + ": " + why_nothing());
    if (replay_.cut && replay_.cut->second >= frames_)
      throw Error("--cut " + options_.cut + ": the recording has only " + counted(frames_, "frame"));
    finish_summary();
    if (cut_file_) {
      judge_.pipeline().set_observer(nullptr);  // writes what waits
      cut_file_->commit();
    }
    if (output_) finish_output();
    return replay_;
  }

 private:
  static std::unique_ptr<ResultsFolder> results_folder(const ReplayOptions& options) {
    const std::initializer_list<const char*> results{"summary.json", "trajectory.txt",  "frames.csv",
                                                     "verdicts.csv", "differences.csv", "report.html",
                                                     "overlay"};
    return options.out.empty() ? nullptr
                               : std::make_unique<ResultsFolder>(options.out, options.force, results);
  }

  PipelineConfig config() {
    replay_.recorded_pipeline = options_.pipeline.empty();
    const Registry registry = command_registry(options_.plugins);
    if (!options_.pipeline.empty()) return named_pipeline(options_.pipeline, registry);
    try {
      return recorder::config_of(reader_.pipeline(), registry);
    } catch (const ConfigError& error) {
      throw ConfigError(options_.recording,
                        error.what() + std::string(" (--pipeline replays with another pipeline, "
                                                   "--plugin adds the host's own rejectors)"));
    }
  }

  void identify() {
    Summary& s = replay_.run;
    s.sequence = fs::path(options_.recording).filename().string();
    s.folder = s.scene = canonical_text(options_.recording);
    s.pipeline = judge_.pipeline().name();
    if (replay_.recorded_pipeline) {
      s.pipeline_file = s.folder, s.pipeline_digest = digest_of(reader_.pipeline().yaml);
    } else {
      const PipelineSource source = pipeline_source(options_.pipeline);
      s.pipeline_file = source.file, s.pipeline_digest = source.digest;
    }
    s.notes = reader_.notes();
  }

  bool is_in_cut() const {
    return !replay_.cut || (number_ >= replay_.cut->first && number_ <= replay_.cut->second);
  }

  /// False behind the frames that were asked for.
  bool play(const RecordedEvent& event) {
    if (event.kind == RecordedEvent::Kind::Frame) {
      const bool is_new = frames_ == 0 || event.frame.id != last_id_ || event.point == CallPoint::BeforePose;
      if (is_new) {
        end_frame();
        number_ = frames_;
        if (replay_.cut && number_ > replay_.cut->second) return false;
        ++frames_, last_id_ = event.frame.id;
      }
      if (is_in_cut()) judge(event, is_new);
    } else if (frames_ == 0 || is_in_cut()) {
      event.repeat(judge_.pipeline());
      if (event.kind == RecordedEvent::Kind::Pose) refine(event);
    }
    return true;
  }

  void judge(const RecordedEvent& event, bool is_new) {
    const Verdict& verdict =
        judge_.judge_recorded(event.frame.view(keyframes_), event.point, event.limits, is_new || !shown_);
    compare(event, verdict);
    see_pose(event.frame.id, event.frame.timestamp_s, event.frame.T_world_camera,
             event.frame.pose_provenance);
    keyframe_ = keyframe_ || event.point == CallPoint::AtKeyframe;
    replay_.images_left_out += event.frame.images_left_out > 0 ? 1 : 0;
    if (!shown_) shown_ = event.frame;
  }

  void refine(const RecordedEvent& event) {
    const auto known = poses_.find(event.pose_frame_id);
    if (known != poses_.end()) known->second.T_world_camera = event.T_world_camera;
  }
  /// A prediction is no place of the trajectory.
  void see_pose(std::int64_t id, double timestamp_s, const Pose& pose, PoseProvenance provenance) {
    if (provenance == PoseProvenance::Estimated || provenance == PoseProvenance::Refined)
      poses_[id] = {timestamp_s, pose};
  }

  void compare(const RecordedEvent& event, const Verdict& verdict) {
    ReplayComparison& c = replay_.comparison;
    ++c.calls;
    if (!event.verdict) return;
    ++c.compared;
    const recorder::VerdictDifference found = recorder::difference(*event.verdict, verdict);
    // Reasons and reports of another pipeline are other ones.
    if (replay_.recorded_pipeline ? !found.any() : found.decisions == 0) return;
    ++c.differ;
    c.decisions += found.decisions;
    frame_differs_ = true, frame_decisions_ += found.decisions;
    const DifferentCall call{number_, event.frame.id, to_string(event.point)};
    if (!c.first) c.first = call;
    c.last = call;
    if (output_)
      differences_ += fmt::format("{},{},{},{},{},{},{}\n", number_, call.id, call.point, verdict.size(),
                                  found.decisions, found.features, found.report ? 1 : 0);
  }

  /// The frame before is complete.
  void end_frame() {
    if (!shown_) return;
    const FrameVerdict& verdict = judge_.record();
    if (statistics_.frames() == 0) replay_.run.sensor = sensor_of(*shown_);
    odometry::TrackResult result;
    const bool tracked = poses_.count(shown_->id) != 0;
    result.state = tracked ? odometry::TrackState::Tracked : odometry::TrackState::Judged;
    result.keyframe = keyframe_;
    result.ms.judge = verdict.correspondence_ms + verdict.filters_ms;
    FrameRow row = frame_row(number_, shown_->timestamp_s, result, verdict);
    if (frame_differs_)
      row.note = fmt::format("differs from the recording in {}{}{}", counted(frame_decisions_, "decision"),
                             row.note.empty() ? "" : "; ", row.note);
    for (const std::string& note : verdict.stage_notes) stage_notes_.add(note);
    for (const std::string& note : verdict.notes) notes_.add(note);
    statistics_.add(row);
    if (output_) add_row(row);
    shown_.reset();
    keyframe_ = frame_differs_ = false, frame_decisions_ = 0;
  }

  void add_row(const FrameRow& row) {
    OverlayFrame picture;
    picture.colour = recorded_picture(*shown_);
    picture.title = fmt::format("{}   {}   frame {} (id {})   {}", replay_.run.pipeline, replay_.run.sequence,
                                row.index, shown_->id, row.state);
    if (shown_->detections) picture.detections = shown_->detections->detections;
    if (shown_->mask && shown_->mask->labels.size() == picture.colour.size())
      picture.mask = shown_->mask->labels;
    cv::Mat drawn = output_->add(row, judge_, picture);
    if (recorder_->wants_picture()) {
      picture.features = judge_.record().features;
      picture.stages = judge_.stages();
      if (const int width_px = recorder_->picture_width_px(); width_px > 0)
        drawn = Overlay(width_px).draw_bare(picture);
      else if (drawn.empty())
        drawn = Overlay().draw(picture);
      recorder_->add_picture(drawn);
    }
    recorder_->add(row, judge_, NAN);
  }

  static std::string sensor_of(const recorder::RecordedFrame& frame) {
    return !frame.right_u_px.empty()                        ? "stereo"
           : !frame.depth.empty() || !frame.depth_m.empty() ? "rgbd"
                                                            : "mono";
  }

  std::string why_nothing() const {
    if (replay_.cut && frames_ > 0)
      return "has only " + counted(frames_, "frame") + ", and --cut begins at frame " +
             std::to_string(replay_.cut->first);
    return "no frame was recorded";
  }

  void finish_summary() {
    Summary& s = replay_.run;
    if (replay_.images_left_out > 0)
      s.notes.push_back(fmt::format("{} without their images: verdicts that need them differ",
                                    counted(replay_.images_left_out, "call")));
    for (const auto& [note, times] : notes_.counts())
      s.notes.push_back(fmt::format("{} ({})", note, counted(times, "frame")));
    for (const auto& [note, times] : stage_notes_.counts())
      s.stage_notes.push_back(fmt::format("{} ({})", note, counted(times, "frame")));
    s.stages = judge_.totals();
    statistics_.summarise(s);
    s.verdicts_only = true;
    s.tracked_frames = poses_.size();
    const std::string failed_stage = failure_of(s.stages);
    if (!failed_stage.empty()) s.fail(failed_stage);
  }

  void finish_output() {
    io::Trajectory trajectory;
    for (const auto& [id, pose] : poses_) trajectory.push_back(pose);
    trajectory = io::sorted_by_time(std::move(trajectory));
    const report::RunRecord record = recorder_->finish(std::nullopt, trajectory, replay_.run, nullptr);
    output_->write("report.html",
                   report::run_page(record, report::reference_summaries(options_.out, replay_.run)));
    output_->write("differences.csv", differences_);
    output_->finish(trajectory, replay_.run);
  }

  ReplayOptions options_;
  std::unique_ptr<ResultsFolder> folder_;
  RecordingReader reader_;
  ReplaySummary replay_;
  std::optional<CutFile> cut_file_;  ///< before the judge, which writes to it
  PipelineJudge judge_;
  std::optional<RunOutput> output_;
  std::optional<report::RunRecorder> recorder_;
  FrameStatistics statistics_;
  NoteCounts notes_, stage_notes_;
  std::string differences_;
  std::map<std::int64_t, io::StampedPose> poses_;  ///< of the host, by frame
  std::vector<KeyframeView> keyframes_;
  std::optional<recorder::RecordedFrame> shown_;  ///< the frame that is being judged
  std::size_t frames_ = 0, number_ = 0;           ///< so far; of the frame
  std::int64_t last_id_ = -1;
  std::size_t frame_decisions_ = 0;  ///< of the frame that is being judged, as the flags
  bool keyframe_ = false, frame_differs_ = false;
};

}  // namespace

Json to_json(const ReplaySummary& replay) {
  const ReplayComparison& c = replay.comparison;
  const auto call = [](const std::optional<DifferentCall>& at) -> Json {
    if (!at) return nullptr;
    return {{"frame", at->frame}, {"id", at->id}, {"call_point", at->point}};
  };
  Json json = named_json(replay.run);
  json["replay"] = {{"recorded_pipeline", replay.recorded_pipeline},
                    {"calls", c.calls},
                    {"compared", c.compared},
                    {"differ", c.differ},
                    {"decisions", c.decisions},
                    {"first", call(c.first)},
                    {"last", call(c.last)}};
  return json;
}

ReplaySummary replay_recording(const ReplayOptions& options,
                               const std::function<void(std::size_t, std::size_t)>& progress) {
  cv::setNumThreads(options.threads);
  return ReplayRun(options).run(progress);
}

}  // namespace dynfilter::command
