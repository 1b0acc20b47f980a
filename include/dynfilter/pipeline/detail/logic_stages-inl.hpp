// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/logic_stages.hpp>

#include <algorithm>
#include <cstdint>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/stage_state.hpp>

namespace dynfilter {

DYNFILTER_INLINE void SequenceStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t,
                                            Judgement& out) {
  const StageState::Scope scope(evidence.stages());
  for (auto& child : children_) {
    child->judge(evidence, reports, child_);
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const Vote said = child_.votes[i];
      if (said == Vote::Unknown) continue;
      const bool first = out.votes[i] == Vote::Unknown;
      const float suspicion =
          first ? child_.votes.suspicion(i) : std::max(out.votes.suspicion(i), child_.votes.suspicion(i));
      set(out, i, vote_then(out.votes[i], said), suspicion, out.reasons[i] | child_.reasons[i]);
    }
    out.votes.add_priors(child_.votes);
    evidence.stages().learn(child_.votes);
  }
}

DYNFILTER_INLINE void AnyStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t,
                                       Judgement& out) {
  bool first = true;
  for (auto& child : children_) {
    const std::size_t place = reports.size();
    child->judge(evidence, reports, child_);
    out.votes.add_priors(child_.votes);
    if (reports[place].skipped || reports[place].failed) continue;
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const Vote vote = first ? child_.votes[i] : vote_or(out.votes[i], child_.votes[i]);
      const float suspicion =
          first ? child_.votes.suspicion(i) : std::max(out.votes.suspicion(i), child_.votes.suspicion(i));
      set(out, i, vote, suspicion, out.reasons[i] | child_.reasons[i]);
    }
    first = false;
  }
}

DYNFILTER_INLINE void AllStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t,
                                       Judgement& out) {
  const StageState::Scope scope(evidence.stages());
  bool first = true;
  for (auto& child : children_) {
    child->judge(evidence, reports, child_);
    out.votes.add_priors(child_.votes);
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const Vote said = child_.votes[i];
      const bool was_static = !first && out.votes[i] == Vote::Static;
      if (was_static) continue;
      const Vote vote = first ? said : vote_and(out.votes[i], said);
      const float suspicion =
          first ? child_.votes.suspicion(i) : std::min(out.votes.suspicion(i), child_.votes.suspicion(i));
      set(out, i, vote, suspicion, out.reasons[i] | child_.reasons[i]);
      if (said == Vote::Dynamic || child_.votes.prior(i)) evidence.stages().mark_prior(i);
      if (vote == Vote::Static) evidence.stages().excuse(i);
    }
    first = false;
  }
}

DYNFILTER_INLINE void NotStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                                       Judgement& out) {
  children_[0]->judge(evidence, reports, child_);
  const std::uint64_t reason = own_reason(self);
  for (std::size_t i = 0; i < evidence.size(); ++i)
    set(out, i, vote_not(child_.votes[i]), 1.0F - child_.votes.suspicion(i), reason);
}

DYNFILTER_INLINE void StrictStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                                          Judgement& out) {
  const std::size_t skipped = evidence.stages().late_skips();
  children_[0]->judge(evidence, reports, child_);
  out.votes.add_priors(child_.votes);
  const std::uint64_t reason = own_reason(self);
  // A lack of time is no reason to reject.
  const bool complete = evidence.stages().late_skips() == skipped;
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const bool said = child_.votes[i] == Vote::Dynamic;
    set(out, i, complete ? vote_strict(child_.votes[i]) : child_.votes[i], child_.votes.suspicion(i),
        said ? child_.reasons[i] : reason);
  }
}

}  // namespace dynfilter
