// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/association.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <tuple>

namespace dynfilter::io {

DYNFILTER_INLINE std::vector<std::pair<std::size_t, std::size_t>> associate(const std::vector<double>& a_s,
                                                                            const std::vector<double>& b_s,
                                                                            double max_gap_s) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> candidates;
  for (std::size_t i = 0; i < a_s.size(); ++i) {
    auto j = static_cast<std::size_t>(std::lower_bound(b_s.begin(), b_s.end(), a_s[i] - 2 * max_gap_s) -
                                      b_s.begin());
    for (; j < b_s.size() && b_s[j] < a_s[i] + 2 * max_gap_s; ++j) {
      const double gap_s = std::abs(a_s[i] - b_s[j]);
      if (gap_s < max_gap_s) candidates.emplace_back(gap_s, i, j);
    }
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> a_taken(a_s.size()), b_taken(b_s.size());
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [gap_s, i, j] : candidates) {
    if (a_taken[i] || b_taken[j]) continue;
    a_taken[i] = b_taken[j] = true;
    pairs.emplace_back(i, j);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace dynfilter::io
