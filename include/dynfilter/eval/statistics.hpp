// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace dynfilter::eval {

/// Statistics of a list of errors. All NaN if it is empty. `std` divides by n, like the TUM tools.
struct ErrorStatistics {
  double rmse = NAN, mean = NAN, median = NAN, std = NAN, min = NAN, max = NAN;
};

/// The mean of the two middle values for an even count. NaN without values.
inline double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

inline ErrorStatistics statistics(const std::vector<double>& errors) {
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
