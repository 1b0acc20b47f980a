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
#include "eval/classification.hpp"
#include "identity.hpp"
#include "interruption.hpp"
#include "io/pose_lookup.hpp"
#include "io/sequence.hpp"
#include "io/trajectory.hpp"
#include "map/map_run.hpp"
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
        order_(playing_order(options, sequence_.size())),
        sensor_(chosen_sensor(options, sequence_)),
        odometry_(sequence_.camera(), odometry_options(sensor_, !options.no_weights), &judge_),
        record_(record.record) {
    identify();
    summary_.sensor = odometry::to_string(sensor_);
    summary_.notes = sequence_.notes();
    ground_truth_ = sequence_.ground_truth();
    if (!options.trajectory.empty()) read_poses();
    open_feed();
    oracle_ = uses_stage(judge_.pipeline(), OracleFilter::kName);
    require_labels(judge_.pipeline(), sequence_.has_labels(), options.sequence);
    // In reverse there is no truth: the truth images describe motion over earlier frames.
    judged_by_truth_ = sequence_.has_labels() && !options.reverse;
    if (sequence_.has_labels() && options.reverse)
      summary_.notes.emplace_back("played in reverse: no precision and recall");
    if (!options.map.empty() && sensor_ != odometry::Sensor::Rgbd)
      throw IoError(options.sequence + ": a map needs depth images");
    if (!options.map.empty()) map_.emplace(options, judge_.pipeline(), sequence_);
    if (!options.out.empty()) output_.emplace(*folder_, order_.size(), options.overlay_every);
    open_recorder(record);
  }

  Summary run(const std::function<void(std::size_t, std::size_t)>& progress) {
    for (std::size_t k = 0; k < order_.size(); ++k) {
      progress(k, order_.size());
      play(order_[k]);
    }
    const auto step = [&] { progress(order_.size(), order_.size()); };
    step();
    if (sensor_ == odometry::Sensor::Rgbd && !any_depth_)
      throw IoError(options_.sequence + ": no frame has any depth");
    if (blank_depth_ > 0)
      count_note(fmt::format("{} with a depth image of zeros only", frames(blank_depth_)));
    for (const auto& [note, times] : notes_.counts()) count_note(fmt::format("{} ({})", note, frames(times)));
    for (const auto& [note, times] : stage_notes_.counts())
      summary_.stage_notes.push_back(fmt::format("{} ({})", note, frames(times)));
    summary_.stages = judge_.totals();
    summary_.detector = feed_->summary();
    statistics_.summarise(summary_);
    if (nothing_judged()) count_note(unknown_note(summary_.stages) + option_for(summary_.stages.reasons()));
    const io::Trajectory estimate = trajectory();
    summary_.tracked_frames = estimate.size();  // a mono map that was started again has lost its poses
    summarise_trajectory(ground_truth_, estimate, summary_);
    check_failures();
    if (map_) summary_.map = map_->finish(estimate, summary_.notes);
    step();
    if (recorder_) finish_record(estimate);
    if (output_) output_->finish(estimate, summary_);
    return summary_;
  }

 private:
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

  // Reads the poses of another SLAM. Frames without a pose are not played.
  void read_poses() {
    io::TrajectoryOddities odd;
    const io::Trajectory given = io::read_tum_trajectory(options_.trajectory, odd);
    const std::string name = std::filesystem::path(options_.trajectory).filename().string();
    if (odd.backwards > 0)
      count_note(fmt::format("{}: {} {} back: sorted by time", name, odd.backwards,
                             odd.backwards == 1 ? "stamp goes" : "stamps go"));
    if (odd.repeated > 0)
      count_note(fmt::format("{}: {} repeated {}: the last pose counts", name, odd.repeated,
                             odd.repeated == 1 ? "stamp" : "stamps"));
    if (odd.no_pose > 0)
      count_note(
          fmt::format("{}: {} {} without a pose", name, odd.no_pose, odd.no_pose == 1 ? "line" : "lines"));
    poses_.emplace(given, options_.max_gap_s);
    const std::size_t all = order_.size();
    const double first_s = sequence_.timestamp_s(order_.front()),
                 last_s = sequence_.timestamp_s(order_.back());
    order_.erase(std::remove_if(order_.begin(), order_.end(),
                                [&](std::size_t i) { return !poses_->at(sequence_.timestamp_s(i)); }),
                 order_.end());
    if (order_.empty())
      throw IoError(
          fmt::format("{}: no pose for any of the {} (poses from {:.3f} to {:.3f} s, frames from {:.3f} to "
                      "{:.3f} s)",
                      options_.trajectory, frames(all), given.front().timestamp_s, given.back().timestamp_s,
                      first_s, last_s));
    if (order_.size() < all)
      count_note(
          fmt::format("{} of {} have no pose and are left out (none within {:g} s of each other around them)",
                      all - order_.size(), frames(all), options_.max_gap_s));
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

  void play(std::size_t i) {
    io::SequenceFrame frame = sequence_.load(i);
    frame.timestamp_s = played_s(i);
    if (sensor_ != odometry::Sensor::Rgbd) frame.depth = cv::Mat();  // nor may the detector have it
    any_depth_ = any_depth_ || has_any_depth(frame);
    blank_depth_ += !frame.depth.empty() && !has_any_depth(frame) ? 1 : 0;
    if (oracle_) truth_->labels = sequence_.load_labels(i);
    keep_pace(frame.timestamp_s);
    const odometry::SemanticInputs inputs =
        feed_->next(static_cast<std::int64_t>(statistics_.frames()), frame);
    const odometry::TrackResult result = odometry_.process(frame, inputs, pose_at(i));
    const FrameRow row = row_of(i, result);
    statistics_.add(row);
    if (map_) {
      map_->add(i, frame, result, odometry_, inputs, judge_.record(), oracle_ ? truth_->labels : cv::Mat());
    }
    take_record(row, frame, inputs);
  }

  void open_recorder(const RecordOptions& record) {
    if (output_)
      recorder_.emplace(judge_.totals(), order_.size(), report::kMostPictures, report::kPictureBytes,
                        report::kMostMapPoints, output_->every());
    else if (record_ != nullptr)
      recorder_.emplace(judge_.totals(), order_.size(), record.pictures, record.picture_bytes,
                        record.map_points);
  }

  void take_record(const FrameRow& row, const io::SequenceFrame& frame,
                   const odometry::SemanticInputs& inputs) {
    if (!recorder_) return;
    cv::Mat drawn;
    if (output_) drawn = output_->add(row, judge_, picture_of(frame, inputs, row));
    if (recorder_->wants_picture()) {
      if (drawn.empty()) {
        OverlayFrame picture = picture_of(frame, inputs, row);
        picture.features = judge_.record().features;
        picture.stages = judge_.stages();
        drawn = Overlay().draw(picture);
      }
      recorder_->add_picture(drawn);
    }
    recorder_->add(row, judge_, age_of(inputs));
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
    FrameRow row;
    row.index = i;
    row.timestamp_s = sequence_.timestamp_s(i);
    row.state = odometry::to_string(result.state);
    row.keyframe = result.keyframe, row.relocalised = result.relocalised;
    row.features = verdict.features.size();
    row.of_static = verdict.count(Vote::Static), row.dynamic = verdict.count(Vote::Dynamic);
    row.unknown = verdict.count(Vote::Unknown), row.restored = verdict.restored();
    row.weight_mean = verdict.mean_weight();
    row.tracked_points = static_cast<std::size_t>(result.tracked_points);
    row.extraction_ms = result.ms.extraction;
    row.correspondence_ms = verdict.correspondence_ms;
    row.filters_ms = std::max(0.0, result.ms.judge - verdict.correspondence_ms);
    row.tracking_ms = result.ms.tracking + result.ms.mapping;
    row.cpu_ms = result.cpu_ms.total(), row.cpu_judge_ms = result.cpu_ms.judge;
    const auto take = [&row](const std::vector<std::string>& notes, auto& counts) {
      for (const std::string& note : notes) {
        row.note += (row.note.empty() ? "" : "; ") + note;
        counts.add(note);
      }
    };
    take(verdict.stage_notes, stage_notes_);
    take(verdict.notes, notes_);
    if (judged_by_truth_) classify(i, verdict, row.truth);
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

  void classify(std::size_t i, const FrameVerdict& verdict, eval::Classification& counts) const {
    const cv::Mat truth = sequence_.load_truth(i);
    for (const MarkedFeature& f : verdict.features)
      counts.add(eval::truth_at(truth, f.pixel), f.decision == Vote::Dynamic);
  }

  OverlayFrame picture_of(const io::SequenceFrame& frame, const odometry::SemanticInputs& inputs,
                          const FrameRow& row) const {
    OverlayFrame picture;
    picture.colour = frame.colour;
    picture.title = fmt::format("{}   {}   frame {} of {}   {}", summary_.pipeline, summary_.sequence,
                                row.index, sequence_.size(), row.state);
    if (inputs.detections)
      picture.detections.assign(inputs.detections->detections.begin(), inputs.detections->detections.end());
    if (inputs.mask && inputs.mask->labels.size() == frame.colour.size()) picture.mask = inputs.mask->labels;
    return picture;
  }

  // With the frames' own timestamps.
  io::Trajectory trajectory() {
    std::map<double, double> own_s;
    for (const std::size_t i : order_) own_s[played_s(i)] = sequence_.timestamp_s(i);
    io::Trajectory estimate = odometry_.trajectory();
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
  std::optional<io::Trajectory> ground_truth_;
  std::optional<SemanticFeed> feed_;
  std::optional<std::chrono::steady_clock::time_point> began_;
  std::optional<io::PoseLookup> poses_;  ///< poses of another SLAM
  std::optional<MapRun> map_;
  std::optional<RunOutput> output_;
  report::RunRecord* record_;  ///< for the caller, or null
  std::optional<report::RunRecorder> recorder_;
  FrameStatistics statistics_;
  NoteCounts notes_, stage_notes_;
  Summary summary_;
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
