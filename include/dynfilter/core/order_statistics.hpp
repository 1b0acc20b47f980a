// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace dynfilter {

/// The value that `percent` of the others lie below; their order changes. NaN without any.
template <class T>
T quantile_in_place(std::vector<T>& values, std::size_t percent) {
  if (values.empty()) return std::numeric_limits<T>::quiet_NaN();
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * percent / 100);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The median (of an even number of values the upper one); their order changes. NaN without any.
template <class T>
T median_in_place(std::vector<T>& values) {
  return quantile_in_place(values, 50);
}

/// The median of the values in that window of `width` which holds most of them, of equal ones the lowest:
/// where a RANSAC whose model is one number ends up, found exactly. Sorts the values. Nothing without any.
template <class T>
std::optional<T> densest_in_place(std::vector<T>& values, T width) {
  std::sort(values.begin(), values.end());
  std::size_t begin = 0, best = 0, best_begin = 0;
  for (std::size_t end = 0; end < values.size(); ++end) {
    while (values[end] - values[begin] > width) ++begin;
    if (end + 1 - begin <= best) continue;
    best = end + 1 - begin;
    best_begin = begin;
  }
  if (best == 0) return std::nullopt;
  return values[best_begin + best / 2];
}

}  // namespace dynfilter
