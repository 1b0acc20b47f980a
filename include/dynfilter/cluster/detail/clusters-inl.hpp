// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/cluster/clusters.hpp>

#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE void Clusters::reset(std::size_t n) {
  label.assign(n, kNoise);
  core.assign(n, 0);
  count = 0;
}

DYNFILTER_INLINE void Clusters::renumber(std::size_t names) {
  numbers_.assign(names, kNoise);
  count = 0;
  for (std::int32_t& l : label) {
    if (l < 0) continue;
    std::int32_t& number = numbers_[static_cast<std::size_t>(l)];
    if (number < 0) number = count++;
    l = number;
  }
}

namespace detail {

DYNFILTER_INLINE void DisjointSets::reset(std::size_t n) {
  parent_.resize(n);
  for (std::size_t i = 0; i < n; ++i) parent_[i] = static_cast<std::uint32_t>(i);
}

}  // namespace detail

}  // namespace dynfilter
