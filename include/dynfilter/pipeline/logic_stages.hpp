// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <string>
#include <utility>

namespace dynfilter {

/// `sequence`: runs stages in order (vote_then()). Each stage judges the features that earlier ones did not
/// reject. It fits its models without the features that they suspect.
class SequenceStage final : public Combinator {
 public:
  static constexpr const char* kName = "sequence";
  static constexpr const char* kSummary =
      "runs stages in order; each judges the survivors and fits models without suspects";
  static constexpr const char* kDynamic =
      "if one stage votes dynamic; later stages judge the survivors and fit without the suspects";
  SequenceStage(std::string path, Stages children)
      : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) override;
};

/// `any`: dynamic if one member votes dynamic (vote_or()). Skipped or failed members do not count.
class AnyStage final : public Combinator {
 public:
  static constexpr const char* kName = "any";
  static constexpr const char* kSummary = "dynamic if one member votes dynamic";
  static constexpr const char* kDynamic = "if one member votes dynamic";
  AnyStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) override;
};

/// `all`: dynamic if every member votes dynamic (vote_and()). Later members judge only features that no
/// earlier member voted static. They fit their models without the features that an earlier member voted
/// dynamic. If a member is skipped or fails, all features that are not static are unknown.
class AllStage final : public Combinator {
 public:
  static constexpr const char* kName = "all";
  static constexpr const char* kSummary = "dynamic if every member votes dynamic";
  static constexpr const char* kDynamic =
      "if every member votes dynamic; later members judge only features that are not static yet";
  AllStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) override;
};

/// `not`: exchanges static and dynamic (vote_not()).
class NotStage final : public Combinator {
 public:
  static constexpr const char* kName = "not";
  static constexpr const char* kSummary = "exchanges static and dynamic";
  static constexpr const char* kDynamic = "if the stage votes static";
  NotStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;
};

/// `strict`: turns unknown into dynamic (vote_strict()). Use it for suspects, which are then dynamic unless
/// the stage votes static. Unknown means, for example, that flow failed or that there is no earlier frame.
class StrictStage final : public Combinator {
 public:
  static constexpr const char* kName = "strict";
  static constexpr const char* kSummary =
      "unknown becomes dynamic: only features that the stage votes static are kept";
  static constexpr const char* kDynamic = "unless the stage votes static";
  StrictStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;
};

inline void SequenceStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t,
                                  Judgement& out) {
  const EarlierVotes::Scope scope(evidence.earlier_votes());
  for (auto& child : children_) {
    const std::size_t place = reports.size();
    child->judge(evidence, reports, child_);
    if (reports[place].skipped) continue;
    for (std::size_t i = 0, n = evidence.size(); i < n; ++i) {
      const Vote said = child_.votes[i];
      if (said == Vote::Unknown) continue;
      const bool first = out.votes[i] == Vote::Unknown;
      const float suspicion =
          first ? child_.votes.suspicion(i) : std::max(out.votes.suspicion(i), child_.votes.suspicion(i));
      set(out, i, vote_then(out.votes[i], said), suspicion, out.reasons[i] | child_.reasons[i]);
    }
    out.votes.add_priors(child_.votes);
    evidence.earlier_votes().learn(child_.votes);
  }
}

inline void AnyStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) {
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

inline void AllStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) {
  const EarlierVotes::Scope scope(evidence.earlier_votes());
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
      if (said == Vote::Dynamic || child_.votes.prior(i)) evidence.earlier_votes().mark_prior(i);
      if (vote == Vote::Static) evidence.earlier_votes().exclude(i);
    }
    first = false;
  }
}

inline void NotStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                             Judgement& out) {
  children_[0]->judge(evidence, reports, child_);
  const std::uint64_t reason = own_reason(self);
  for (std::size_t i = 0; i < evidence.size(); ++i)
    set(out, i, vote_not(child_.votes[i]), 1.0F - child_.votes.suspicion(i), reason);
}

inline void StrictStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                                Judgement& out) {
  const std::size_t skipped = reports.late_skips();
  children_[0]->judge(evidence, reports, child_);
  out.votes.add_priors(child_.votes);
  const std::uint64_t reason = own_reason(self);
  // A lack of time is no reason to reject.
  const bool complete = reports.late_skips() == skipped;
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const bool said = child_.votes[i] == Vote::Dynamic;
    set(out, i, complete ? vote_strict(child_.votes[i]) : child_.votes[i], child_.votes.suspicion(i),
        said ? child_.reasons[i] : reason);
  }
}

}  // namespace dynfilter
