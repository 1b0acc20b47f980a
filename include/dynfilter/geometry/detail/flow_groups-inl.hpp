// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/flow_groups.hpp>

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
  groups_ = 0;
  for (std::size_t i = 0; i < n; ++i) {
    int& number = number_[static_cast<std::size_t>(root(static_cast<int>(i)))];
    if (number < 0) {
      number = static_cast<int>(groups_++);
      if (members_.size() < groups_) members_.emplace_back();
      members_[groups_ - 1].clear();
    }
    members_[static_cast<std::size_t>(number)].push_back(static_cast<int>(i));
  }
}

}  // namespace dynfilter
