// SPDX-License-Identifier: MIT
#include "mask_run.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/dense/dense_mask.hpp>
#include <dynfilter/detectors/image_encoder.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <dynfilter/hosts/host_mask.hpp>
#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>
#include <utility>

#include "command_registry.hpp"
#include "interruption.hpp"
#include "io/sequence.hpp"
#include "mask_output.hpp"
#include "masks/instances.hpp"
#include "masks/mask_form.hpp"
#include "masks/object_motion.hpp"
#include "masks/object_tracker.hpp"
#include "odometry/odometry.hpp"
#include "pipeline_judge.hpp"
#include "run_input.hpp"
#include "semantic_source.hpp"

namespace dynfilter::command {
namespace {

/// More features than a tracker needs: they outline what moves.
constexpr int kFeatures = 2000;

bool within(const std::filesystem::path& inner, const std::filesystem::path& outer) {
  const auto [end, _] = std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end());
  return end == outer.end();
}

/// Results beside images that are read would be taken for images the next time.
void check_apart(const std::string& input, const std::string& out) {
  std::error_code error;
  const auto resolved = [&](const std::string& path) {
    std::filesystem::path whole = std::filesystem::weakly_canonical(std::filesystem::absolute(path), error);
    return whole.has_filename() ? whole : whole.parent_path();
  };
  if (!std::filesystem::exists(input, error)) return;  // opening it says so
  const std::filesystem::path from = resolved(input), to = resolved(out);
  if (within(to, from)) throw IoError(out + ": is in the input " + input + ": choose another OUT");
  if (within(from, to)) throw IoError(out + ": contains the input " + input + ": choose another OUT");
}

RunOptions checked(const MaskOptions& options) {
  check_apart(options.run.sequence, options.run.out);
  if (options.shape == "objects" && options.run.detector_mode != "sync")
    throw Error("--shape objects needs the detector's answer for each image: --detector-mode sync");
  return options.run;
}

odometry::OdometryOptions dense_options(odometry::Sensor sensor, bool weights, bool poses) {
  odometry::OdometryOptions options = odometry_options(sensor, weights, poses);
  options.extractor.features = kFeatures;
  return options;
}

/// A mover that the floor restored for the tracker's sake is still one.
Vote vote_of(const MarkedFeature& feature) {
  return feature.restored ? Vote::Dynamic : feature.decision;
}

class MaskRun {
 public:
  explicit MaskRun(const MaskOptions& options)
      : options_(options),
        run_(checked(options)),
        output_(run_, *masks::mask_form(options.tool)),
        truth_(std::make_shared<OracleLabels>()),
        judge_(named_pipeline(run_.pipeline, command_registry(run_.plugins, truth_))),
        sequence_(open_sequence(run_)),
        order_((check_stream(run_, sequence_), playing_order(run_, sequence_.size()))),
        sensor_(chosen_sensor(run_, sequence_)),
        odometry_(sequence_.camera(),
                  dense_options(sensor_, !run_.no_weights, !sequence_.camera_is_guessed()), &judge_) {
    check_input();
    summary_.sequence = sequence_.name(), summary_.pipeline = judge_.pipeline().name();
    summary_.tool = options.tool, summary_.shape = options.shape, summary_.folder = run_.out;
    summary_.images = images_folder();
    output_.set_frames(order_.size());
    feed_.emplace(semantic_feed(run_, sequence_, order_, summary_.notes));
    if (run_.truth) summary_.truth.emplace();
  }

  MaskSummary run(const std::function<void(std::size_t, std::size_t)>& progress) {
    const std::size_t steps = objects() ? 2 * order_.size() : order_.size();
    for (std::size_t k = 0; k < order_.size(); ++k) {
      progress(k, steps);
      if (!play(k)) order_.resize(k);  // a video has fewer frames than it says
    }
    if (order_.empty()) throw IoError(run_.sequence + ": no frame could be decoded");
    summary_.frames = order_.size();
    const std::vector<std::string> notes = sequence_.notes();  // of a video they are complete now
    summary_.notes.insert(summary_.notes.begin(), notes.begin(), notes.end());
    check_detector();
    if (objects()) {
      write_objects([&](std::size_t k) { progress(order_.size() + k, steps); });
    }
    if (masked_.pixels > 0)
      summary_.masked_share = static_cast<double>(masked_.set) / static_cast<double>(masked_.pixels);
    progress(steps, steps);
    if (summary_.failure.empty()) output_.finish(sequence_, order_, summary_);
    return summary_;
  }

