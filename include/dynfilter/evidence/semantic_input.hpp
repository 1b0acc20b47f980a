// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// What a semantic stage does with the features of a potentially moving object.
enum class SemanticRole {
  Prior,  ///< marks suspects: excluded from model fitting and judged more strictly, but not dynamic
  Reject  ///< votes dynamic
};

template <class P>
Field<P> semantic_role(const char* name, SemanticRole P::*member) {
  return choice(name, member, {{"prior", SemanticRole::Prior}, {"reject", SemanticRole::Reject}},
                "prior marks suspects for later stages; reject votes dynamic");
}

/// A filter on boxes or masks that has a role. Messages about missing inputs depend on it.
class SemanticFilter {
 public:
  virtual SemanticRole role() const = 0;  ///< what it does with features in a box or on a mask

 protected:
  ~SemanticFilter() = default;
};

/// The detections that a stage uses.
struct DetectionFilter {
  std::vector<std::string> classes;         ///< empty: all classes
  std::vector<std::string> except_classes;  ///< excluded classes
  double min_score = 0;

  /// Also false for boxes that are empty, inverted or not finite, and for scores that are not finite.
  bool accepts(const Detection& detection) const;
};

/// Boxes or masks of the current frame or of an older one. Older results are carried to this frame along the
/// frame-to-frame motion of the features. If the motion history has a gap, features are matched back to the
/// frame of the result instead. Gaps occur after a reset, or if the host's matches skip frames. `usable` is
/// false if the result is too old or neither way works. A note in the votes gives the reason.
class LateResult {
 public:
  /// Boxes of the frame.
  static LateResult boxes(const Evidence& evidence, int max_age_frames, Votes& votes,
                          const char* what = "boxes");
  /// The mask of the frame.
  static LateResult mask(const Evidence& evidence, int max_age_frames, Votes& votes);
  /// Matched back only, never carried. For filters that learn once from each result.
  static LateResult matched_mask(const Evidence& evidence, std::int64_t frame_id, int max_age_frames,
                                 Votes& votes);
  /// Number of earlier frames kept for matching back. Carrying needs none.
  static int history_frames(int max_age_frames) { return std::min(max_age_frames, 5); }

  /// Boxes, in pixels of the result's frame.
  Span<const Detection> detections() const { return detections_; }
  const cv::Mat& labels() const { return labels_; }  ///< mask, CV_8UC1; empty: none

  bool usable() const { return usable_; }  ///< whether detections() and labels() hold a result
  /// True if feature i can be compared with detections() and labels().
  bool found(std::size_t i) const { return match_ == nullptr || match_->found(i); }
  /// Position of feature i in the frame of the result.
  /// A feature without a match is moved back by `flow`, the flow of its neighbours.
  cv::Point2f then_px(std::size_t i, const cv::Point2f& flow = {0, 0}) const;
  /// Median flow to this frame of the features for which `inside(position then)` is true. (0, 0) without any.
  template <class Inside>
  cv::Point2f median_flow(const Inside& inside, std::vector<float>& x, std::vector<float>& y) const {
    x.clear();
    y.clear();
    if (match_ == nullptr) return {0, 0};
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      if (!match_->found(i) || !inside(match_->correspondences.reference_px[i])) continue;
      x.push_back(pixels_[i].x - match_->correspondences.reference_px[i].x);
      y.push_back(pixels_[i].y - match_->correspondences.reference_px[i].y);
    }
    if (x.empty()) return {0, 0};
    return {median_in_place(x), median_in_place(y)};
  }

 private:
  LateResult(const Evidence& evidence, Votes& votes)
      : evidence_(evidence), pixels_(evidence.pixels()), votes_(votes) {}

  /// Also sets age_note_.
  bool of_older_frame(std::int64_t frame_id, int max_age_frames, const char* what);
  void match_back(std::int64_t frame_id, const char* what);
  template <class T>
  void use_carried(const T& carried, T& own);

  const Evidence& evidence_;
  const std::vector<cv::Point2f>& pixels_;  ///< of the evidence
  Votes& votes_;
  const Match* match_ = nullptr;
  Span<const Detection> detections_;
  cv::Mat labels_;
  std::string age_note_;
  bool usable_ = true;
};

inline bool DetectionFilter::accepts(const Detection& detection) const {
  const cv::Rect2f& box = detection.box;
  if (!(box.width > 0) || !(box.height > 0) || !std::isfinite(box.x + box.width) ||
      !std::isfinite(box.y + box.height) || !(static_cast<double>(detection.score) >= min_score))
    return false;
  const auto listed = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), detection.class_name) != names.end();
  };
  return (classes.empty() || listed(classes)) && !listed(except_classes);
}

inline LateResult LateResult::boxes(const Evidence& evidence, int max_age_frames, Votes& votes,
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

inline LateResult LateResult::mask(const Evidence& evidence, int max_age_frames, Votes& votes) {
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

inline LateResult LateResult::matched_mask(const Evidence& evidence, std::int64_t frame_id,
                                           int max_age_frames, Votes& votes) {
  LateResult late(evidence, votes);
  late.labels_ = evidence.frame().mask->labels;
  if (late.of_older_frame(frame_id, max_age_frames, "masks")) late.match_back(frame_id, "masks");
  return late;
}

inline cv::Point2f LateResult::then_px(std::size_t i, const cv::Point2f& flow) const {
  if (match_ == nullptr) return pixels_[i];
  return match_->found(i) ? match_->correspondences.reference_px[i] : pixels_[i] - flow;
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
