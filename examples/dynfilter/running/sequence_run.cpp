// SPDX-License-Identifier: MIT
#include "sequence_run.hpp"

#include <fmt/format.h>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/detectors/detections.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <thread>
#include <utility>

#include "command_registry.hpp"
#include "frame_row.hpp"
#include "frame_show.hpp"
#include "given_poses.hpp"
#include "identity.hpp"
#include "interruption.hpp"
#include "io/cpu_clock.hpp"
#include "io/pose_lookup.hpp"
#include "io/sequence.hpp"
#include "io/trajectory.hpp"
#include "map/map_run.hpp"
#include "motion_priors.hpp"
#include "odometry/odometry.hpp"
#include "pipeline_judge.hpp"
#include "render/scene_file.hpp"
#include "report/page.hpp"
#include "report/recorder.hpp"
#include "results_folder.hpp"
#include "run_input.hpp"
#include "run_notes.hpp"
#include "run_output.hpp"
#include "semantic_feed.hpp"
#include "semantic_source.hpp"

namespace dynfilter::command {
namespace {

/// All seeds of a rendered scene have one name. A recording is its own scene.
std::string scene_of(const io::Sequence& sequence) {
  if (const auto rendered = render::read_scene_name(sequence.folder())) return rendered->scene;
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(sequence.folder(), error);
  return error ? sequence.name() : whole.lexically_normal().string();
}

bool has_any_depth(const io::SequenceFrame& frame) {
  return !frame.depth.empty() && cv::countNonZero(frame.depth) > 0;
}

class SequenceRun {
 public:
  explicit SequenceRun(const RunOptions& options, const RecordOptions& record)
      : options_(options),
        folder_(results_folder(options)),
        truth_(std::make_shared<OracleLabels>()),
        judge_(named_pipeline(options.pipeline, command_registry(options.plugins, truth_))),
        sequence_(open_sequence(options)),
        order_((check_stream(options, sequence_), playing_order(options, sequence_.size()))),
        sensor_(chosen_sensor(options, sequence_)),
        odometry_(sequence_.camera(), odometry_options(sensor_, !options.no_weights, has_poses()), &judge_),
        priors_(options, summary_.notes),
        overlay_(sequence_.is_stream() ? FrameShow::kWidth_px : 0),
        record_(record.record) {
    if (!options.map.empty() && sensor_ != odometry::Sensor::Rgbd)
      throw IoError(options.sequence + ": a map needs depth images" +
                    (sequence_.is_stream() ? ", and a video has none; give a folder with depth" : ""));
    identify();
    summary_.sensor = odometry::to_string(sensor_);
    ground_truth_ = sequence_.ground_truth();
    if (!options.trajectory.empty()) poses_.emplace(given_poses(options, sequence_, order_, summary_.notes));
    open_feed();
    oracle_ = uses_stage(judge_.pipeline(), OracleFilter::kName);
    require_labels(judge_.pipeline(), sequence_.has_labels(), options.sequence);
    // In reverse there is no truth: the truth images describe motion over earlier frames.
    judged_by_truth_ = sequence_.has_labels() && !options.reverse;
    if (sequence_.has_labels() && options.reverse)
      summary_.notes.emplace_back("played in reverse: no precision and recall");
    if (!options.map.empty()) map_.emplace(options, judge_.pipeline(), sequence_);
    if (!options.out.empty()) output_.emplace(*folder_, expected_frames(), options.overlay_every, overlay_);
    open_recorder(record);
    show_.emplace(options, !sequence_.is_camera());  // last: a window opens when all else is in order
  }

