// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/semantic_mask.hpp>

#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<SemanticMaskParams>& SemanticMaskParams::fields() {
  using P = SemanticMaskParams;
  static const FieldTable<P> table{
      semantic_role("role", &P::role),
      choice("source", &P::source, {{"mask", MaskSource::Mask}, {"instances", MaskSource::Instances}},
             "mask uses the frame's mask or label image; instances uses the masks of its detections"),
      integers("labels", &P::labels, {0, 255}, "labels that may move, for source mask; empty: all except 0"),
      words("classes", &P::classes,
            "names of the classes that may move, for source instances; empty: all classes"),
      real("min_score", &P::min_score, "", {0, 1},
           "smallest score of a detection that is used, for source instances"),
      real("dilate_px", &P::dilate_px, "px", {0, 200},
           "distance from the mask up to which a feature counts as on it (DynaSLAM: 15)"),
      integer("max_age_frames", &P::max_age_frames, "frames", {0, 100},
              "largest age of masks; masks of an older frame are carried to this one up to this age"),
      choice("off_mask", &P::off_mask, {{"unknown", OffMask::Unknown}, {"static", OffMask::Static}},
             "vote for features off the mask"),
  };
  return table;
}

DYNFILTER_INLINE SemanticMaskFilter::SemanticMaskFilter(Params params) : params_(std::move(params)) {
  check_parameters(params_, kName);
}

DYNFILTER_INLINE void SemanticMaskFilter::apply(const Evidence& evidence, Votes& votes) {
  if (params_.source == MaskSource::Mask) {
    const LateResult late = LateResult::mask(evidence, params_.max_age_frames, votes);
    if (!late.usable()) return;
    clear(evidence, late, votes);
    judge(evidence, MaskLookup(late.labels(), image_size(evidence.frame()), params_.labels), late, 1, votes);
  } else {
    judge_instances(evidence, votes);
  }
}

inline void SemanticMaskFilter::judge_instances(const Evidence& evidence, Votes& votes) {
  const LateResult late = LateResult::boxes(evidence, params_.max_age_frames, votes, "masks");
  if (!late.usable()) return;
  const DetectionFilter filter{params_.classes, {}, params_.min_score};
  bool any = late.detections().empty();
  for (const Detection& detection : late.detections()) any = any || !detection.mask.empty();
  if (!any) return votes.note("the detections have no masks");
  clear(evidence, late, votes);
  for (const Detection& detection : late.detections()) {
    if (!filter.wants(detection)) continue;
    const MaskLookup mask(detection.mask, image_size(evidence.frame()));
    if (!mask.empty())
      judge(evidence, mask, late, detection.score, votes);
    else
      votes.note("a detection without a usable mask");
  }
}

inline void SemanticMaskFilter::clear(const Evidence& evidence, const LateResult& late, Votes& votes) const {
  if (params_.off_mask == OffMask::Unknown) return;
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (late.found(i)) votes.cast(i, Vote::Static);
}

inline void SemanticMaskFilter::judge(const Evidence& evidence, const MaskLookup& mask,
                                      const LateResult& late, float score, Votes& votes) {
  const cv::Point2f flow =
      late.median_flow([&](const cv::Point2f& px) { return mask.at(px); }, flow_x_, flow_y_);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const cv::Point2f then = late.then_px(i, flow);
    const bool on = mask.at(then);
    if (!on && !mask.near(then, params_.dilate_px)) continue;
    if (params_.role == SemanticRole::Prior)
      votes.mark_prior(i);
    else if (const float suspicion = on ? score : score * kMarginScore;
             votes[i] != Vote::Dynamic || votes.suspicion(i) < suspicion)
      votes.cast(i, Vote::Dynamic, suspicion);
  }
}

}  // namespace dynfilter
