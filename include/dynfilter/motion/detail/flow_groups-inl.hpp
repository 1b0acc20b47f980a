// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/motion/flow_groups.hpp>

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/inline.hpp>

namespace dynfilter {

inline int FlowGroups::root(int i) {
  while (parent_[static_cast<std::size_t>(i)] != i) {
    int& up = parent_[static_cast<std::size_t>(i)];
    up = parent_[static_cast<std::size_t>(up)];
    i = up;
  }
  return i;
}

DYNFILTER_INLINE void FlowGroups::join(int a, int b) {
  a = root(a);
  b = root(b);
  if (a != b) parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
}

DYNFILTER_INLINE void FlowGroups::collect() {
  const std::size_t n = parent_.size();
  number_.assign(n, -1);
  counts_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    int& number = number_[static_cast<std::size_t>(root(static_cast<int>(i)))];
    if (number < 0) {
      number = static_cast<int>(counts_.size());
      counts_.push_back(0);
    }
    ++counts_[static_cast<std::size_t>(number)];
  }
  members_.lay_out(counts_);
  for (std::size_t i = 0; i < n; ++i) {
    const int number = number_[static_cast<std::size_t>(root(static_cast<int>(i)))];
    members_.put(static_cast<std::size_t>(number), static_cast<int>(i));
  }
}

inline void FlowGroups::Lists::lay_out(const std::vector<int>& lengths) {
  std::size_t begin = 0;
  ends_.clear();
  for (const int length : lengths) {
    ends_.push_back(begin);  // put() moves it to the end
    begin += static_cast<std::size_t>(length);
  }
  entries_.resize(begin);
}

}  // namespace dynfilter
