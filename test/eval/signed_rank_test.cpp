// SPDX-License-Identifier: MIT
#include "eval/signed_rank.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "doctest/doctest.h"

using namespace dynfilter;

namespace signed_rank_test {
namespace {

/// The definition: all 2^n signs of the ranks are equally likely. Ranks by counting, slow and obvious.
double enumerated_p(const std::vector<double>& differences) {
  std::vector<double> d, ranks;
  for (const double x : differences)
    if (x != 0) d.push_back(x);
  for (const double x : d) {
    double less = 0, equal = 0;
    for (const double y : d) less += std::abs(y) < std::abs(x), equal += std::abs(y) == std::abs(x);
    ranks.push_back(less + (equal + 1) / 2);
  }
  const auto smaller_sum = [&ranks](auto is_positive) {
    double positive = 0, all = 0;
    for (std::size_t i = 0; i < ranks.size(); ++i) all += ranks[i], positive += is_positive(i) ? ranks[i] : 0;
    return std::min(positive, all - positive);
  };
  const double seen = smaller_sum([&d](std::size_t i) { return d[i] > 0; });
  std::size_t extreme = 0;
  const std::uint32_t choices = 1U << ranks.size();
  for (std::uint32_t signs = 0; signs < choices; ++signs)
    extreme += smaller_sum([signs](std::size_t i) { return (signs >> i & 1U) != 0; }) <= seen ? 1 : 0;
  return static_cast<double>(extreme) / choices;
}

TEST_CASE("signed ranks: p equals that of all signs, with ties and zeros") {
  const std::vector<std::vector<double>> samples = {{3},
                                                    {1, -2},
                                                    {1, 2, 3, 4, 5, 6},
                                                    {-1, 2, 3, 4, 5, 6},
                                                    {1, 1, 1, 1, 1, -1},
                                                    {2, 2, -2, 3, 3, -1, 0, 0},
                                                    {0.5, -0.5, 0.5, 1.5, -1.5, 2.5, 2.5, -3, 4, 5},
                                                    {-7, 1, 2, -3, 4, 5, 6, 8, 9, -10, 11, 12}};
  for (const std::vector<double>& sample : samples) {
    CAPTURE(sample.size());
    CAPTURE(sample[0]);
    CHECK(eval::signed_rank_test(sample).p == doctest::Approx(enumerated_p(sample)).epsilon(1e-12));
  }
}

TEST_CASE("signed ranks: random samples of few values, so that most are tied") {
  std::uint32_t state = 7;
  const auto next = [&state] { return state = state * 1664525U + 1013904223U, state >> 16; };
  for (int k = 0; k < 60; ++k) {
    std::vector<double> sample(1 + next() % 11);
    for (double& x : sample) x = static_cast<double>(next() % 9) - 3;
    if (std::all_of(sample.begin(), sample.end(), [](double x) { return x == 0; })) continue;
    CAPTURE(k);
    CHECK(eval::signed_rank_test(sample).p == doctest::Approx(enumerated_p(sample)).epsilon(1e-12));
  }
}

TEST_CASE("signed ranks: the example of SciPy's manual") {
  // scipy.stats.wilcoxon: heights of cross- and self-fertilised maize (Darwin), statistic 24, p 0.04125977.
  const std::vector<double> maize = {6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75};
  const eval::SignedRank result = eval::signed_rank_test(maize);
  CHECK(result.pairs == 15);
  CHECK(result.less_rank_sum == 24);
  CHECK(result.greater_rank_sum == 96);
  CHECK(result.p == doctest::Approx(0.041259765625).epsilon(1e-12));
}

TEST_CASE("signed ranks: sums, the least p, and what is left out") {
  const eval::SignedRank tied = eval::signed_rank_test({0, 2, -2, 3, NAN, INFINITY});
  CHECK(tied.pairs == 3);
  CHECK(tied.less_rank_sum == 1.5);  // ranks 1.5, 1.5 and 3
  CHECK(tied.greater_rank_sum == 4.5);
  CHECK(std::isnan(eval::signed_rank_test({}).p));
  CHECK(std::isnan(eval::signed_rank_test({0, 0}).p));
  CHECK(eval::signed_rank_test({0, 0}).pairs == 0);
  for (std::size_t n = 1; n < 12; ++n) {
    std::vector<double> all_greater;
    for (std::size_t i = 0; i < n; ++i) all_greater.push_back(1.0 + static_cast<double>(i));
    CHECK(eval::signed_rank_test(all_greater).p == eval::least_signed_rank_p(n));
    CHECK((eval::least_signed_rank_p(n) < 0.05) == (n >= 6));
  }
}

TEST_CASE("signed ranks: the normal approximation continues the exact p") {
  const auto sample = [](std::size_t n) {  // every third difference is negative
    std::vector<double> differences;
    for (std::size_t i = 0; i < n; ++i)
      differences.push_back((i % 3 == 0 ? -1.0 : 1.0) * (1.0 + 0.01 * static_cast<double>(i)));
    return differences;
  };
  const double exact = eval::signed_rank_test(sample(eval::SignedRank::kMostExact)).p;
  const double normal = eval::signed_rank_test(sample(eval::SignedRank::kMostExact + 1)).p;
  CHECK(exact < 0.01);
  CHECK(normal == doctest::Approx(exact).epsilon(0.25));
  CHECK(eval::signed_rank_test(sample(3000)).p < 1e-9);
}

}  // namespace
}  // namespace signed_rank_test
