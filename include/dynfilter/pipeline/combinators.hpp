// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/pipeline/stage.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

using Stages = std::vector<std::unique_ptr<Stage>>;

/// What the combinators share: children, and needs and resets passed on.
class Combinator : public Stage {
 public:
  Combinator(std::string name, std::string path, Stages children)
      : Stage(std::move(name), std::move(path)), children_(std::move(children)) {}

  /// Nothing is required of a combinator itself: a child that misses an input is skipped, not the whole.
  Needs needs() const override {
    Needs all;
    for (const auto& child : children_) {
      const Needs needs = child->needs();
      all.optional = all.optional | needs.required | needs.optional;
      all.history_frames = std::max(all.history_frames, needs.history_frames);
    }
    return all;
  }
  void reset() override {
    for (auto& child : children_) child->reset();
  }
  void for_each(const std::function<void(const Stage&, int)>& visit, int depth = 0) const override {
    visit(*this, depth);
    for (const auto& child : children_) child->for_each(visit, depth + 1);
  }

 protected:
  static void set(Judgement& out, std::size_t i, Vote vote, float score, std::uint64_t reasons) {
    out.votes.cast(i, vote, score);
    out.reasons[i] = vote == Vote::Dynamic ? reasons : 0;
  }
  static void keep_priors(Judgement& out, const Judgement& child) {
    for (std::size_t i = 0; i < child.votes.size(); ++i)
      if (child.votes.prior(i)) out.votes.mark_prior(i);
  }

  Stages children_;
  Judgement child_;  ///< scratch: one child's answer
};

/// `sequence`: stages in turn; each judges what the earlier ones did not reject, and fits its models without
/// the features that they suspect (vote_then()).
class SequenceStage final : public Combinator {
 public:
  static constexpr const char* kName = "sequence";
  SequenceStage(std::string path, Stages children)
      : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(Context& context, std::vector<StageReport>& reports, std::size_t, Judgement& out) override {
    const Context::Scope scope(context);
    for (auto& child : children_) {
      child->judge(context, reports, child_);
      for (std::size_t i = 0; i < context.size(); ++i) {
        const Vote said = child_.votes[i];
        if (said == Vote::Unknown) continue;
        const bool first = out.votes[i] == Vote::Unknown;
        const float score =
            first ? child_.votes.score(i) : std::max(out.votes.score(i), child_.votes.score(i));
        set(out, i, vote_then(out.votes[i], said), score, out.reasons[i] | child_.reasons[i]);
      }
      keep_priors(out, child_);
      for (std::size_t i = 0; i < context.size(); ++i) {
        if (child_.votes.prior(i)) context.mark_prior(i);
        if (child_.votes[i] == Vote::Dynamic) context.withdraw(i);
      }
    }
  }
};

/// `any`: dynamic if one member says so (vote_or()). A member that was skipped or failed takes no part.
class AnyStage final : public Combinator {
 public:
  static constexpr const char* kName = "any";
  AnyStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(Context& context, std::vector<StageReport>& reports, std::size_t, Judgement& out) override {
    bool first = true;
    for (auto& child : children_) {
      const std::size_t place = reports.size();
      child->judge(context, reports, child_);
      keep_priors(out, child_);
      if (reports[place].skipped || reports[place].failed) continue;
      for (std::size_t i = 0; i < context.size(); ++i) {
        const Vote vote = first ? child_.votes[i] : vote_or(out.votes[i], child_.votes[i]);
        const float score =
            first ? child_.votes.score(i) : std::max(out.votes.score(i), child_.votes.score(i));
        set(out, i, vote, score, out.reasons[i] | child_.reasons[i]);
      }
      first = false;
    }
  }
};

/// `all`: dynamic if every member says so (vote_and()). Later members judge only what no earlier one called
/// static, and what an earlier one called dynamic is kept out of their model fitting. A member that was
/// skipped or failed leaves everything that is not static unknown.
class AllStage final : public Combinator {
 public:
  static constexpr const char* kName = "all";
  AllStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(Context& context, std::vector<StageReport>& reports, std::size_t, Judgement& out) override {
    const Context::Scope scope(context);
    bool first = true;
    for (auto& child : children_) {
      child->judge(context, reports, child_);
      keep_priors(out, child_);
      for (std::size_t i = 0; i < context.size(); ++i) {
        const Vote said = child_.votes[i];
        const bool was_static = !first && out.votes[i] == Vote::Static;
        if (was_static) continue;
        const Vote vote = first ? said : vote_and(out.votes[i], said);
        const float score =
            first ? child_.votes.score(i) : std::min(out.votes.score(i), child_.votes.score(i));
        set(out, i, vote, score, out.reasons[i] | child_.reasons[i]);
        if (said == Vote::Dynamic || child_.votes.prior(i)) context.mark_prior(i);
        if (vote == Vote::Static) context.excuse(i);
      }
      first = false;
    }
  }
};

