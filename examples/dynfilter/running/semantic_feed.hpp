// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/runner.hpp>

#include <algorithm>
#include <cstdint>
#include <dynfilter/detectors/detections.hpp>
#include <dynfilter/semantic/async_runner.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "eval/statistics.hpp"
#include "io/sequence.hpp"
#include "odometry/track_result.hpp"
#include "run_input.hpp"
#include "run_summary.hpp"

namespace dynfilter::command {

/// A provider for the boxes and masks beside a sequence, by frame id.
/// Frame ids count the played frames.
class SequenceFiles final : public SemanticProvider {
 public:
  SequenceFiles(std::optional<io::DetectionTrack> boxes, MaskFolder masks, std::vector<std::size_t> order,
                const io::Sequence& sequence)
      : boxes_(std::move(boxes)), masks_(std::move(masks)), order_(std::move(order)), sequence_(sequence) {}

  std::string name() const override { return "files"; }
  std::optional<SemanticResult> infer(const SemanticImage& image) override {
    const std::size_t i = order_[static_cast<std::size_t>(image.frame_id)];
    SemanticResult result;
    if (const std::vector<Detection>* boxes = boxes_ ? boxes_->at(sequence_.timestamp_s(i)) : nullptr)
      result.detections = *boxes;
    if (const std::optional<MaskInput> mask = masks_.load(i)) result.labels = mask->labels;
    if (!result.detections && !result.labels) return std::nullopt;
    return result;
  }

 private:
  std::optional<io::DetectionTrack> boxes_;
  MaskFolder masks_;
  std::vector<std::size_t> order_;
  io::Sequence sequence_;  ///< for the stamps; a video is shared, not copied
};

/// Feeds results of a provider to the odometry, with the delay of the mode.
class SemanticFeed {
 public:
  /// `is_files`: errors are then about the user's input, not about a detector.
  SemanticFeed(std::unique_ptr<SemanticProvider> provider, const std::string& mode, bool is_files)
      : runner_(make_runner(std::move(provider), parse_runner_mode(mode))), is_files_(is_files) {
    summary_.mode = mode;
  }

  /// Submits the next frame and returns its semantic inputs, valid until the next call.
  odometry::SemanticInputs next(std::int64_t frame_id, const io::SequenceFrame& frame) {
    SemanticImage image;
    image.frame_id = frame_id;
    image.timestamp_s = frame.timestamp_s;
    image.pixels = frame.colour;
    image.depth = frame.depth;
    image.depth_unit_m = frame.depth_unit_m;
    runner_->submit(image);
    const RunnerStatus status = runner_->status();
    if (is_files_ && status.failed > 0) throw IoError(status.last_error);
    result_ = runner_->latest();
    odometry::SemanticInputs inputs;
    if (!result_) return inputs;
    if (result_->detections) inputs.detections = DetectionInput{result_->frame_id, *result_->detections};
    if (result_->labels) inputs.mask = MaskInput{result_->frame_id, *result_->labels};
    ++ages_[frame_id - result_->frame_id];
    ++summary_.frames_with_result;
    return inputs;
  }

  /// The result that next() returned last.
  const SemanticResult* result() const { return result_.get(); }

  DetectorSummary summary() {
    const RunnerStatus status = runner_->status();
    summary_.looked_at = status.looked_at, summary_.skipped = status.skipped;
    summary_.results = status.results, summary_.failed = status.failed, summary_.silent = status.silent;
    summary_.abandoned = status.abandoned, summary_.last_error = status.last_error;
    summary_.age_median_frames = median_age();
    summary_.age_max_frames = ages_.empty() ? NAN : static_cast<double>(ages_.rbegin()->first);
    return summary_;
  }

 private:
  /// As eval::median(): of an even number the mean of the middle two.
  double median_age() const {
    const std::size_t n = summary_.frames_with_result;
    return n == 0 ? NAN : (age_at((n - 1) / 2) + age_at(n / 2)) / 2;
  }
  /// The k-th smallest.
  double age_at(std::size_t k) const {
    for (const auto& [age, frames] : ages_) {
      if (k < frames) return static_cast<double>(age);
      k -= frames;
    }
    return NAN;
  }

  std::unique_ptr<SemanticRunner> runner_;
  bool is_files_;
  SemanticRunner::Result result_;
  std::map<std::int64_t, std::size_t> ages_;  ///< age -> number of frames
  DetectorSummary summary_;
};

}  // namespace dynfilter::command
