// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// The semantic input with the mask.
enum class MaskSource {
  Mask,      ///< FrameView::mask
  Instances  ///< masks of the detections
};
enum class OffMask { Unknown, Static };

struct SemanticMaskParams {
  SemanticRole role = SemanticRole::Prior;
  MaskSource source = MaskSource::Mask;
  std::vector<int> labels;
  std::vector<std::string> classes = moving_classes();
  double min_score = 0.4;
  double dilate_px = 5;
  int max_age_frames = 30;
  OffMask off_mask = OffMask::Unknown;

  static const FieldTable<SemanticMaskParams>& fields();
};

/// Rejects or marks features on the potentially moving pixels of a mask
/// (DynaSLAM sec. III-B; also DS-SLAM and DeS-SLAM).
///
/// Formula:  label(p) in `labels`, or such a pixel within dilate_px of p (a disc).
/// Needs:    a mask of any size, which is scaled to the image, or detections with instance masks.
///           Masks of an older frame need correspondences.
/// Votes:    role reject: Dynamic, with a lower score in the margin than on the mask.
///           role prior: marks suspects.
///           Static only with `off_mask: static`, because networks miss objects.
/// Abstains: without a mask, if it is unusable, and if it is older than max_age_frames.
/// Blind to: classes that the network does not detect; whether the object moves at all.
/// State:    none; the pipeline carries late masks.
/// Cost:     about 0.1 us per feature without dilation and 1 us with 15 px.
///           Only the mask around each feature is read.
class SemanticMaskFilter final : public NamedFilter<SemanticMaskFilter>, public SemanticFilter {
 public:
  using Params = SemanticMaskParams;
  static constexpr const char* kName = "semantic_mask";
  static constexpr const char* kSummary = "features on a mask of objects that may move";

  explicit SemanticMaskFilter(Params params = Params());

  Needs needs() const override {
    return {params_.source == MaskSource::Mask ? Input::Mask : Input::Detections, Input::Correspondence,
            LateResult::history_frames(params_.max_age_frames)};
  }

  SemanticRole role() const override { return params_.role; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  static constexpr float kMarginScore = 0.75F;

  void judge_instances(const Evidence& evidence, Votes& votes);

  void clear(const Evidence& evidence, const LateResult& late, Votes& votes) const;

  void judge(const Evidence& evidence, const MaskLookup& mask, const LateResult& late, float score,
             Votes& votes);

  Params params_;
  std::vector<float> flow_x_, flow_y_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/semantic_mask-inl.hpp>
#endif