/// `not`: static and dynamic change places (vote_not()).
class NotStage final : public Combinator {
 public:
  static constexpr const char* kName = "not";
  NotStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(Context& context, std::vector<StageReport>& reports, std::size_t self,
              Judgement& out) override {
    children_[0]->judge(context, reports, child_);
    const std::uint64_t reason = self < 64 ? std::uint64_t{1} << self : 0;
    for (std::size_t i = 0; i < context.size(); ++i)
      set(out, i, vote_not(child_.votes[i]), 1.0F - child_.votes.score(i), reason);
  }
};

/// `strict`: what the member cannot clear is dynamic (vote_strict()). For suspects: guilty until proven
/// static, be it that flow lost them or that there is no earlier frame yet.
class StrictStage final : public Combinator {
 public:
  static constexpr const char* kName = "strict";
  StrictStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(Context& context, std::vector<StageReport>& reports, std::size_t self,
              Judgement& out) override {
    children_[0]->judge(context, reports, child_);
    keep_priors(out, child_);
    const std::uint64_t reason = self < 64 ? std::uint64_t{1} << self : 0;
    for (std::size_t i = 0; i < context.size(); ++i) {
      const bool said = child_.votes[i] == Vote::Dynamic;
      set(out, i, vote_strict(child_.votes[i]), child_.votes.score(i), said ? child_.reasons[i] : reason);
    }
  }
};

/// `gate`: `then` judges the features that `if` calls dynamic, `else` (when given) those that it calls
/// static; the rest stays unknown. What the gate decides is who judges, never the vote.
class GateStage final : public Combinator {
 public:
  static constexpr const char* kName = "gate";
  GateStage(std::string path, Stages if_then_else)
      : Combinator(kName, std::move(path), std::move(if_then_else)) {}

 protected:
  void decide(Context& context, std::vector<StageReport>& reports, std::size_t, Judgement& out) override {
    children_[0]->judge(context, reports, gate_);
    keep_priors(out, gate_);
    for (std::size_t branch = 1; branch < children_.size(); ++branch) {
      const Vote wanted = branch == 1 ? Vote::Dynamic : Vote::Static;
      const Context::Scope scope(context);
      for (std::size_t i = 0; i < context.size(); ++i)
        if (gate_.votes[i] != wanted) context.excuse(i);
      children_[branch]->judge(context, reports, child_);
      keep_priors(out, child_);
      for (std::size_t i = 0; i < context.size(); ++i)
        if (gate_.votes[i] == wanted) set(out, i, child_.votes[i], child_.votes.score(i), child_.reasons[i]);
    }
  }

 private:
  Judgement gate_;
};

/// `by_region`: `inside` judges the prior suspects of earlier stages, `outside` the others: the same filter
/// with two thresholds, usually. Models that both need are computed once.
class ByRegionStage final : public Combinator {
 public:
  static constexpr const char* kName = "by_region";
  ByRegionStage(std::string path, Stages inside_outside)
      : Combinator(kName, std::move(path), std::move(inside_outside)) {}

 protected:
  void decide(Context& context, std::vector<StageReport>& reports, std::size_t, Judgement& out) override {
    for (std::size_t side = 0; side < 2; ++side) {
      const bool inside = side == 0;
      const Context::Scope scope(context);
      for (std::size_t i = 0; i < context.size(); ++i)
        if (context.prior(i) != inside) context.excuse(i);
      children_[side]->judge(context, reports, child_);
      keep_priors(out, child_);
      for (std::size_t i = 0; i < context.size(); ++i)
        if (context.prior(i) == inside)
          set(out, i, child_.votes[i], child_.votes.score(i), child_.reasons[i]);
    }
  }
};

}  // namespace dynfilter
