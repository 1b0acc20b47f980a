// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/eval/statistics.hpp>

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/inline.hpp>

namespace dynfilter::eval {

DYNFILTER_INLINE double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

DYNFILTER_INLINE ErrorStatistics statistics(const std::vector<double>& errors) {
  if (errors.empty()) return {};
  const double n = static_cast<double>(errors.size());
  double sum = 0, squares = 0, deviations = 0;
  for (const double e : errors) sum += e, squares += e * e;
  const double mean = sum / n;
  for (const double e : errors) deviations += (e - mean) * (e - mean);
  const auto [min, max] = std::minmax_element(errors.begin(), errors.end());
  return {std::sqrt(squares / n), mean, median(errors), std::sqrt(deviations / n), *min, *max};
}

}  // namespace dynfilter::eval