  Summary run(const std::function<void(std::size_t, std::size_t)>& progress) {
    for (std::size_t k = 0; k < order_.size(); ++k) {
      progress(k, order_.size());
      const double next_s = k + 1 < order_.size() ? played_s(order_[k + 1]) : INFINITY;
      if (show_->drops(next_s)) continue;
      if (!play(order_[k], k)) break;
    }
    const auto step = [&] { progress(order_.size(), order_.size()); };
    step();
    if (statistics_.frames() == 0) throw IoError(options_.sequence + ": no frame could be decoded");
    note_source();
    if (sensor_ == odometry::Sensor::Rgbd && !any_depth_)
      throw IoError(options_.sequence + ": no frame has any depth");
    if (blank_depth_ > 0)
      count_note(fmt::format("{} with a depth image of zeros only", frames(blank_depth_)));
    for (const auto& [note, times] : notes_.counts()) count_note(fmt::format("{} ({})", note, frames(times)));
    for (const auto& [note, times] : stage_notes_.counts())
      summary_.stage_notes.push_back(fmt::format("{} ({})", note, frames(times)));
    summary_.stages = judge_.totals();
    summary_.detector = feed_->summary();
    if (const std::string learned = priors_.summary(); !learned.empty()) count_note(learned);
    statistics_.summarise(summary_);
    if (nothing_judged()) count_note(unknown_note(summary_.stages) + option_for(summary_.stages.reasons()));
    const io::Trajectory estimate = trajectory();
    summary_.tracked_frames = estimate.size();  // a mono map that was started again has lost its poses
    settle_poses();
    summarise_trajectory(ground_truth_, estimate, summary_);
    check_failures();
    if (map_) summary_.map = map_->finish(estimate, summary_.notes);
    step();
    if (recorder_) finish_record(estimate);
    show_->commit();
    if (output_) output_->finish(estimate, summary_);
    return summary_;
  }

 private:
  // Poses would be those of another camera.
  bool has_poses() const { return !sequence_.camera_is_guessed() || !options_.trajectory.empty(); }

  // Of a camera that is ended by the user nobody knows.
  std::size_t expected_frames() const {
    return sequence_.is_camera() ? std::min(order_.size(), report::kMostVideoPictures) : order_.size();
  }

  void note_source() {
    std::vector<std::string> notes = sequence_.notes();  // of a video they are complete at the end
    summary_.notes.insert(summary_.notes.begin(), notes.begin(), notes.end());
    if (show_->dropped() > 0)
      count_note(fmt::format("{} dropped to keep the pace of the recording", frames(show_->dropped())));
    if (missed_.count() > 0)
      count_note(fmt::format("about {} of the camera were missed: it sends more than are processed",
                             frames(missed_.count())));
    if (!sequence_.is_stream()) return;
    costs_.frames = statistics_.frames();
    costs_.encodes = !options_.video.empty();
    if (!sequence_.is_camera()) costs_.source_rate_hz = sequence_.rate_hz();
    summary_.costs = costs_;
  }

  // Without a truth, a camera that stands or turns is no failure of a run on a video.
  void settle_poses() {
    if (!has_poses()) {
      summary_.verdicts_only = true;
      count_note("the camera is not known: verdicts only, no trajectory");
    } else if (sequence_.is_stream() && summary_.tracked_frames == 0) {
      summary_.verdicts_only = true;
      count_note("the camera did not move enough for a map: verdicts only");
    }
  }

  // Of what was opened, not of what was asked for.
  void identify() {
    summary_.sequence = options_.sequence_name.empty() ? sequence_.name() : options_.sequence_name;
    summary_.scene = scene_of(sequence_);
    summary_.folder = canonical_text(sequence_.folder());
    summary_.pipeline = judge_.pipeline().name();
    const PipelineSource source = pipeline_source(options_.pipeline);
    summary_.pipeline_file = source.file, summary_.pipeline_digest = source.digest;
  }

  void check_failures() {
    const DetectorSummary& detector = *summary_.detector;
    if (detector.failed > 0 || detector.abandoned) {
      const std::string why = ": " + detector.last_error;
      if (detector.results + detector.silent == 0)
        return summary_.fail("the detector failed on every image" + why);
      count_note(fmt::format("the detector failed on {} of {}{}{}", detector.failed,
                             counted(static_cast<std::size_t>(detector.looked_at), "image"),
                             detector.abandoned ? ", and was then abandoned" : "", why));
    }
    const std::string failed_stage = failure_of(summary_.stages);
    if (!failed_stage.empty()) summary_.fail(failed_stage);
  }