 private:
  bool objects() const { return options_.shape == "objects"; }

  /// Where the images are that the masks are for. Those of a video are written, too.
  std::string images_folder() const {
    if (sequence_.is_stream()) return (std::filesystem::path(run_.out) / MaskOutput::kImages).string();
    const std::filesystem::path first = sequence_.image_file(order_.front());
    return (sequence_.folder() / first.parent_path()).lexically_normal().string();
  }

  void check_input() const {
    require_labels(judge_.pipeline(), sequence_.has_labels(), run_.sequence);
    if (run_.truth && !sequence_.has_labels())
      throw IoError(run_.sequence +
                    ": has no labels, which --truth needs: only sequences that synth wrote have");
    if (sequence_.scale() < 1) throw Error("--scale: masks have the size of the images; leave it out");
    if (sequence_.rectifies())
      throw IoError(
          run_.sequence +
          ": its images are rectified when read, and masks would not fit the files: give the camera "
          "of the files with --camera");
    if (objects() && !has_semantics(run_, sequence_))
      throw IoError("--shape objects: " + run_.sequence +
                    " has no masks of objects: give --detector with one that makes masks, or --masks");
  }

  /// False where a video or a camera has ended.
  bool play(std::size_t k) {
    std::optional<io::SequenceFrame> read = sequence_.read(order_[k]);
    if (!read) return false;
    io::SequenceFrame& frame = *read;
    if (sequence_.is_stream()) output_.add_image(sequence_.image_file(order_[k]), frame.colour);
    if (sensor_ != odometry::Sensor::Rgbd) frame.depth = cv::Mat();  // as in `run`
    if (uses_stage(judge_.pipeline(), OracleFilter::kName)) truth_->labels = sequence_.load_labels(order_[k]);
    const odometry::SemanticInputs inputs = feed_->next(static_cast<std::int64_t>(k), frame);
    odometry_.process(frame, inputs);
    if (objects())
      see_objects(k, frame);
    else
      write(k, feature_mask(frame), {}, frame.colour);
    return true;
  }

  std::vector<masks::JudgedFeature> features() const {
    const std::vector<MarkedFeature>& judged = judge_.record().features;
    const std::vector<cv::KeyPoint>& keypoints = odometry_.extracted();
    std::vector<masks::JudgedFeature> all;
    for (std::size_t i = 0; i < judged.size() && i < keypoints.size(); ++i)
      all.push_back({keypoints[i], vote_of(judged[i])});
    return all;
  }

  /// What a host would get of the same verdict.
  const cv::Mat& feature_mask(const io::SequenceFrame& frame) {
    Verdict verdict;
    std::vector<cv::KeyPoint> keypoints;
    for (const masks::JudgedFeature& feature : features())
      keypoints.push_back(feature.keypoint), verdict.decision.push_back(feature.decision);
    const cv::Size size = frame.grey.size();
    if (options_.shape == "features")
      return dense_.image(keypoints, verdict, size, {frame.depth, frame.depth_unit_m});
    return frame.depth.empty() ? discs_.image(keypoints, verdict, size)
                               : discs_.rgbd_image(keypoints, verdict, size);
  }

  void see_objects(std::size_t k, const io::SequenceFrame& frame) {
    const SemanticResult* result = feed_->result();
    masks::TrackedImage image{k, frame.timestamp_s, frame.colour, frame.grey, {}, features()};
    if (result != nullptr && result->frame_id == static_cast<std::int64_t>(k)) {
      masks::Semantics seen;
      if (result->detections) seen.detections = &*result->detections;
      if (result->labels) seen.labels = *result->labels;
      seen.depth = frame.depth, seen.depth_unit_m = frame.depth_unit_m;
      image.instances = masks::instances_of(seen, frame.grey.size());
      boxes_ += result->detections ? result->detections->size() : 0;
      instances_ += image.instances.size();
    }
    size_ = frame.grey.size();
    if (output_.wants_picture(k)) pictures_[k] = io::encode_jpeg(frame.colour);
    tracker_.add(image);
  }

