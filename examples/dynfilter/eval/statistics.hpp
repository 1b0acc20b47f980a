// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <vector>

namespace dynfilter::eval {

/// Statistics of a list of errors. All NaN if it is empty. `std` divides by n, like the TUM tools.
struct ErrorStatistics {
  double rmse = NAN, mean = NAN, median = NAN, std = NAN, min = NAN, max = NAN;
};

/// The mean of the two middle values for an even count. NaN without values.
double median(std::vector<double> values);

ErrorStatistics statistics(const std::vector<double>& errors);

}  // namespace dynfilter::eval
