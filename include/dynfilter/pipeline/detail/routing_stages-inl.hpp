// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/routing_stages.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/stage_state.hpp>

namespace dynfilter {

DYNFILTER_INLINE void GateStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t,
                                        Judgement& out) {
  children_[0]->judge(evidence, reports, gate_);
  out.votes.add_priors(gate_.votes);
  for (std::size_t branch = 1; branch < children_.size(); ++branch) {
    const Vote wanted = branch == 1 ? Vote::Dynamic : Vote::Static;
    const StageState::Scope scope(evidence.stages());
    for (std::size_t i = 0; i < evidence.size(); ++i)
      if (gate_.votes[i] != wanted) evidence.stages().excuse(i);
    children_[branch]->judge(evidence, reports, child_);
    out.votes.add_priors(child_.votes);
    for (std::size_t i = 0; i < evidence.size(); ++i)
      if (gate_.votes[i] == wanted)
        set(out, i, child_.votes[i], child_.votes.suspicion(i), child_.reasons[i]);
  }
}

DYNFILTER_INLINE void ByRegionStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t,
                                            Judgement& out) {
  for (std::size_t side = 0; side < 2; ++side) {
    const bool inside = side == 0;
    const StageState::Scope scope(evidence.stages());
    evidence.stages().keep_side(inside);
    children_[side]->judge(evidence, reports, child_);
    out.votes.add_priors(child_.votes);
    for (std::size_t i = 0; i < evidence.size(); ++i)
      if (evidence.prior(i) == inside)
        set(out, i, child_.votes[i], child_.votes.suspicion(i), child_.reasons[i]);
  }
}

DYNFILTER_INLINE void FirstAvailableStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t,
                                                  Judgement& out) {
  bool judged = false;
  for (const auto& member : children_) {
    if (judged) {
      StageReport& report = reports.add(member->name(), member->path());
      report.skipped = true;
      report.note = "skipped: an earlier member judged";
      continue;
    }
    judged = without(member->needs().required, evidence.inputs()) == Input::None;
    member->judge(evidence, reports, out);  // without its inputs it only reports that it was skipped
  }
}

}  // namespace dynfilter