  static std::unique_ptr<ResultsFolder> results_folder(const RunOptions& options) {
    const std::initializer_list<const char*> results{"summary.json", "trajectory.txt", "frames.csv",
                                                     "verdicts.csv", "report.html",    "overlay"};
    return options.out.empty() ? nullptr
                               : std::make_unique<ResultsFolder>(options.out, options.force, results);
  }

  static std::string frames(std::size_t n) { return counted(n, "frame"); }
  void count_note(std::string note) { summary_.notes.push_back(std::move(note)); }

  // A front end needs increasing time. In reverse, timestamps are mirrored at the first frame.
  double played_s(std::size_t i) const {
    const double stamp_s = sequence_.timestamp_s(i);
    return options_.reverse ? 2 * sequence_.timestamp_s(order_[0]) - stamp_s : stamp_s;
  }

  std::optional<Pose> pose_at(std::size_t i) const {
    return poses_ ? poses_->at(sequence_.timestamp_s(i)) : std::nullopt;
  }

  void open_feed() { feed_.emplace(semantic_feed(options_, sequence_, order_, summary_.notes)); }

  // An asynchronous detector gets the frames at the camera's rate, to have a realistic delay.
  void keep_pace(double timestamp_s) {
    if (options_.detector_mode != "async") return;
    if (!began_) began_ = std::chrono::steady_clock::now();
    const std::chrono::duration<double> since_start(timestamp_s - played_s(order_[0]));
    std::this_thread::sleep_until(
        *began_ + std::chrono::duration_cast<std::chrono::steady_clock::duration>(since_start));
  }

  /// False where the source ends, or the user ends it.
  bool play(std::size_t i, std::size_t k) {
    const io::CpuClock all = io::CpuClock::of_process();
    std::optional<io::SequenceFrame> read = sequence_.read(i);
    if (!read) return false;
    io::SequenceFrame& frame = *read;
    frame.timestamp_s = played_s(i);
    if (sensor_ != odometry::Sensor::Rgbd) frame.depth = cv::Mat();  // nor may the detector have it
    any_depth_ = any_depth_ || has_any_depth(frame);
    blank_depth_ += !frame.depth.empty() && !has_any_depth(frame) ? 1 : 0;
    if (oracle_) truth_->labels = sequence_.load_labels(i);
    keep_pace(frame.timestamp_s);
    const io::CpuClock boxes = io::CpuClock::of_thread();
    odometry::SemanticInputs inputs = feed_->next(static_cast<std::int64_t>(statistics_.frames()), frame);
    inputs.motion_prior = priors_.next(sequence_.timestamp_s(i));
    costs_.boxes_ms += boxes.ms(), costs_.grey_ms += frame.convert_ms;
    const io::CpuClock judging = io::CpuClock::of_thread();
    const odometry::TrackResult result = odometry_.process(frame, inputs, pose_at(i));
    costs_.add(result.ms, judging.ms());
    priors_.tracked(result.T_world_camera);
    const FrameRow row = row_of(i, result);
    statistics_.add(row);
    if (sequence_.is_camera()) missed_.add(frame.timestamp_s, sequence_.rate_hz());
    if (map_) {
      map_->add(i, frame, result, odometry_, inputs, judge_.record(), oracle_ ? truth_->labels : cv::Mat());
    }
    const io::CpuClock drawing = io::CpuClock::of_thread();
    take_record(row, frame, inputs);
    const std::optional<cv::Mat> shown = shown_picture(row, frame, inputs);
    costs_.drawing_ms += drawing.ms(), costs_.process_ms += all.ms();
    const double next_s = k + 1 < order_.size() ? played_s(order_[k + 1]) : frame.timestamp_s;
    return !shown || show_->add(*shown, frame.timestamp_s, next_s, played_rate_hz());
  }

