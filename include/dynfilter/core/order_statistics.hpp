// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace dynfilter {

namespace detail {

/// Puts the values below the pivot first and returns how many there are. Without branches on the data, which
/// a processor cannot foresee (Alexandrescu, "Lomuto's comeback", 2020).
template <class T, class Below>
std::size_t partition_in_place(T* values, std::size_t count, const Below& below) {
  std::size_t first = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const T value = values[i];
    values[i] = values[first];
    values[first] = value;
    first += below(value) ? 1 : 0;
  }
  return first;
}

template <class T>
T middle_of(T a, T b, T c) {
  return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

}  // namespace detail

/// The value that comes to place `at` of `count` > `at` numbers when they are sorted; their order changes.
/// As std::nth_element, two to four times as fast for 300 to 10000 floats.
template <class T>
T select_in_place(T* values, std::size_t count, std::size_t at) {
  constexpr int kRounds = 64;  // pivots that split badly so often are somebody's intention
  for (int round = 0; count > 24 && round < kRounds; ++round) {
    const T pivot = detail::middle_of(values[count / 4], values[count / 2], values[count / 4 * 3]);
    std::size_t first = detail::partition_in_place(values, count, [=](T value) { return value < pivot; });
    if (at < first) {
      count = first;
      continue;
    }
    if (first == 0) {
      first = detail::partition_in_place(values, count, [=](T value) { return !(pivot < value); });
      if (at < first) return pivot;
    }
    values += first, count -= first, at -= first;
  }
  std::nth_element(values, values + at, values + count);
  return values[at];
}

/// The value that `percent` of the others lie below; their order changes. NaN without any.
template <class T>
T quantile_in_place(std::vector<T>& values, std::size_t percent) {
  if (values.empty()) return std::numeric_limits<T>::quiet_NaN();
  return select_in_place(values.data(), values.size(), values.size() * percent / 100);
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
