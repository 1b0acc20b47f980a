// SPDX-License-Identifier: MIT
#include <dynfilter/geometry/sampling.hpp>
#include <vector>

#include "doctest/doctest.h"

namespace sampling_test {

using namespace dynfilter;

namespace {

constexpr double kNoBetter = -1;

/// Samples drawn if the k-th one gives shares[k], and no sample after them a better model.
int samples(const SampleBudget& budget, double share, const std::vector<double>& shares) {
  return robust_search(budget, share, [&](int k) {
    return k < static_cast<int>(shares.size()) ? shares[static_cast<std::size_t>(k)] : kNoBetter;
  });
}

}  // namespace

TEST_CASE("robust search: all samples without a model, fewer with a better one") {
  // Half of the matches fit: a sample of two is good once in four. 1 - (3 / 4)^n reaches 0.9 at n = 9.
  const SampleBudget budget{2, 0.9, 100};
  CHECK(samples(budget, 0, {}) == 100);
  CHECK(samples(budget, 0, {kNoBetter, kNoBetter, 0.5}) == 9);
  CHECK(samples(budget, 0.5, {}) == 9);
  // 0.9: once in 1.23; 1 - 0.19^n reaches 0.9 at n = 2.
  CHECK(samples(budget, 0, {0.5, 0.9}) == 2);
  CHECK(samples(budget, 0, {kNoBetter, 0.5, kNoBetter, kNoBetter, 0.9}) == 5);  // four were drawn already
  CHECK(samples(budget, 0, {1}) == 1);
  CHECK(samples(budget, 0, {0}) == 100);
}

TEST_CASE("robust search: the last better model counts, between the least and the most samples") {
  CHECK(samples({2, 0.9, 100}, 0, {0.9, 0.5}) == 9);
  CHECK(samples({2, 0.9, 5}, 0, {0.5}) == 5);
  CHECK(samples({2, 0.9, 100, 20}, 0, {0.9}) == 20);
  CHECK(samples({2, 0.9, 10, 20}, 0, {0.9}) == 10);
  CHECK(samples({2, 0.9, 0}, 0, {}) == 0);
}

}  // namespace sampling_test