  double played_rate_hz() const {
    constexpr double kUsual_hz = 30;
    const std::size_t n = order_.size();
    double rate_hz = sequence_.rate_hz();
    if (rate_hz == 0 && n > 1)
      rate_hz = static_cast<double>(n - 1) / (played_s(order_[n - 1]) - played_s(order_[0]));
    return rate_hz > 0 ? rate_hz / static_cast<double>(sequence_.is_stream() ? options_.step : 1) : kUsual_hz;
  }

  void open_recorder(const RecordOptions& record) {
    if (output_ && sequence_.is_stream())
      recorder_.emplace(judge_.totals(), expected_frames(), report::kMostVideoPictures, report::kPictureBytes,
                        report::kMostMapPoints);
    else if (output_)
      recorder_.emplace(judge_.totals(), order_.size(), report::kMostPictures, report::kPictureBytes,
                        report::kMostMapPoints, output_->every());
    else if (record_ != nullptr)
      recorder_.emplace(judge_.totals(), order_.size(), record.pictures, record.picture_bytes,
                        record.map_points, 1, record.rows);
  }

  void take_record(const FrameRow& row, const io::SequenceFrame& frame,
                   const odometry::SemanticInputs& inputs) {
    if (!recorder_) return;
    cv::Mat drawn;
    if (output_) drawn = output_->add(row, judge_, picture_of(frame, inputs, row));
    if (recorder_->wants_picture()) {
      if (const int width_px = recorder_->picture_width_px(); width_px > 0)
        drawn = Overlay(width_px).draw_bare(judged_picture(frame, inputs, row));
      else if (drawn.empty())
        drawn = Overlay().draw(judged_picture(frame, inputs, row));
      recorder_->add_picture(drawn);
    }
    recorder_->add(row, judge_, age_of(inputs));
  }

  std::optional<cv::Mat> shown_picture(const FrameRow& row, const io::SequenceFrame& frame,
                                       const odometry::SemanticInputs& inputs) const {
    if (!show_->wants_frames()) return std::nullopt;
    OverlayFrame picture = judged_picture(frame, inputs, row);
    const auto n = static_cast<double>(std::max<std::size_t>(1, row.features));
    picture.title += fmt::format("   {:.1f} ms   {:.0f} % rejected", row.total_ms(),
                                 100 * static_cast<double>(row.dynamic) / n);
    return Overlay(FrameShow::kWidth_px).draw(picture);
  }
  // Of the older one of boxes and mask.
  double age_of(const odometry::SemanticInputs& inputs) const {
    const auto now = static_cast<std::int64_t>(statistics_.frames()) - 1;
    double age = NAN;
    const auto see = [&](std::int64_t frame_id) {
      if (frame_id >= 0) age = std::fmax(age, static_cast<double>(now - frame_id));
    };
    if (inputs.detections) see(inputs.detections->frame_id);
    if (inputs.mask) see(inputs.mask->frame_id);
    return age;
  }

  void finish_record(const io::Trajectory& estimate) {
    report::RunRecord record =
        recorder_->finish(ground_truth_, estimate, summary_, map_ ? &map_->cloud() : nullptr);
    if (output_)
      output_->write("report.html",
                     report::run_page(record, report::reference_summaries(options_.out, summary_)));
    if (record_ != nullptr) *record_ = std::move(record);
  }

  FrameRow row_of(std::size_t i, const odometry::TrackResult& result) {
    const FrameVerdict& verdict = judge_.record();
    FrameRow row = frame_row(i, sequence_.timestamp_s(i), result, verdict);
    for (const std::string& note : verdict.stage_notes) stage_notes_.add(note);
    for (const std::string& note : verdict.notes) notes_.add(note);
    if (judged_by_truth_) row.truth = judged(verdict, sequence_.load_truth(i));
    return row;
  }

  bool nothing_judged() const {
    return !summary_.stages.empty() && summary_.features_mean > 0 && !statistics_.any_judged();
  }
  // Inputs that a run can provide.
  static std::string option_for(const std::vector<std::string>& reasons) {
    const auto lacks = [&](const char* input) {
      return std::any_of(reasons.begin(), reasons.end(), [input](const std::string& reason) {
        return reason.find(input) != std::string::npos;
      });
    };
    if (lacks("boxes")) return "; boxes come from --detections or --detector";
    if (lacks("mask")) return "; masks come from --masks or --detector";
    return "";
  }

