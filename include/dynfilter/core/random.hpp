// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <dynfilter/core/portable_math.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

/// Step of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014) and its finaliser, which spreads every bit.
constexpr std::uint64_t kMixStep = 0x9E3779B97F4A7C15ULL;
/// A hash: neighbouring numbers give unrelated bits (splitmix64).
inline std::uint64_t mix_bits(std::uint64_t x) {
  x += kMixStep;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

/// Seeded generator with the same output on every platform, unlike the distributions of the C++ library.
/// Different streams of one seed are independent.
/// A frame therefore does not depend on the frames generated before.
class Random {
 public:
  /// The same numbers for the same seed and stream.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0)
      : state_(mix_bits(seed) ^ mix_bits(~stream)) {}

  std::uint64_t next() { return mix_bits(state_++); }                         ///< 64 random bits
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }  ///< uniform in [0, 1)
  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  bool chance(double probability) { return uniform() < probability; }  ///< true with this probability
  int below(int n) { return static_cast<int>(uniform() * n); }         ///< uniform in 0 to n - 1
  /// A pixel of an image of this size. The row is drawn first.
  cv::Point below(cv::Size size) {
    const int y = below(size.height), x = below(size.width);
    return {x, y};
  }
  /// Standard normal (Box-Muller).
  double gaussian() {
    const double radius = std::sqrt(-2.0 * portable::log(1.0 - uniform()));
    return radius * portable::cos(2.0 * CV_PI * uniform());
  }
  /// A BGR colour around `centre`. Each channel differs by at most `spread`.
  cv::Scalar colour_near(const cv::Scalar& centre, double spread) {
    cv::Scalar out;
    for (int c = 0; c < 3; ++c) out[c] = std::min(255.0, std::max(0.0, centre[c] + uniform(-spread, spread)));
    return out;
  }

 private:
  std::uint64_t state_;
};

}  // namespace dynfilter
