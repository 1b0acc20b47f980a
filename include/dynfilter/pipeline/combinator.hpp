// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/stage.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

using Stages = std::vector<StagePtr>;

/// Base of combinators: owns the children, merges their needs and passes on resets.
class Combinator : public Stage {
 public:
  Combinator(std::string name, std::string path, Stages children)
      : Stage(std::move(name), std::move(path)), children_(std::move(children)) {}

  /// A combinator itself requires nothing. A child without its input is skipped alone.
  Needs needs() const override;
  void reset() override {
    for (auto& child : children_) child->reset();
  }
  void for_each(const std::function<void(const Stage&, int)>& visit, int depth = 0) const override {
    visit(*this, depth);
    for (const auto& child : children_) child->for_each(visit, depth + 1);
  }

 protected:
  /// Sets the vote, suspicion and reasons of feature i.
  static void set(Judgement& out, std::size_t i, Vote vote, float suspicion, std::uint64_t reasons) {
    out.votes.cast(i, vote, suspicion);
    out.reasons[i] = vote == Vote::Dynamic ? reasons : 0;
  }
  /// The bit of the combinator's own report, for decisions that come from no child.
  static std::uint64_t own_reason(std::size_t self) { return self < 64 ? std::uint64_t{1} << self : 0; }

  Stages children_;
  Judgement child_;  ///< buffer for the result of one child
};

/// A combinator S with the parameters P.
template <class S, class P>
class ParametricCombinator : public Combinator {
 public:
  using Params = P;
  /// Throws ConfigError for a parameter out of range.
  ParametricCombinator(std::string path, Stages children, Params params = Params())
      : Combinator(S::kName, std::move(path), std::move(children)), params_(std::move(params)) {
    check_parameters(params_, this->path());
  }

 protected:
  const Params params_;
};

inline Needs Combinator::needs() const {
  Needs all;
  for (const auto& child : children_) {
    const Needs needs = child->needs();
    all.optional = all.optional | needs.required | needs.optional;
    all.history_frames = std::max(all.history_frames, needs.history_frames);
  }
  return all;
}

}  // namespace dynfilter
