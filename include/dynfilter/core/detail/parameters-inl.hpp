// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/parameters.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/numbers.hpp>

namespace dynfilter {

namespace detail {

DYNFILTER_INLINE std::string shown(double value) {
  return number_text(value);
}

DYNFILTER_INLINE std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

DYNFILTER_INLINE std::string range_text(double min, double max) {
  return max >= 1e9 ? ">= " + shown(min) : shown(min) + " to " + shown(max);
}

}  // namespace detail

}  // namespace dynfilter
