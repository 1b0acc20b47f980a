// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace dynfilter {

/// Splits the depths of a box into two surfaces: the largest depth [m] of the nearer one.
/// Applies the threshold of Otsu (1979) to inverse depths. Sorts `inverse` [1/m].
/// The means must differ by at least 15 %, and the near side must have 10 % of the samples.
/// Otherwise, and for fewer than 8 samples, there is one surface and the result is infinity.
double nearer_surface_m(std::vector<float>& inverse);

inline double nearer_surface_m(std::vector<float>& inverse) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  if (inverse.size() < 8) return kAll;
  std::sort(inverse.begin(), inverse.end());
  const auto n = static_cast<double>(inverse.size());
  double total = 0;
  for (const float v : inverse) total += static_cast<double>(v);
  double far_sum = 0, best = 0, gap_end = 0;
  std::size_t split = 0;
  for (std::size_t k = 1; k < inverse.size(); ++k) {
    far_sum += static_cast<double>(inverse[k - 1]);
    const double far_n = static_cast<double>(k), near_n = n - far_n;
    const double difference = (total - far_sum) / near_n - far_sum / far_n;
    const double between = far_n * near_n * difference * difference;
    if (between <= best) continue;
    best = between;
    split = k;
    gap_end = difference / (total / n);
  }
  const bool two_surfaces = gap_end > 0.15 && n - static_cast<double>(split) >= 0.1 * n;
  return two_surfaces ? 1.0 / static_cast<double>(inverse[split]) : kAll;
}

}  // namespace dynfilter
