// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/verdict.hpp>

#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE std::size_t Verdict::kept() const {
  std::size_t n = 0;
  for (const Vote vote : decision) n += vote != Vote::Dynamic ? 1 : 0;
  return n;
}

DYNFILTER_INLINE float Verdict::weight(std::size_t i) const {
  if (!keep(i)) return 0;
  const float reliable = spread.empty() ? 1 : spread[i].reliability();
  if (suspicion[i] == Votes::kNoIdea) return reliable;
  const float moves2 = suspicion[i] * suspicion[i], rests2 = (1 - suspicion[i]) * (1 - suspicion[i]);
  return reliable * rests2 / (rests2 + moves2);
}

DYNFILTER_INLINE std::string Verdict::reason(std::size_t i) const {
  std::string text;
  for (std::size_t k = 0; k < report.stages.size() && k < 64; ++k)
    if ((reasons[i] >> k & 1U) != 0) text += (text.empty() ? "" : "+") + report.stages[k].name;
  return text;
}

}  // namespace dynfilter
