// SPDX-License-Identifier: MIT
#include "eval/statistics.hpp"

#include <algorithm>
#include <dynfilter/core/order_statistics.hpp>

namespace dynfilter::eval {

double median(std::vector<double> values) {
  return averaged_median_in_place(values);
}

ErrorStatistics statistics(const std::vector<double>& errors) {
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