  void check_detector() {
    const DetectorSummary detector = feed_->summary();
    if (detector.failed > 0 && detector.results + detector.silent == 0) {
      summary_.failure = "the detector failed on every image: " + detector.last_error;
    } else if (detector.failed > 0) {
      summary_.notes.push_back(fmt::format("the detector failed on {} of {} images: {}", detector.failed,
                                           detector.looked_at, detector.last_error));
    }
    if (objects() && boxes_ > 0 && instances_ == 0)
      throw IoError(
          "--shape objects: there are boxes but no masks, and no depth images to make masks from: "
          "give --detector with one that makes masks (yolov8_seg_onnx), or --masks");
  }

  template <class Step>
  void write_objects(const Step& step) {
    struct Shown {
      const masks::RunMask* mask;
      bool masked;
    };
    const std::vector<masks::ObjectTrack> tracks = tracker_.finish();
    std::vector<std::vector<Shown>> shown(order_.size());
    for (const masks::ObjectTrack& track : tracks) {
      const std::vector<bool> masked = masks::masked_in(track, options_.until_static_s);
      for (std::size_t i = 0; i < masked.size(); ++i)
        shown[track.sightings[i].frame].push_back({&track.sightings[i].mask, masked[i]});
      summary_.objects.push_back({track.class_name, track.sightings.front().time_s,
                                  track.sightings.back().time_s, masked.size(),
                                  static_cast<std::size_t>(std::count(masked.begin(), masked.end(), true))});
    }
    cv::Mat moving, standing;
    for (std::size_t k = 0; k < order_.size(); ++k) {
      step(k);
      moving = cv::Mat::zeros(size_, CV_8UC1), standing = cv::Mat::zeros(size_, CV_8UC1);
      for (const Shown& object : shown[k]) object.mask->paint(object.masked ? moving : standing);
      const int width = 2 * options_.grow_px + 1;
      cv::dilate(moving, moving, cv::getStructuringElement(cv::MORPH_ELLIPSE, {width, width}));
      write(k, moving, standing, picture_at(k));
    }
  }

  cv::Mat picture_at(std::size_t k) const {
    const auto kept = pictures_.find(k);
    return kept == pictures_.end() ? cv::Mat() : io::detail::decode_image(kept->second, io::ImageAs::Colour);
  }

  /// `standing`: objects that are not masked, for the picture.
  void write(std::size_t k, const cv::Mat& moving, const cv::Mat& standing, const cv::Mat& colour) {
    masked_.set += cv::countNonZero(moving), masked_.pixels += static_cast<std::int64_t>(moving.total());
    if (summary_.truth) summary_.truth->add(moving, sequence_.load_labels(order_[k]));
    output_.add(k, sequence_.image_file(order_[k]), moving, standing, colour);
  }

  struct Masked {
    std::int64_t set = 0, pixels = 0;
  };

  MaskOptions options_;
  RunOptions run_;
  MaskOutput output_;  ///< first: the rest may take long to open
  std::shared_ptr<OracleLabels> truth_;
  PipelineJudge judge_;
  io::Sequence sequence_;
  std::vector<std::size_t> order_;
  odometry::Sensor sensor_;
  odometry::Odometry odometry_;
  std::optional<SemanticFeed> feed_;
  DenseMask dense_;
  HostMask discs_{MaskPolarity::NonzeroDrops};
  masks::ObjectTracker tracker_;
  cv::Size size_;
  std::map<std::size_t, std::vector<std::uint8_t>> pictures_;  ///< images for overlay/, compressed
  std::size_t boxes_ = 0, instances_ = 0;
  Masked masked_;
  MaskSummary summary_;
};

}  // namespace

std::size_t MaskSummary::movers() const {
  return static_cast<std::size_t>(
      std::count_if(objects.begin(), objects.end(), [](const MaskedObject& o) { return o.masked > 0; }));
}

MaskSummary run_masks(const MaskOptions& options,
                      const std::function<void(std::size_t, std::size_t)>& progress) {
  cv::setNumThreads(options.run.threads);
  return MaskRun(options).run(progress);
}

}  // namespace dynfilter::command
