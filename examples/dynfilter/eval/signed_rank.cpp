// SPDX-License-Identifier: MIT
#include "eval/signed_rank.hpp"

#include <algorithm>

namespace dynfilter::eval {
namespace {

/// Twice the rank of each absolute difference, in ascending order: with ties, ranks are halves.
std::vector<std::size_t> doubled_ranks(const std::vector<double>& sorted) {
  std::vector<std::size_t> ranks(sorted.size());
  for (std::size_t begin = 0; begin < sorted.size();) {
    std::size_t end = begin;
    while (end < sorted.size() && std::abs(sorted[end]) == std::abs(sorted[begin])) ++end;
    std::fill(ranks.begin() + static_cast<std::ptrdiff_t>(begin),
              ranks.begin() + static_cast<std::ptrdiff_t>(end), begin + 1 + end);
    begin = end;
  }
  return ranks;
}

/// Share of all choices of signs whose positive ranks sum up to at most `most`.
double share_up_to(const std::vector<std::size_t>& ranks, std::size_t most) {
  std::size_t total = 0;
  for (const std::size_t rank : ranks) total += rank;
  std::vector<double> share(total + 1, 0);
  share[0] = 1;
  for (const std::size_t rank : ranks) {
    for (std::size_t sum = total + 1; sum-- > 0;)
      share[sum] = 0.5 * (share[sum] + (sum >= rank ? share[sum - rank] : 0));
  }
  double up_to = 0;
  for (std::size_t sum = 0; sum <= most; ++sum) up_to += share[sum];
  return up_to;
}

/// With a correction for continuity. The variance is that of the ranks as they are, ties included.
double normal_p(const std::vector<std::size_t>& ranks, double smaller_sum) {
  constexpr double kContinuity = 0.5;
  double mean = 0, variance = 0;
  for (const std::size_t doubled : ranks) {
    const double rank = 0.5 * static_cast<double>(doubled);
    mean += 0.5 * rank, variance += 0.25 * rank * rank;
  }
  const double z = std::max(0.0, mean - smaller_sum - kContinuity) / std::sqrt(variance);
  return std::erfc(z / std::sqrt(2.0));
}

}  // namespace

SignedRank signed_rank_test(const std::vector<double>& differences) {
  std::vector<double> sorted;
  for (const double d : differences)
    if (std::isfinite(d) && d != 0) sorted.push_back(d);
  std::sort(sorted.begin(), sorted.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  SignedRank result;
  result.pairs = sorted.size();
  if (sorted.empty()) return result;
  const std::vector<std::size_t> ranks = doubled_ranks(sorted);
  std::size_t less = 0, greater = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) (sorted[i] < 0 ? less : greater) += ranks[i];
  result.less_rank_sum = 0.5 * static_cast<double>(less);
  result.greater_rank_sum = 0.5 * static_cast<double>(greater);
  const std::size_t smaller = std::min(less, greater);
  result.p = sorted.size() <= SignedRank::kMostExact ? std::min(1.0, 2 * share_up_to(ranks, smaller))
                                                     : normal_p(ranks, 0.5 * static_cast<double>(smaller));
  return result;
}

double least_signed_rank_p(std::size_t pairs) {
  return pairs == 0 ? 1.0 : std::min(1.0, std::ldexp(2.0, -static_cast<int>(pairs)));
}

}  // namespace dynfilter::eval
