// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/box_foreground.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace dynfilter {

struct SemanticBoxParams {
  SemanticRole role = SemanticRole::Prior;
  std::vector<std::string> classes = moving_classes();
  double min_score = 0.4;
  int max_age_frames = 30;
  BoxRefinement refine = BoxRefinement::None;
  double foreground_margin_m = 0.15;

  static const FieldTable<SemanticBoxParams>& fields() {
    using P = SemanticBoxParams;
    static const FieldTable<P> table{
        semantic_role("role", &P::role),
        words("classes", &P::classes, "names of the classes that may move; empty: all classes"),
        real("min_score", &P::min_score, "", {0, 1}, "smallest score of a box that is used"),
        integer("max_age_frames", &P::max_age_frames, "frames", {0, 100},
                "largest age of boxes; boxes of an older frame are carried to this one up to this age"),
        box_refinement("refine", &P::refine),
        real("foreground_margin_m", &P::foreground_margin_m, "m", {0, 10},
             "depth margin behind the foreground's surface that still belongs to it"),
    };
    return table;
  }
};

/// Rejects or marks features inside detector boxes of classes that may move (RTS-SLAM sec. 3.2; also SG-SLAM
/// and YOLO-SLAM).
///
/// Formula:  p in a box of a class in `classes` with score >= min_score.
///           With `refine`, also z(p) <= foreground depth of the box + foreground_margin_m.
/// Needs:    boxes. Boxes of an older frame need correspondences, `refine` needs depth.
/// Votes:    role reject: Dynamic inside. role prior: marks suspects.
///           Never Static, because detectors miss objects.
/// Abstains: without boxes, and if they are older than max_age_frames.
/// Blind to: classes that the detector does not detect; whether the object moves at all.
/// State:    none; the pipeline carries late boxes.
/// Cost:     one comparison per box and feature, about 5 us.
class SemanticBoxFilter final : public ParametricFilter<SemanticBoxFilter, SemanticBoxParams>,
                                public SemanticFilter {
 public:
  using ParametricFilter::ParametricFilter;
  static constexpr const char* kName = "semantic_box";
  static constexpr const char* kSummary = "features inside detector boxes of classes that may move";

  Needs needs() const override {
    return {Input::Detections, Input::Depth | Input::Correspondence,
            LateResult::history_frames(params_.max_age_frames)};
  }

  SemanticRole role() const override { return params_.role; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  void judge(const Evidence& evidence, const Detection& detection, const LateResult& late, Votes& votes);

  DetectionFilter wanted_{params_.classes, {}, params_.min_score};
  std::vector<std::size_t> inside_;
  BoxScratch scratch_;
};

inline void SemanticBoxFilter::apply(const Evidence& evidence, Votes& votes) {
  const LateResult late = LateResult::boxes(evidence, params_.max_age_frames, votes);
  if (!late.usable()) return;
  for (const Detection& detection : late.detections())
    if (wanted_.accepts(detection)) judge(evidence, detection, late, votes);
}

inline void SemanticBoxFilter::judge(const Evidence& evidence, const Detection& detection,
                                     const LateResult& late, Votes& votes) {
  const cv::Rect2f box = features_in_box(evidence, detection.box, 0, late, scratch_, inside_);
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
