// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace dynfilter::eval {

/// Result of a paired test of two systems.
struct SignedRank {
  std::size_t pairs = 0;  ///< without those of no difference
  double less_rank_sum = 0, greater_rank_sum = 0;
  double p = NAN;  ///< two-sided; NaN without pairs
  /// From this number of pairs on, the normal approximation is used.
  static constexpr std::size_t kMostExact = 100;
};

/// Wilcoxon's signed-rank test (Biometrics Bulletin 1945) of paired differences.
/// Differences of zero are left out, as Wilcoxon did. Tied ones share the mean of their ranks.
/// p is exact, also with ties: all 2^n signs of the ranks as they are. NaN and infinite differences are left
/// out, too.
SignedRank signed_rank_test(const std::vector<double>& differences);

/// The least p that so many pairs can have.
double least_signed_rank_p(std::size_t pairs);

}  // namespace dynfilter::eval
