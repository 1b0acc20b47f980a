// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/routing_stages.hpp>

#include <algorithm>
#include <dynfilter/core/append_text.hpp>
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

DYNFILTER_INLINE void FirstAvailableStage::reset() {
  Combinator::reset();
  std::fill(rested_.begin(), rested_.end(), std::uint8_t{0});
}

DYNFILTER_INLINE void FirstAvailableStage::decide(FrameEvidence& evidence, StageReports& reports,
                                                  std::size_t self, Judgement& out) {
  const Stage* judge = nullptr;
  why_not_.clear();
  for (std::size_t k = 0; k < children_.size(); ++k) {
    Stage& member = *children_[k];
    if (judge != nullptr) {
      rest(member, reports);
      rested_[k] = 1;
      continue;
    }
    if (rested_[k] != 0) member.reset();
    rested_[k] = 0;
    const std::size_t place = reports.size();
    member.judge(evidence, reports, child_);
    child_.votes.add_priors(out.votes);
    std::swap(out, child_);
    if (reports[place].has_judged())
      judge = &member;
    else
      add_why_not(reports[place], why_not_);
  }
  if (why_not_.empty()) return;
  std::string& note = reports[self].note;
  if (judge != nullptr)
    append_text(note, "judged by ", judge->name(), " (", why_not_, ")");
  else
    append_text(note, "no member judged (", why_not_, ")");
}

inline void FirstAvailableStage::rest(const Stage& member, StageReports& reports) {
  StageReport& report = reports.add(member.name(), member.path());
  report.skipped = true;
  report.note = "skipped: an earlier member judged";
}

inline void FirstAvailableStage::add_why_not(const StageReport& member, std::string& text) {
  append_text(text, text.empty() ? "" : ", ", member.name, " ");
  if (member.skipped)
    text += member.note;  // "skipped: no depth"
  else
    text += member.failed ? "failed" : "abstained on the whole frame";
}

}  // namespace dynfilter
