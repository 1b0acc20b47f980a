// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/pipeline/frame_observer.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/recorder/recording.hpp>
#include <dynfilter/version.hpp>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frame_record.hpp"
#include "image_writer.hpp"
#include "parameter_texts.hpp"
#include "record_bytes.hpp"
#include "record_file.hpp"

namespace dynfilter::recorder {

namespace {

/// Writes places of images into a frame's record, and hands the images on.
class PlacedImages {
 public:
  PlacedImages(ImageWriter& writer, bool kept) : writer_(writer), kept_(kept) {}

  template <class Archive>
  void transfer(Archive& archive, std::uint32_t slot, const cv::Mat& image) const {
    ImagePlace place;
    if (!image.empty()) place.kind = ImagePlace::Kind::LeftOut;
    if (!image.empty() && kept_) place = writer_.place(slot, image);
    place.transfer(archive);
  }

 private:
  ImageWriter& writer_;
  bool kept_;
};

std::size_t image_bytes(const FrameView& frame) {
  const auto bytes = [](const cv::Mat& image) { return image.total() * image.elemSize(); };
  std::size_t sum = bytes(frame.grey) + bytes(frame.right_grey) + bytes(frame.depth);
  if (frame.mask) sum += bytes(frame.mask->labels);
  if (frame.detections)
    for (const Detection& detection : frame.detections->detections) sum += bytes(detection.mask);
  return sum;
}

/// Arrays are written by the caller's thread before the frame is judged, so that a crash leaves them. Images
/// follow in a record of their own.
class FlightRecorder final : public FrameObserver {
 public:
  FlightRecorder(const std::string& file, const RecordingParams& params)
      : params_(params), file_(file, std::uint64_t{1'000'000} * static_cast<std::uint64_t>(params.max_mb)) {
    images_.emplace(file_, params.waits);
  }
  ~FlightRecorder() override {
    images_.reset();  // writes what waits
    const char* why = file_.state() == RecordFile::State::Full ? "full" : "closed";
    guarded([&] {
      ByteWriter bytes(buffer_.raw);
      bytes.text(why);
      bytes.number(std::uint64_t{left_out_});
      file_.append(RecordKind::End, call_, buffer_);
    });
  }

  void begin(const PipelineConfig& config) override {
    guarded([&] {
      const RecordedPipeline head{DYNFILTER_VERSION, config.name, config.yaml, parameter_texts(config)};
      ByteWriter bytes(buffer_.raw);
      transfer_head(bytes, head);
      file_.append(RecordKind::Pipeline, call_, buffer_);
    });
  }

  void frame(const FrameView& frame, CallPoint point, const HostLimits& limits) override {
    if (file_.state() != RecordFile::State::Open) return;
    guarded([&] {
      ++call_;
      const bool kept = images_->begin(call_, image_bytes(frame)) && params_.images;
      const bool lacks = !kept && image_bytes(frame) > 0;
      left_out_ += lacks ? 1 : 0;
      if (lacks && params_.images)
        note_ = "flight recorder: the images of this frame are left out, too many wait to be written";
      ByteWriter bytes(buffer_.raw);
      transfer_choice(bytes, point, 3);
      bytes.number(std::int32_t{limits.min_features});
      const PlacedImages placed(*images_, kept);
      transfer_frame(bytes, frame, placed);
      if (file_.append(RecordKind::Frame, call_, buffer_)) images_->end();
    });
  }

  void judged(Verdict& verdict) override {
    if (told_end_) return;
    guarded([&] {
      if (file_.state() == RecordFile::State::Open) {
        ByteWriter bytes(buffer_.raw);
        transfer_verdict(bytes, std::as_const(verdict));
        file_.append(RecordKind::Verdict, call_, buffer_);
      }
      if (file_.state() != RecordFile::State::Open) note_ = end_note(), told_end_ = true;
      if (!note_.empty()) verdict.report.notes.push_back(std::exchange(note_, ""));
    });
  }

  void reset() override {
    write_event(RecordKind::Reset, [](ByteWriter&) {});
  }

  void lost() override {
    write_event(RecordKind::Lost, [](ByteWriter&) {});
  }

  void pose(std::int64_t frame_id, const Pose& T_world_camera, PoseProvenance provenance,
            const HostTracking& tracking) override {
    write_event(RecordKind::Pose, [&](ByteWriter& bytes) {
      bytes.number(frame_id);
      transfer_pose(bytes, T_world_camera);
      transfer_choice(bytes, provenance, 4);
      transfer_tracking(bytes, tracking);
    });
  }

 private:
  template <class Content>
  void write_event(RecordKind kind, const Content& content) {
    if (file_.state() != RecordFile::State::Open) return;
    guarded([&] {
      ByteWriter bytes(buffer_.raw);
      content(bytes);
      file_.append(kind, call_, buffer_);
    });
  }

  std::string end_note() const {
    return "flight recorder: " + file_.path() +
           (file_.state() == RecordFile::State::Full
                ? " is full with " + std::to_string(params_.max_mb) + " MB and ends here"
                : " cannot be written any more and ends here");
  }

  /// A recorder must not disturb what it records.
  template <class Work>
  static void guarded(const Work& work) noexcept {
    try {
      work();
    } catch (...) {  // no memory
    }
  }

  RecordingParams params_;
  RecordFile file_;
  std::optional<ImageWriter> images_;
  RecordBuffer buffer_;
  std::uint64_t call_ = 0, left_out_ = 0;
  std::string note_;
  bool told_end_ = false;
};

}  // namespace

}  // namespace dynfilter::recorder

namespace dynfilter {

std::shared_ptr<FrameObserver> open_recording(const std::string& file, const RecordingParams& params) {
  if (params.max_mb < 1) throw IoError(file + ": a recording has at least 1 MB");
  return std::make_shared<recorder::FlightRecorder>(file, params);
}

}  // namespace dynfilter
