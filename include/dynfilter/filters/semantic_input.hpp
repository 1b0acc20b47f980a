// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/context/context.hpp>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/parameters.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// What a semantic stage does with the features of a potentially moving object.
enum class SemanticRole {
  Prior,  ///< suspects: kept out of model fitting and judged more strictly, not dynamic for it
  Reject  ///< dynamic
};

template <class P>
Field<P> semantic_role(const char* name, SemanticRole P::*member) {
  return choice(name, member, {{"prior", SemanticRole::Prior}, {"reject", SemanticRole::Reject}},
                "prior: suspects for later stages; reject: dynamic");
}

/// Which detections a stage looks at.
struct DetectionFilter {
  std::vector<std::string> classes;         ///< empty: every class ...
  std::vector<std::string> except_classes;  ///< ... but these
  double min_score = 0;

  /// False too for boxes that are empty, inverted or not finite, and for scores that are not.
  bool wants(const Detection& detection) const {
    const cv::Rect2f& box = detection.box;
    if (!(box.width > 0) || !(box.height > 0) || !std::isfinite(box.x + box.width) ||
        !std::isfinite(box.y + box.height) || !(static_cast<double>(detection.score) >= min_score))
      return false;
    const auto listed = [&](const std::vector<std::string>& names) {
      return std::find(names.begin(), names.end(), detection.class_name) != names.end();
    };
    return (classes.empty() || listed(classes)) && !listed(except_classes);
  }
};

/// Boxes and masks come late. Where each feature was on the image that they were computed on: its own place
/// for a result of this frame, the match into that frame for an older one. `usable` is false when the result
/// is too old or its frame is not kept any more; a note says so.
class LateResult {
 public:
  LateResult(Context& context, std::int64_t frame_id, int max_age_frames, const char* what)
      : context_(context) {
    if (frame_id >= 0 && frame_id != context.frame().id) find(frame_id, max_age_frames, what);
  }

  bool usable() const { return usable_; }
  /// Found on that image: always, when it is this one.
  bool found(std::size_t i) const { return match_ == nullptr || match_->found(i); }
  /// Where feature i was then; one that was not found is taken back by `flow`, that of its neighbours.
  cv::Point2f then_px(std::size_t i, const cv::Point2f& flow = {0, 0}) const {
    if (match_ == nullptr) return context_.pixels()[i];
    return match_->found(i) ? match_->correspondences.reference_px[i] : context_.pixels()[i] - flow;
  }
  /// The median motion to this frame of the features that `inside` picks by their place then; (0, 0) without
  /// any.
  template <class Inside>
  cv::Point2f median_flow(const Inside& inside, std::vector<float>& x, std::vector<float>& y) const {
    x.clear();
    y.clear();
    if (match_ == nullptr) return {0, 0};
    for (std::size_t i = 0; i < context_.size(); ++i) {
      if (!match_->found(i) || !inside(match_->correspondences.reference_px[i])) continue;
      x.push_back(context_.pixels()[i].x - match_->correspondences.reference_px[i].x);
      y.push_back(context_.pixels()[i].y - match_->correspondences.reference_px[i].y);
    }
    return {median(x), median(y)};
  }

 private:
  void find(std::int64_t frame_id, int max_age_frames, const char* what) {
    const std::int64_t age = context_.frame().id - frame_id;
    const std::string name = std::string(what) + " of frame " + std::to_string(frame_id);
    usable_ = age >= 0 && age <= max_age_frames;
    if (!usable_) return context_.note(name + " are too old");
    match_ = &context_.match_with(frame_id);
    usable_ = match_->reference != nullptr;
    context_.note(usable_ ? std::string(what) + " are " + std::to_string(age) + " frames late"
                          : name + ", which is not kept");
  }
  static float median(std::vector<float>& values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }

  Context& context_;
  const Match* match_ = nullptr;
  bool usable_ = true;
};

}  // namespace dynfilter
