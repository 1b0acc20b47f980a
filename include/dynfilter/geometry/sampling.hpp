// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/random.hpp>
#include <numeric>

namespace dynfilter {

/// Generator for samplers (splitmix64, Steele et al., OOPSLA 2014): one stream of 32 bits at a time.
/// `Random` is for scenes, in which every frame and point has a stream of its own.
class SampleGenerator {
 public:
  explicit SampleGenerator(std::uint64_t seed) : state_(seed) {}  ///< the same numbers for the same seed

  /// 32 random bits.
  std::uint32_t next() {
    const std::uint64_t bits = mix_bits(state_);
    state_ += kMixStep;
    return static_cast<std::uint32_t>(bits >> 32);
  }
  /// Uniform in [0, n). Requires n > 0.
  std::uint32_t below(std::uint32_t n) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(next()) * n) >> 32);
  }
  /// Uniform in [0, 1).
  double uniform() { return next() * (1.0 / 4294967296.0); }
  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Standard normal (Box-Muller).
  double normal() {
    const double radius = std::sqrt(-2.0 * portable::log(1.0 - uniform()));
    return radius * portable::cos(6.283185307179586 * uniform());
  }

 private:
  std::uint64_t state_;
};

/// Draws `count` distinct indices below `n` by rejection. Requires count <= n.
inline void sample_distinct(SampleGenerator& rng, std::uint32_t n, std::uint32_t* out, int count) {
  for (int i = 0; i < count;) {
    out[i] = rng.below(n);
    if (std::find(out, out + i, out[i]) == out + i) ++i;
  }
}

/// Iterations after which one sample has no outlier with probability `confidence` (Fischler and Bolles 1981).
/// At most `limit`. A sample has `size` elements, each an inlier with probability `inlier_share`.
inline int ransac_iterations(double inlier_share, int size, double confidence, int limit) {
  const double good = portable::power(std::min(1.0, std::max(0.0, inlier_share)), size);
  if (good <= 0) return limit;
  if (good >= 1) return 1;
  const double n = portable::log(1 - confidence) / portable::log1p(-good);
  return n < limit ? std::max(1, static_cast<int>(std::ceil(n))) : limit;
}

/// How many samples robust_search() draws.
struct SampleBudget {
  int sample_size;
  double confidence;  ///< that one sample has no outlier
  int most, least = 1;
};

/// RANSAC's loop. try_sample(k) draws sample k, solves it, scores its models and keeps the best one.
/// If the best one changes, it returns that one's share of inliers, else a negative number. `share` is the
/// share of inliers that is known before. Returns the number of samples.
template <class TrySample>
int robust_search(const SampleBudget& budget, double share, const TrySample& try_sample) {
  const auto enough = [&](double inlier_share) {
    const int samples = ransac_iterations(inlier_share, budget.sample_size, budget.confidence, budget.most);
    return std::min(budget.most, std::max(budget.least, samples));
  };
  int needed = enough(share), k = 0;
  for (; k < needed; ++k)
    if (const double better = try_sample(k); better >= 0) needed = enough(better);
  return k;
}

/// Calls visit(i) for every i below n, with steps of the golden section of n.
/// Any stretch of this order is spread over the whole range.
/// For features, which arrive sorted by position or level, it replaces a shuffle at lower cost.
template <class Visit>
void visit_spread(std::size_t n, Visit visit) {
  std::size_t step =
      std::max<std::size_t>(1, static_cast<std::size_t>(0.6180339887 * static_cast<double>(n)));
  while (std::gcd(step, n) > 1) ++step;
  for (std::size_t k = 0, i = 0; k < n; ++k) {
    visit(i);
    i += step;
    if (i >= n) i -= n;
  }
}

}  // namespace dynfilter
