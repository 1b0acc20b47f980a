// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// The semantic input with the mask.
enum class MaskSource {
  Mask,      ///< FrameView::mask
  Instances  ///< masks of the detections
};

struct SemanticMaskParams {
  SemanticRole role = SemanticRole::Prior;
  MaskSource source = MaskSource::Mask;
  std::vector<int> labels;
  std::vector<std::string> classes = moving_classes();
  /// Smallest score of a detection that is used, for source instances.
  static constexpr double kMinScore = 0.4;
  double dilate_px = 5;
  int max_age_frames = 30;

  static const FieldTable<SemanticMaskParams>& fields() {
    using P = SemanticMaskParams;
    static const FieldTable<P> table{
        semantic_role("role", &P::role),
        choice("source", &P::source, {{"mask", MaskSource::Mask}, {"instances", MaskSource::Instances}},
               "mask uses the frame's mask or label image; instances uses the masks of its detections"),
        integers("labels", &P::labels, {0, 255},
                 "labels that may move, for source mask; empty: all except 0"),
        words("classes", &P::classes,
              "names of the classes that may move, for source instances; empty: all classes"),
        real("dilate_px", &P::dilate_px, "px", {0, 200},
             "distance from the mask up to which a feature counts as on it (DynaSLAM: 15)"),
        integer("max_age_frames", &P::max_age_frames, "frames", {0, 100},
                "largest age of masks; masks of an older frame are carried to this one up to this age"),
    };
    return table;
  }
};

/// Rejects or marks features on the potentially moving pixels of a mask (DynaSLAM sec. III-B; also DS-SLAM
/// and DeS-SLAM).
///
/// Formula:  label(p) in `labels`, or such a pixel within dilate_px of p (a disc).
/// Needs:    a mask of any size, which is scaled to the image, or detections with instance masks.
///           Masks of an older frame need correspondences.
/// Votes:    role reject: Dynamic, with a lower score in the margin than on the mask. role prior: marks
///           suspects. Never Static, because networks miss objects.
/// Abstains: without a mask, if it is unusable, and if it is older than max_age_frames.
/// Blind to: classes that the network does not detect; whether the object moves at all.
/// State:    none; the pipeline carries late masks.
/// Cost:     about 0.1 us per feature without dilation and 1 us with 15 px.
///           Only the mask around each feature is read.
class SemanticMaskFilter final : public ParametricFilter<SemanticMaskFilter, SemanticMaskParams>,
                                 public SemanticFilter {
 public:
  using ParametricFilter::ParametricFilter;
  static constexpr const char* kName = "semantic_mask";
  static constexpr const char* kSummary = "features on a mask of objects that may move";

  Needs needs() const override {
    return {params_.source == MaskSource::Mask ? Input::Mask : Input::Detections, Input::Correspondence,
            LateResult::history_frames(params_.max_age_frames)};
  }

  SemanticRole role() const override { return params_.role; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  static constexpr float kMarginScore = 0.75F;

  void judge_instances(const Evidence& evidence, Votes& votes);

  void judge(const Evidence& evidence, const MaskLookup& mask, const LateResult& late, float score,
             Votes& votes);

  std::vector<float> flow_x_, flow_y_;
};

inline void SemanticMaskFilter::apply(const Evidence& evidence, Votes& votes) {
  if (params_.source == MaskSource::Mask) {
    const LateResult late = LateResult::mask(evidence, params_.max_age_frames, votes);
    if (!late.usable()) return;
    judge(evidence, MaskLookup(late.labels(), image_size(evidence.frame()), params_.labels), late, 1, votes);
  } else {
    judge_instances(evidence, votes);
  }
}

inline void SemanticMaskFilter::judge_instances(const Evidence& evidence, Votes& votes) {
  const LateResult late = LateResult::boxes(evidence, params_.max_age_frames, votes, "masks");
  if (!late.usable()) return;
  const DetectionFilter filter{params_.classes, {}, Params::kMinScore};
  bool any = late.detections().empty();
  for (const Detection& detection : late.detections()) any = any || !detection.mask.empty();
  if (!any) return votes.note("the detections have no masks");
  for (const Detection& detection : late.detections()) {
    if (!filter.accepts(detection)) continue;
    const MaskLookup mask(detection.mask, image_size(evidence.frame()));
    if (!mask.empty())
      judge(evidence, mask, late, detection.score, votes);
    else
      votes.note("a detection without a usable mask");
  }
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
