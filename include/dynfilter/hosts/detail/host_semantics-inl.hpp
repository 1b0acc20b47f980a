// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/host_semantics.hpp>

#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE void HostSemantics::set_detections(std::vector<Detection> detections,
                                                    std::int64_t frame_id) {
  for (Detection& detection : detections) own_pixels(detection.mask);
  next_.detections = std::move(detections);
  next_.detections_frame_id = frame_id;
}

DYNFILTER_INLINE void HostSemantics::set_mask(const cv::Mat& labels, std::int64_t frame_id) {
  keep_copy(labels, next_.mask.labels);
  next_.mask.frame_id = frame_id;
  next_.has_mask = true;
}

DYNFILTER_INLINE void HostSemantics::begin(const SemanticImage& image) {
  std::swap(now_, next_);
  next_.clear();
  result_.reset();
  if (!runner_) return;
  runner_->submit(image);
  result_ = runner_->latest();
}

DYNFILTER_INLINE void HostSemantics::add_to(FrameView& view) const {
  if (result_ && result_->detections)
    view.detections = DetectionInput{result_->frame_id, *result_->detections};
  if (result_ && result_->labels) view.mask = MaskInput{result_->frame_id, *result_->labels};
  if (now_.detections) view.detections = DetectionInput{now_.detections_frame_id, *now_.detections};
  if (now_.has_mask) view.mask = now_.mask;
}

DYNFILTER_INLINE void HostSemantics::reset() {
  now_.clear();
  result_.reset();
  if (runner_) runner_->reset();
}

DYNFILTER_INLINE std::string HostSemantics::take_error() {
  if (!runner_ || told_) return "";
  const RunnerStatus status = runner_->status();
  if (status.failed == 0 && !status.abandoned) return "";
  told_ = true;
  return status.last_error;
}

}  // namespace dynfilter
