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

DYNFILTER_INLINE std::string Verdict::reason(std::size_t i) const {
  std::string text;
  for (std::size_t k = 0; k < report.stages.size() && k < 64; ++k)
    if ((reasons[i] >> k & 1U) != 0) text += (text.empty() ? "" : "+") + report.stages[k].name;
  return text;
}

}  // namespace dynfilter