  OverlayFrame judged_picture(const io::SequenceFrame& frame, const odometry::SemanticInputs& inputs,
                              const FrameRow& row) const {
    OverlayFrame picture = picture_of(frame, inputs, row);
    picture.features = judge_.record().features;
    picture.stages = judge_.stages();
    return picture;
  }

  OverlayFrame picture_of(const io::SequenceFrame& frame, const odometry::SemanticInputs& inputs,
                          const FrameRow& row) const {
    OverlayFrame picture;
    picture.colour = frame.colour;
    const std::string of = sequence_.is_camera() ? "" : fmt::format(" of {}", sequence_.size());
    picture.title = fmt::format("{}   {}   frame {}{}   {}", summary_.pipeline, summary_.sequence, row.index,
                                of, row.state);
    if (inputs.detections)
      picture.detections.assign(inputs.detections->detections.begin(), inputs.detections->detections.end());
    if (inputs.mask && inputs.mask->labels.size() == frame.colour.size()) picture.mask = inputs.mask->labels;
    return picture;
  }

  // With the frames' own timestamps.
  io::Trajectory trajectory() {
    std::map<double, double> own_s;
    io::Trajectory estimate = odometry_.trajectory();
    if (estimate.empty()) return estimate;
    for (const std::size_t i : order_) own_s[played_s(i)] = sequence_.timestamp_s(i);
    for (io::StampedPose& pose : estimate) pose.timestamp_s = own_s.at(pose.timestamp_s);
    estimate = io::sorted_by_time(std::move(estimate));
    if (sensor_ == odometry::Sensor::Mono) scale_to_truth(estimate);
    return estimate;
  }

  // A mono map has its own unit. With a ground truth, all that is written and judged is in metres.
  void scale_to_truth(io::Trajectory& estimate) {
    eval::AteOptions with_scale;
    with_scale.with_scale = true;
    if (!ground_truth_ || poses_) return;
    try {
      const double scale =
          eval::absolute_trajectory_error(*ground_truth_, estimate, with_scale).T_truth_estimate.scale;
      for (io::StampedPose& pose : estimate)
        for (double& x : pose.T_world_camera.translation_m) x *= scale;
      count_note(fmt::format("mono: the trajectory is scaled by {:.4g} to the ground truth", scale));
    } catch (const Error&) {  // too few poses: summarise_trajectory() says so
    }
  }

  RunOptions options_;
  std::unique_ptr<ResultsFolder> folder_;  ///< first: the rest may take long to open
  std::shared_ptr<OracleLabels> truth_;
  PipelineJudge judge_;
  io::Sequence sequence_;
  std::vector<std::size_t> order_;
  odometry::Sensor sensor_;
  odometry::Odometry odometry_;
  Summary summary_;
  MotionPriors priors_;
  std::optional<io::Trajectory> ground_truth_;
  std::optional<SemanticFeed> feed_;
  std::optional<std::chrono::steady_clock::time_point> began_;
  std::optional<io::PoseLookup> poses_;  ///< poses of another SLAM
  std::optional<MapRun> map_;
  Overlay overlay_;
  std::optional<RunOutput> output_;
  std::optional<FrameShow> show_;
  FrameCosts costs_;
  report::RunRecord* record_;  ///< for the caller, or null
  std::optional<report::RunRecorder> recorder_;
  FrameStatistics statistics_;
  NoteCounts notes_, stage_notes_;
  MissedFrames missed_;
  std::size_t blank_depth_ = 0;
  bool oracle_ = false, judged_by_truth_ = false, any_depth_ = false;
};

}  // namespace

Summary run_sequence(const RunOptions& options, const std::function<void(std::size_t, std::size_t)>& progress,
                     const RecordOptions& record) {
  cv::setNumThreads(options.threads);
  return SequenceRun(options, record).run(progress);
}

}  // namespace dynfilter::command
