// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/semantic_box.hpp>

#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<SemanticBoxParams>& SemanticBoxParams::fields() {
  using P = SemanticBoxParams;
  static const FieldTable<P> table{
      semantic_role("role", &P::role),
      words("classes", &P::classes, "names of the classes that may move; empty: all classes"),
      real("min_score", &P::min_score, "", {0, 1}, "smallest score of a box that is used"),
      real("expand_px", &P::expand_px, "px", {0, 1000}, "margin added to each side of a box"),
      integer("max_age_frames", &P::max_age_frames, "frames", {0, 100},
              "largest age of boxes; boxes of an older frame are carried to this one up to this age"),
      box_refinement("refine", &P::refine),
      real("foreground_margin_m", &P::foreground_margin_m, "m", {0, 10},
           "depth margin behind the foreground's surface that still belongs to it"),
  };
  return table;
}

DYNFILTER_INLINE SemanticBoxFilter::SemanticBoxFilter(Params params)
    : params_(std::move(params)), wanted_{params_.classes, {}, params_.min_score} {
  check_parameters(params_, kName);
}

DYNFILTER_INLINE void SemanticBoxFilter::apply(const Evidence& evidence, Votes& votes) {
  const LateResult late = LateResult::boxes(evidence, params_.max_age_frames, votes);
  if (!late.usable()) return;
  for (const Detection& detection : late.detections())
    if (wanted_.wants(detection)) judge(evidence, detection, late, votes);
}

inline void SemanticBoxFilter::judge(const Evidence& evidence, const Detection& detection,
                                     const LateResult& late, Votes& votes) {
  const cv::Rect2f box = features_in_box(evidence, detection.box, params_.expand_px, late, scratch_, inside_);
  const double farthest_m =
      box_foreground_m(evidence, box, inside_, params_.refine, params_.foreground_margin_m, scratch_);
  for (const std::size_t i : inside_) {
    if (static_cast<double>(evidence.depths_m()[i]) > farthest_m) continue;
    if (params_.role == SemanticRole::Reject)
      votes.cast(i, Vote::Dynamic, detection.score);
    else
      votes.mark_prior(i);
  }
}

}  // namespace dynfilter
