// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/printable_text.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// `gate`: `then` judges the features that `if` votes dynamic. `else`, if given, judges those that it votes
/// static. All others are unknown. `if` only selects the judging stage; its vote is not used.
class GateStage final : public Combinator {
 public:
  static constexpr const char* kName = "gate";
  static constexpr const char* kSummary = "`if` selects the stage that judges a feature; `else` is optional";
  static constexpr const char* kDynamic =
      "where `if` and `then` vote dynamic, or `if` votes static and `else` dynamic";
  GateStage(std::string path, Stages if_then_else)
      : Combinator(kName, std::move(path), std::move(if_then_else)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) override;

 private:
  Judgement gate_;
};

/// `by_region`: `inside` judges the prior suspects of earlier stages, `outside` the others.
/// Typically both are the same filter with different thresholds. Models that both need are computed once.
class ByRegionStage final : public Combinator {
 public:
  static constexpr const char* kName = "by_region";
  static constexpr const char* kSummary = "prior suspects are judged by `inside`, the others by `outside`";
  static constexpr const char* kDynamic =
      "if it is a prior suspect and `inside` votes dynamic, or another feature and `outside` does";
  ByRegionStage(std::string path, Stages inside_outside)
      : Combinator(kName, std::move(path), std::move(inside_outside)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) override;
};

/// `first_available`: the first member that judges decides alone; those after it do not run.
/// So one pipeline serves cameras with and without depth.
/// A member has not judged if it abstained on the whole frame: it was skipped, it failed, or every vote is
/// Unknown. The next member then judges the frame, unless the first doubts (Votes::doubt()). Its prior
/// suspects count nevertheless.
///
/// Each frame is decided anew, without a memory of the member that judged the last one. An input may be
/// missing in one frame only (depth at half the rate of the images), and waiting would leave frames unjudged.
/// A member that did not run in the last frame is reset before its next turn. Its tracks and motions end at
/// an older frame. Members that take turns therefore judge as at the start of a stream.
/// A member that is called and abstains keeps its memory, so it is not thrown back by its own doubt.
class FirstAvailableStage final : public Combinator {
 public:
  static constexpr const char* kName = "first_available";
  static constexpr const char* kSummary =
      "the first member that does not abstain on the whole frame judges alone";
  static constexpr const char* kDynamic =
      "if the first member that does not abstain on the whole frame votes dynamic";
  FirstAvailableStage(std::string path, Stages members)
      : Combinator(kName, std::move(path), std::move(members)), rested_(children_.size(), 0) {}

  void reset() override {
    Combinator::reset();
    std::fill(rested_.begin(), rested_.end(), std::uint8_t{0});
  }

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;

 private:
  static void rest(const Stage& member, StageReports& reports) {
    StageReport& report = reports.add(member.name(), member.path());
    report.skipped = true;
    report.note = "skipped: an earlier member judged";
  }
  /// Appends "background_motion skipped: no depth" or "... abstained on the whole frame".
  static void add_skip_reason(const StageReport& member, std::string& text);

  std::vector<std::uint8_t> rested_;  ///< members that did not run in the last frame
  std::string skip_reasons_;
};

inline void GateStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) {
  children_[0]->judge(evidence, reports, gate_);
  out.votes.add_priors(gate_.votes);
  for (std::size_t branch = 1; branch < children_.size(); ++branch) {
    const Vote wanted = branch == 1 ? Vote::Dynamic : Vote::Static;
    const EarlierVotes::Scope scope(evidence.earlier_votes());
    for (std::size_t i = 0; i < evidence.size(); ++i)
      if (gate_.votes[i] != wanted) evidence.earlier_votes().exclude(i);
    children_[branch]->judge(evidence, reports, child_);
    out.votes.add_priors(child_.votes);
    for (std::size_t i = 0; i < evidence.size(); ++i)
      if (gate_.votes[i] == wanted)
        set(out, i, child_.votes[i], child_.votes.suspicion(i), child_.reasons[i]);
  }
}

inline void ByRegionStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t,
                                  Judgement& out) {
  for (std::size_t side = 0; side < 2; ++side) {
    const bool inside = side == 0;
    const EarlierVotes::Scope scope(evidence.earlier_votes());
    evidence.earlier_votes().keep_side(inside);
    children_[side]->judge(evidence, reports, child_);
    out.votes.add_priors(child_.votes);
    for (std::size_t i = 0; i < evidence.size(); ++i)
      if (evidence.prior(i) == inside)
        set(out, i, child_.votes[i], child_.votes.suspicion(i), child_.reasons[i]);
  }
}

inline void FirstAvailableStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                                        Judgement& out) {
  const Stage* judge = nullptr;
  skip_reasons_.clear();
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
      add_skip_reason(reports[place], skip_reasons_);
  }
  if (skip_reasons_.empty()) return;
  std::string& note = reports[self].note;
  if (judge != nullptr)
    append_text(note, "judged by ", judge->name(), " (", skip_reasons_, ")");
  else
    append_text(note, "no member judged (", skip_reasons_, ")");
}

inline void FirstAvailableStage::add_skip_reason(const StageReport& member, std::string& text) {
  append_text(text, text.empty() ? "" : ", ", member.name, " ");
  if (member.skipped)
    text += member.note;  // "skipped: no depth"
  else
    text += member.failed ? "failed" : "abstained on the whole frame";
}

}  // namespace dynfilter
