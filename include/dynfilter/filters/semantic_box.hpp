// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/box_foreground.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <string>
#include <vector>

namespace dynfilter {

struct SemanticBoxParams {
  SemanticRole role = SemanticRole::Prior;
  std::vector<std::string> classes = moving_classes();
  double min_score = 0.4;
  double expand_px = 0;
  int max_age_frames = 30;
  BoxRefinement refine = BoxRefinement::None;
  double foreground_margin_m = 0.15;

  static const FieldTable<SemanticBoxParams>& fields();
};

/// Rejects or marks features inside detector boxes of classes that may move
/// (RTS-SLAM sec. 3.2; also SG-SLAM and YOLO-SLAM).
///
/// Formula:  p in a box of a class in `classes` with score >= min_score, grown by expand_px.
///           With `refine`, also z(p) <= foreground depth of the box + foreground_margin_m.
/// Needs:    boxes. Boxes of an older frame need correspondences, `refine` needs depth.
/// Votes:    role reject: Dynamic inside. role prior: marks suspects.
///           Never Static, because detectors miss objects.
/// Abstains: without boxes, and if they are older than max_age_frames.
/// Blind to: classes that the detector does not detect; whether the object moves at all.
/// State:    none; the pipeline carries late boxes.
/// Cost:     one comparison per box and feature, about 5 us.
class SemanticBoxFilter final : public NamedFilter<SemanticBoxFilter>, public SemanticFilter {
 public:
  using Params = SemanticBoxParams;
  static constexpr const char* kName = "semantic_box";
  static constexpr const char* kSummary = "features inside detector boxes of classes that may move";

  explicit SemanticBoxFilter(Params params = Params());

  Needs needs() const override {
    return {Input::Detections, Input::Depth | Input::Correspondence,
            LateResult::history_frames(params_.max_age_frames)};
  }

  SemanticRole role() const override { return params_.role; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  void judge(const Evidence& evidence, const Detection& detection, const LateResult& late, Votes& votes);

  Params params_;
  DetectionFilter wanted_;
  std::vector<std::size_t> inside_;
  BoxScratch scratch_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/semantic_box-inl.hpp>
#endif
