// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/semantic_input.hpp>

#include <cmath>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/limits.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE bool DetectionFilter::accepts(const Detection& detection) const {
  const cv::Rect2f& box = detection.box;
  if (!(box.width > 0) || !(box.height > 0) || !std::isfinite(box.x + box.width) ||
      !std::isfinite(box.y + box.height) || !(static_cast<double>(detection.score) >= min_score))
    return false;
  const auto listed = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), detection.class_name) != names.end();
  };
  return (classes.empty() || listed(classes)) && !listed(except_classes);
}

DYNFILTER_INLINE LateResult LateResult::boxes(const Evidence& evidence, int max_age_frames, Votes& votes,
                                              const char* what) {
  const DetectionInput& input = *evidence.frame().detections;
  LateResult late(evidence, votes);
  late.detections_ = input.detections;
  if (!late.of_older_frame(input.frame_id, max_age_frames, what)) return late;
  const std::vector<Detection>* carried = evidence.carried_boxes(max_age_frames);
  if (carried != nullptr)
    late.use_carried(Span<const Detection>(*carried), late.detections_);
  else
    late.match_back(input.frame_id, what);
  return late;
}

DYNFILTER_INLINE LateResult LateResult::mask(const Evidence& evidence, int max_age_frames, Votes& votes) {
  const MaskInput& input = *evidence.frame().mask;
  LateResult late(evidence, votes);
  late.labels_ = input.labels;
  if (!late.of_older_frame(input.frame_id, max_age_frames, "masks")) return late;
  const cv::Mat* carried = evidence.carried_labels();
  if (carried != nullptr)
    late.use_carried(*carried, late.labels_);
  else
    late.match_back(input.frame_id, "masks");
  return late;
}

DYNFILTER_INLINE LateResult LateResult::matched_mask(const Evidence& evidence, std::int64_t frame_id,
                                                     int max_age_frames, Votes& votes) {
  LateResult late(evidence, votes);
  late.labels_ = evidence.frame().mask->labels;
  if (late.of_older_frame(frame_id, max_age_frames, "masks")) late.match_back(frame_id, "masks");
  return late;
}

DYNFILTER_INLINE cv::Point2f LateResult::then_px(std::size_t i, const cv::Point2f& flow) const {
  if (match_ == nullptr) return evidence_.pixels()[i];
  return match_->found(i) ? match_->correspondences.reference_px[i] : evidence_.pixels()[i] - flow;
}

inline bool LateResult::of_older_frame(std::int64_t frame_id, int max_age_frames, const char* what) {
  if (frame_id < 0 || frame_id == evidence_.frame().id) return false;
  const std::int64_t age = id_gap(evidence_.frame().id, frame_id);
  usable_ = age >= 0 && age <= max_age_frames;
  if (!usable_) votes_.note(what, " of frame ", frame_id, " are too old");
  age_note_ = std::string(what) + " are " + std::to_string(age) + " frames late";
  return usable_;
}

inline void LateResult::match_back(std::int64_t frame_id, const char* what) {
  match_ = &evidence_.match_with(frame_id);
  usable_ = match_->reference != nullptr;
  votes_.note(usable_ ? age_note_
                      : std::string(what) + " of frame " + std::to_string(frame_id) + ", which is not kept");
}

template <class T>
void LateResult::use_carried(const T& carried, T& own) {
  own = carried;
  votes_.note(age_note_);
}

}  // namespace dynfilter
