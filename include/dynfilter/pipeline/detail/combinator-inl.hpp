// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/combinator.hpp>

#include <algorithm>
#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE Needs Combinator::needs() const {
  Needs all;
  for (const auto& child : children_) {
    const Needs needs = child->needs();
    all.optional = all.optional | needs.required | needs.optional;
    all.history_frames = std::max(all.history_frames, needs.history_frames);
  }
  return all;
}

DYNFILTER_INLINE void Combinator::reset() {
  for (auto& child : children_) child->reset();
}

DYNFILTER_INLINE void Combinator::for_each(const std::function<void(const Stage&, int)>& visit,
                                           int depth) const {
  visit(*this, depth);
  for (const auto& child : children_) child->for_each(visit, depth + 1);
}

DYNFILTER_INLINE void Combinator::set(Judgement& out, std::size_t i, Vote vote, float suspicion,
                                      std::uint64_t reasons) {
  out.votes.cast(i, vote, suspicion);
  out.reasons[i] = vote == Vote::Dynamic ? reasons : 0;
}

}  // namespace dynfilter
